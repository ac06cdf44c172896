//! Queues of waiting work by party: whose turn is next, and who is refused.
//!
//! Each party has a queue of its own, so that it is never refused for another. A free worker takes
//! the oldest work of the party with the fewest workers, and parties with equally many take turns:
//! a party has no more workers than another that waits, and alone it has all of them.

use std::{collections::VecDeque, sync::Arc};

/// For whom work is done; none of work without a party.
pub type Party = Option<Arc<str>>;

/// See the module's documentation.
#[derive(Debug)]
pub struct Turns<T> {
    /// Places of each queue.
    limit: usize,
    /// Parties with waiting or running work, in the order of their turns.
    lanes: Vec<Lane<T>>,
}

/// Waiting and running work of one party.
#[derive(Debug)]
struct Lane<T> {
    party: Party,
    waiting: VecDeque<T>,
    running: usize,
}

impl<T> Turns<T> {
    pub fn new(limit: usize) -> Self {
        Turns { limit, lanes: Vec::new() }
    }

    /// Number of all that wait.
    pub fn len(&self) -> usize {
        self.lanes.iter().map(|lane| lane.waiting.len()).sum()
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub fn is_full(&self, party: &Party) -> bool {
        self.lanes.iter().any(|lane| lane.party == *party && lane.waiting.len() >= self.limit)
    }

    pub fn push(&mut self, party: Party, item: T) {
        match self.lanes.iter_mut().find(|lane| lane.party == party) {
            Some(lane) => lane.waiting.push_back(item),
            None => self.lanes.push(Lane { party, waiting: [item].into(), running: 0 }),
        }
    }

    /// Takes the next work and its party. It counts as running until [`Turns::finished`].
    pub fn take(&mut self) -> Option<(Party, T)> {
        let waiting = self.lanes.iter().enumerate().filter(|(_, lane)| !lane.waiting.is_empty());
        let (next, _) = waiting.min_by_key(|(_, lane)| lane.running)?;
        let mut lane = self.lanes.remove(next);
        let item = lane.waiting.pop_front()?;
        let party = lane.party.clone();
        lane.running += 1;
        self.lanes.push(lane);
        Some((party, item))
    }

    /// Counts work that was taken as done.
    pub fn finished(&mut self, party: &Party) {
        self.lanes.iter_mut().filter(|lane| lane.party == *party).for_each(|lane| lane.running -= 1);
        self.forget();
    }

    /// Removes and returns the waiting work for which `gone` is true.
    pub fn remove(&mut self, mut gone: impl FnMut(&T) -> bool) -> Vec<T> {
        let mut removed = Vec::new();
        for lane in &mut self.lanes {
            let (out, kept): (VecDeque<T>, VecDeque<T>) = lane.waiting.drain(..).partition(&mut gone);
            removed.extend(out);
            lane.waiting = kept;
        }
        self.forget();
        removed
    }

    /// Removes all waiting work.
    pub fn drain(&mut self) -> Vec<T> {
        let all = self.lanes.iter_mut().flat_map(|lane| lane.waiting.drain(..)).collect();
        self.forget();
        all
    }

    /// Forgets parties without work.
    fn forget(&mut self) {
        self.lanes.retain(|lane| lane.running > 0 || !lane.waiting.is_empty());
    }
}

#[cfg(test)]
mod tests;
