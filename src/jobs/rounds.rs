//! Rounds of a job: what was measured between one correction and the next.
//!
//! A correction ends a round when something is measured after it: one that is made again with other
//! limits before the gear is back on the machine is made for the same measurements. When changes
//! were entered on the machine is not asked, since entries may come at any time later.

use std::collections::BTreeMap;

use flankfit_engine::gear::{Side, tooth};
use jiff::Timestamp;
use uuid::Uuid;

use super::{
    measurand::{Measurand, side_name},
    record::RecordKind,
};

/// An iteration of a job; without its axes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeasuredIteration {
    pub number: u32,
    pub measurand: Measurand,
    pub created_at: Timestamp,
}

/// A correction of a job, of an iteration or of the gear.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MadeCorrection {
    /// Its iteration.
    pub number: u32,
    pub id: Uuid,
    pub kind: RecordKind,
    pub created_at: Timestamp,
}

/// Iterations by their numbers, corrections in the order in which they were made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rounds {
    pub iterations: Vec<MeasuredIteration>,
    pub corrections: Vec<MadeCorrection>,
}

impl MeasuredIteration {
    /// Returns whether it was measured after the correction.
    fn is_after(&self, correction: &MadeCorrection) -> bool {
        (self.created_at, self.number) > (correction.created_at, correction.number)
    }
}

impl Rounds {
    /// The newest correction of the gear.
    pub fn newest_of_gear(&self) -> Option<&MadeCorrection> {
        self.corrections.iter().rfind(|correction| correction.kind == RecordKind::GearCorrection)
    }

    /// Returns the newest correction of the iteration `from`, or of the gear between it and the
    /// iteration `to`, where `None` is one that is about to be stored.
    pub fn made_between(&self, from: u32, to: Option<u32>) -> Option<&MadeCorrection> {
        let numbered = |number: u32| self.iterations.iter().find(|one| one.number == number);
        let (from, to) = (numbered(from)?, to.and_then(numbered));
        self.corrections.iter().rfind(|correction| match correction.kind {
            RecordKind::GearCorrection => !from.is_after(correction) && to.is_none_or(|to| to.is_after(correction)),
            _ => correction.number == from.number,
        })
    }

    /// The newest iteration of each tooth of each flank that was measured since the last correction
    /// that a measurement followed.
    pub fn current(&self) -> Vec<&MeasuredIteration> {
        let followed = |correction: &&MadeCorrection| self.iterations.iter().any(|one| one.is_after(correction));
        let last = self.corrections.iter().rfind(followed);
        newest_of_teeth(self.iterations.iter().filter(|one| last.is_none_or(|last| one.is_after(last))))
    }

    /// The same of what was measured after a correction and before the next one that a measurement
    /// followed.
    pub fn after(&self, correction: &MadeCorrection) -> Vec<&MeasuredIteration> {
        let place = self.corrections.iter().position(|made| made.id == correction.id);
        let later = self.corrections.iter().skip(place.map_or(0, |place| place + 1));
        let all = || self.iterations.iter().filter(|one| one.is_after(correction));
        // the first later correction that some of it was made for
        let next = later.clone().find(|next| all().any(|one| !one.is_after(next)));
        newest_of_teeth(all().filter(|one| next.is_none_or(|next| !one.is_after(next))))
    }

    /// The newest iteration of the other flank than that of `measurand`.
    pub fn newest_of_other_flank(&self, measurand: &Measurand) -> Option<&MeasuredIteration> {
        let other = match measurand.flank? {
            Side::Left => Side::Right,
            Side::Right => Side::Left,
        };
        self.iterations.iter().rfind(|one| one.measurand.flank == Some(other))
    }
}

/// By flank, then by number.
fn newest_of_teeth<'a>(iterations: impl Iterator<Item = &'a MeasuredIteration>) -> Vec<&'a MeasuredIteration> {
    let mut newest = BTreeMap::new();
    for one in iterations {
        let Some(side) = one.measurand.flank else { continue };
        let name = one.measurand.tooth.as_ref().map(|name| tooth::canonical(name).unwrap_or(name.clone()));
        newest.insert((side_name(side), name), one);
    }
    let mut found: Vec<&MeasuredIteration> = newest.into_values().collect();
    found.sort_by_key(|one| (one.measurand.flank.map(side_name), one.number));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(second: i64) -> Timestamp {
        Timestamp::from_second(second).unwrap()
    }

    fn iteration(number: u32, second: i64, flank: Side, tooth: &str) -> MeasuredIteration {
        let measurand = Measurand { flank: Some(flank), tooth: Some(tooth.to_owned()), ..Measurand::default() };
        MeasuredIteration { number, measurand, created_at: at(second) }
    }

    fn correction(number: u32, second: i64, kind: RecordKind) -> MadeCorrection {
        MadeCorrection { number, id: Uuid::from_u128(second as u128), kind, created_at: at(second) }
    }

    fn numbers(found: Vec<&MeasuredIteration>) -> Vec<u32> {
        found.into_iter().map(|one| one.number).collect()
    }

    #[test]
    fn a_round_has_the_newest_iteration_of_each_tooth_since_the_last_correction() {
        let mut rounds = Rounds {
            iterations: vec![
                iteration(1, 1, Side::Right, "1"),
                iteration(2, 2, Side::Left, "1"),
                iteration(3, 3, Side::Left, "2"),
                iteration(4, 4, Side::Left, "1"),
            ],
            corrections: Vec::new(),
        };
        rounds.iterations[0].measurand.flank = None;
        assert_eq!(numbers(rounds.current()), [3, 4], "what is of no flank takes no part");
        rounds.iterations[0].measurand.flank = Some(Side::Right);
        assert_eq!(numbers(rounds.current()), [3, 4, 1]);
        assert_eq!(rounds.newest_of_gear(), None);
        // made again before anything is measured, it is made for the same
        rounds.corrections =
            vec![correction(4, 5, RecordKind::GearCorrection), correction(2, 6, RecordKind::Correction)];
        assert_eq!(numbers(rounds.current()), [3, 4, 1]);
        let [first, second] = [rounds.corrections[0].clone(), rounds.corrections[1].clone()];
        assert_eq!((rounds.newest_of_gear(), rounds.after(&first)), (Some(&first), Vec::new()));
        // the next round, a correction, and one more round
        rounds.iterations.extend([iteration(5, 7, Side::Left, "2"), iteration(6, 8, Side::Left, "2")]);
        assert_eq!(numbers(rounds.current()), [6]);
        assert_eq!((numbers(rounds.after(&first)), numbers(rounds.after(&second))), (vec![6], vec![6]));
        rounds.corrections.push(correction(6, 9, RecordKind::Correction));
        rounds.iterations.push(iteration(7, 10, Side::Right, "1"));
        assert_eq!(numbers(rounds.current()), [7]);
        assert_eq!(numbers(rounds.after(&first)), [6]);
        // of the gear: made between 4 and 5; the other one is of iteration 2
        assert_eq!((rounds.made_between(1, Some(5)), rounds.made_between(2, Some(5))), (Some(&first), Some(&second)));
        assert_eq!((rounds.made_between(4, None), rounds.made_between(5, None)), (Some(&first), None));
        assert_eq!((rounds.made_between(1, Some(4)), rounds.made_between(9, None)), (None, None));
        let left = &rounds.iterations[1].measurand;
        assert_eq!(rounds.newest_of_other_flank(left).map(|one| one.number), Some(7));
        assert_eq!(rounds.newest_of_other_flank(&Measurand::default()), None);
    }
}
