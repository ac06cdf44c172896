//! For how long something of the audit has been in no seal.

use std::{
    collections::VecDeque,
    time::{Duration, Instant},
};

use crate::jobs::audit::Unsealed;

/// The age of the oldest entry that no seal holds, as it is known by looks at the audit. The times
/// of entries do not matter: clocks of servers differ, and entries of imported jobs are old.
pub struct SealAge {
    /// How far the audit went when it was looked at, and when that was: at first the last look
    /// before the oldest entry that no seal held was stored.
    looks: VecDeque<(i64, Instant)>,
    /// Since when an entry may be in no seal.
    unsealed: Option<Instant>,
    /// Since when an entry may be in none of the seals that were written to their file.
    unwritten: Option<Instant>,
}

impl SealAge {
    /// Entries from before the start count from the start.
    pub fn begin(start: Instant) -> Self {
        SealAge { looks: [(0, start)].into(), unsealed: None, unwritten: None }
    }

    /// Nobody knows whether all is sealed until the audit was looked at.
    pub fn turn(&mut self) {
        self.unsealed = self.first();
    }

    /// There are seals that are not in their file yet.
    pub fn made(&mut self) {
        self.unwritten = self.unwritten.or(self.first());
    }

    /// All seals are in their file.
    pub fn written(&mut self) {
        self.unwritten = None;
    }

    /// What a look at the audit told that began at a time.
    pub fn looked(&mut self, told: Unsealed, at: Instant) {
        match told.oldest {
            None => self.looks.clear(),
            Some(oldest) => {
                while self.looks.get(1).is_some_and(|(next, _)| *next <= oldest) {
                    self.looks.pop_front();
                }
            }
        }
        self.unsealed = told.oldest.and(self.first());
        self.looks.push_back((told.next, at));
    }

    pub fn at(&self, now: Instant) -> Duration {
        let since = self.unsealed.into_iter().chain(self.unwritten).min();
        since.map_or(Duration::ZERO, |since| now.saturating_duration_since(since))
    }

    fn first(&self) -> Option<Instant> {
        self.looks.front().map(|(_, at)| *at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ages in seconds, with a look at the audit every ten seconds.
    struct Watched {
        start: Instant,
        age: SealAge,
    }

    impl Watched {
        fn new() -> Self {
            let start = Instant::now();
            Watched { start, age: SealAge::begin(start) }
        }

        fn second(&self, second: u64) -> Instant {
            self.start + Duration::from_secs(second)
        }

        fn look(&mut self, second: u64, next: i64, oldest: Option<i64>) -> u64 {
            self.age.turn();
            self.age.looked(Unsealed { next, oldest }, self.second(second));
            self.at(second)
        }

        fn at(&self, second: u64) -> u64 {
            self.age.at(self.second(second)).as_secs()
        }
    }

    #[test]
    fn it_rises_while_entries_are_held_back() {
        let mut watched = Watched::new();
        assert_eq!(watched.look(10, 100, None), 0);
        assert_eq!(watched.at(19), 0);
        // stored between the looks, so after the first of them
        assert_eq!(watched.look(20, 105, Some(103)), 10);
        assert_eq!(watched.look(30, 110, Some(103)), 20);
        assert_eq!(watched.at(700), 690);
        // that one is sealed, younger ones are not
        assert_eq!(watched.look(710, 120, Some(107)), 690);
        assert_eq!(watched.look(720, 130, Some(121)), 10);
        assert_eq!(watched.look(730, 130, None), 0);
    }

    #[test]
    fn entries_from_before_the_start_count_from_the_start() {
        let mut watched = Watched::new();
        assert_eq!(watched.look(10, 100, Some(3)), 10);
        assert_eq!(watched.look(20, 100, Some(3)), 20);
        assert_eq!(watched.look(30, 100, None), 0);
    }

    #[test]
    fn it_rises_while_nobody_can_look() {
        let mut watched = Watched::new();
        watched.look(10, 100, None);
        watched.age.turn();
        assert_eq!((watched.at(20), watched.at(500)), (10, 490));
        assert_eq!(watched.look(510, 100, None), 0);
    }

    #[test]
    fn it_rises_while_seals_are_not_in_their_file() {
        let mut watched = Watched::new();
        watched.look(10, 100, None);
        watched.age.made();
        assert_eq!(watched.look(20, 105, None), 10);
        watched.age.made();
        assert_eq!(watched.look(30, 110, None), 20);
        watched.age.written();
        assert_eq!(watched.look(40, 110, None), 0);
    }
}
