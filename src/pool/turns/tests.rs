use proptest::prelude::*;

use super::*;

fn party(name: &str) -> Party {
    Some(name.into())
}

#[test]
fn parties_have_turns_and_each_its_oldest_first() {
    let mut turns = Turns::new(100);
    for k in 0..5 {
        turns.push(party("a"), k);
    }
    turns.push(party("b"), 10);
    turns.push(None, 20);
    turns.push(party("b"), 11);
    let mut taken = Vec::new();
    while let Some((whose, item)) = turns.take() {
        turns.finished(&whose);
        taken.push(item);
    }
    assert_eq!(taken, [0, 10, 20, 1, 11, 2, 3, 4]);
    assert!(turns.lanes.is_empty(), "nobody is remembered");
}

#[test]
fn a_party_with_more_workers_waits_for_those_with_fewer() {
    let mut turns = Turns::new(100);
    (0..8).for_each(|k| turns.push(party("a"), k));
    assert!((0..4).all(|_| turns.take().is_some()), "four workers, all for one");
    (10..13).for_each(|k| turns.push(party("b"), k));
    // two of the four end: both go to the other, although it had its turn
    for expected in [10, 11] {
        turns.finished(&party("a"));
        assert_eq!(turns.take(), Some((party("b"), expected)));
    }
    // both have two now, and take turns
    turns.finished(&party("a"));
    turns.finished(&party("b"));
    assert_eq!((turns.take(), turns.take()), (Some((party("a"), 4)), Some((party("b"), 12))));
}

#[test]
fn removed_work_gives_its_place_back() {
    let mut turns = Turns::new(2);
    for k in 0..4 {
        turns.push(party(if k % 2 == 0 { "a" } else { "b" }), k);
    }
    assert!(turns.is_full(&party("a")) && turns.is_full(&party("b")) && !turns.is_full(&None));
    assert_eq!(turns.remove(|k| k % 2 == 1).len(), 2);
    assert!(turns.is_full(&party("a")) && !turns.is_full(&party("b")) && turns.len() == 2);
    turns.take().unwrap();
    assert_eq!(turns.drain(), [2]);
    assert!(turns.is_empty() && turns.lanes.len() == 1);
    turns.finished(&party("a"));
    assert!(turns.lanes.is_empty());
}

/// Event at a queue.
#[derive(Clone, Copy, Debug)]
enum Step {
    Push(u8),
    Take,
    Finish(usize),
    GiveUp(u8),
}

fn step() -> impl Strategy<Value = Step> {
    prop_oneof![
        4 => (0..4_u8).prop_map(Step::Push),
        3 => Just(Step::Take),
        2 => (0..8_usize).prop_map(Step::Finish),
        1 => (0..4_u8).prop_map(Step::GiveUp),
    ]
}

fn name(which: u8) -> Party {
    (which > 0).then(|| which.to_string().into())
}

proptest! {
    /// Against a list that is searched: nothing is lost or done twice, each party's work comes in
    /// its order, no worker is idle while something waits, and no party with fewer workers waits.
    #[test]
    fn every_history_keeps_the_law(workers in 1..6_usize, steps in proptest::collection::vec(step(), 1..200)) {
        let mut turns = Turns::new(4);
        let (mut waiting, mut running): (Vec<(Party, u32)>, Vec<Party>) = Default::default();
        for (number, step) in (0..).zip(steps) {
            let at_work = |list: &[Party], whose: &Party| list.iter().filter(|party| *party == whose).count();
            match step {
                Step::Push(which) => {
                    let own = waiting.iter().filter(|(party, _)| *party == name(which)).count();
                    prop_assert_eq!(turns.is_full(&name(which)), own == 4);
                    if own < 4 {
                        turns.push(name(which), number);
                        waiting.push((name(which), number));
                    }
                }
                Step::Take if running.len() < workers => {
                    let Some((party, item)) = turns.take() else {
                        prop_assert!(waiting.is_empty(), "a worker is idle");
                        continue;
                    };
                    let first = waiting.iter().position(|(whose, _)| *whose == party).unwrap();
                    prop_assert_eq!(waiting[first].1, item);
                    let fewest = waiting.iter().map(|(whose, _)| at_work(&running, whose)).min();
                    prop_assert_eq!(Some(at_work(&running, &party)), fewest);
                    waiting.remove(first);
                    running.push(party);
                }
                Step::Take => {}
                Step::Finish(which) => {
                    if which < running.len() {
                        turns.finished(&running.swap_remove(which));
                    }
                }
                Step::GiveUp(which) => {
                    let of: Vec<u32> = waiting.iter().filter(|(p, _)| *p == name(which)).map(|(_, k)| *k).collect();
                    prop_assert_eq!(turns.remove(|item| of.contains(item)).len(), of.len());
                    waiting.retain(|(party, _)| *party != name(which));
                }
            }
            prop_assert_eq!(turns.len(), waiting.len());
        }
    }

    /// However much the others have, whoever waits is served within as many turns as there are
    /// parties.
    #[test]
    fn nobody_starves(lengths in proptest::collection::vec(1..20_usize, 1..6)) {
        let mut turns = Turns::new(1000);
        for (which, length) in lengths.iter().enumerate() {
            (0..*length as u32).for_each(|k| turns.push(name(which as u8), k));
        }
        let mut last = vec![0; lengths.len()];
        let mut left = lengths.clone();
        for turn in 1.. {
            let Some((party, _)) = turns.take() else { break };
            turns.finished(&party);
            let which = party.map_or(0, |name| name.parse::<usize>().unwrap());
            prop_assert!(turn - last[which] <= lengths.len());
            (last[which], left[which]) = (turn, left[which] - 1);
        }
        prop_assert!(left.iter().all(|left| *left == 0));
    }
}
