//! Queues of waiting work by party: whose turn is next, and who is refused.
//!
//! Waiting parties take turns, each with its oldest work. If several wait, none of them gets more
//! workers than its share while another is below; but no worker is idle as long as anything waits.
//! A party may use all places of the queue while it alone waits, and its share while others do.
//! When the queue is full, a party with less waiting than another takes the place of the youngest
//! work of the party with most: a party with few requests is never refused for one with many.

use std::{
    collections::{HashMap, VecDeque},
    sync::Arc,
};

/// For whom work is done; none of work without a party.
pub type Party = Option<Arc<str>>;

/// Reason why work may not wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoPlace {
    /// Every place is taken, and no party has more of them than this one.
    Full,
    /// The party has its share, and others wait.
    Share,
}

/// See the module's documentation.
#[derive(Debug)]
pub struct Turns<T> {
    /// Places of the queue, and those that one of several parties may take.
    limit: usize,
    places: usize,
    /// Workers that one of several parties may have.
    workers: usize,
    lanes: HashMap<Party, Lane<T>>,
    /// Parties that have something waiting, in the order of their turns.
    order: VecDeque<Party>,
    waiting: usize,
}

/// Waiting and running work of one party.
#[derive(Debug)]
struct Lane<T> {
    waiting: VecDeque<T>,
    running: usize,
}

/// A part of several, at least one.
fn part(share: f64, of: usize) -> usize {
    ((share * of as f64) as usize).clamp(1, of.max(1))
}

impl<T> Turns<T> {
    /// A queue of `limit` places for so many workers; `share` is what a party may have of both.
    pub fn new(limit: usize, workers: usize, share: f64) -> Self {
        Turns {
            limit,
            places: part(share, limit),
            workers: part(share, workers),
            lanes: HashMap::new(),
            order: VecDeque::new(),
            waiting: 0,
        }
    }

    pub fn len(&self) -> usize {
        self.waiting
    }

    pub fn is_empty(&self) -> bool {
        self.waiting == 0
    }

    /// True if the party may have something wait without anybody losing a place.
    pub fn has_room(&self, party: &Party) -> bool {
        self.waiting < self.limit && self.check_share(self.waiting_of(party)).is_ok()
    }

    /// Checks that work of the party may wait, perhaps in the place of other work.
    pub fn check(&self, party: &Party) -> Result<(), NoPlace> {
        let own = self.waiting_of(party);
        self.check_share(own)?;
        if self.waiting < self.limit || self.longest().is_some_and(|(_, length)| length > own + 1) {
            return Ok(());
        }
        Err(NoPlace::Full)
    }

    /// Has something wait. Where that takes the place of something else, it gives that back.
    pub fn push(&mut self, party: Party, item: T) -> Result<Option<T>, NoPlace> {
        self.check(&party)?;
        let displaced = if self.waiting < self.limit { None } else { self.displace() };
        let lane = self.lanes.entry(party.clone()).or_insert_with(|| Lane { waiting: VecDeque::new(), running: 0 });
        if lane.waiting.is_empty() {
            self.order.push_back(party);
        }
        lane.waiting.push_back(item);
        self.waiting += 1;
        Ok(displaced)
    }

    /// Takes the next work and its party. It counts as running until [`Turns::finished`].
    pub fn take(&mut self) -> Option<(Party, T)> {
        let below = |party: &Party| self.lanes.get(party).is_none_or(|lane| lane.running < self.workers);
        let next = self.order.iter().position(below).unwrap_or(0);
        let party = self.order.remove(next)?;
        let lane = self.lanes.get_mut(&party)?;
        let item = lane.waiting.pop_front()?;
        lane.running += 1;
        self.waiting -= 1;
        if !lane.waiting.is_empty() {
            self.order.push_back(party.clone());
        }
        Some((party, item))
    }

    /// Something that was taken is done.
    pub fn finished(&mut self, party: &Party) {
        if let Some(lane) = self.lanes.get_mut(party) {
            lane.running = lane.running.saturating_sub(1);
            if lane.running == 0 && lane.waiting.is_empty() {
                self.lanes.remove(party);
            }
        }
    }

    /// Lets go what need not wait any more; gives how many that were.
    pub fn retain(&mut self, mut keep: impl FnMut(&T) -> bool) -> usize {
        let before = self.waiting;
        self.lanes.values_mut().for_each(|lane| lane.waiting.retain(&mut keep));
        self.settle();
        before - self.waiting
    }

    /// Lets go everything that waits.
    pub fn drain(&mut self) -> Vec<T> {
        let all = self.lanes.values_mut().flat_map(|lane| lane.waiting.drain(..)).collect();
        self.settle();
        all
    }

    /// Makes order and count those of what waits.
    fn settle(&mut self) {
        self.lanes.retain(|_, lane| lane.running > 0 || !lane.waiting.is_empty());
        self.order.retain(|party| self.lanes.get(party).is_some_and(|lane| !lane.waiting.is_empty()));
        self.waiting = self.lanes.values().map(|lane| lane.waiting.len()).sum();
    }

    fn waiting_of(&self, party: &Party) -> usize {
        self.lanes.get(party).map_or(0, |lane| lane.waiting.len())
    }

    /// Checks that a party with so much waiting is below its share, if others wait.
    fn check_share(&self, own: usize) -> Result<(), NoPlace> {
        let others = self.waiting - own;
        if others > 0 && own >= self.places { Err(NoPlace::Share) } else { Ok(()) }
    }

    /// Party with most waiting, and its amount.
    fn longest(&self) -> Option<(&Party, usize)> {
        self.order.iter().map(|party| (party, self.waiting_of(party))).max_by_key(|(_, length)| *length)
    }

    /// Takes the youngest of whoever has most waiting.
    fn displace(&mut self) -> Option<T> {
        let most = self.longest()?.0.clone();
        let item = self.lanes.get_mut(&most)?.waiting.pop_back()?;
        self.waiting -= 1;
        Some(item)
    }
}

#[cfg(test)]
mod tests;
