use proptest::prelude::*;

use super::*;

fn party(name: &str) -> Party {
    Some(name.into())
}

/// Takes everything, one after another on one worker, and returns the parties in that order.
fn served(turns: &mut Turns<u32>) -> String {
    let mut order = String::new();
    while let Some((party, _)) = turns.take() {
        order.push_str(party.as_deref().unwrap_or("-"));
        turns.finished(&party);
    }
    order
}

#[test]
fn parties_have_turns_and_each_its_oldest_first() {
    let mut turns = Turns::new(100, 1, 0.5);
    for k in 0..5 {
        turns.push(party("a"), k).unwrap();
    }
    turns.push(party("b"), 10).unwrap();
    turns.push(None, 20).unwrap();
    turns.push(party("b"), 11).unwrap();
    let mut taken = Vec::new();
    while let Some((whose, item)) = turns.take() {
        turns.finished(&whose);
        taken.push(item);
    }
    assert_eq!(taken, [0, 10, 20, 1, 11, 2, 3, 4]);
    assert!(turns.lanes.is_empty() && turns.order.is_empty(), "nobody is remembered");
}

#[test]
fn a_party_alone_has_everything() {
    let mut turns = Turns::new(4, 4, 0.5);
    for k in 0..4 {
        assert_eq!(turns.push(party("a"), k), Ok(None));
    }
    assert_eq!(turns.push(party("a"), 4), Err(NoPlace::Full));
    assert!((0..4).all(|_| turns.take().is_some()), "four workers, all for one");
    assert!(turns.is_empty());
}

#[test]
fn a_party_above_its_share_of_workers_waits_for_those_below() {
    let mut turns = Turns::new(100, 4, 0.5);
    for k in 0..8 {
        turns.push(party("a"), k).unwrap();
    }
    for _ in 0..4 {
        turns.take().unwrap();
    }
    turns.push(party("b"), 10).unwrap();
    turns.push(party("b"), 11).unwrap();
    turns.push(party("b"), 12).unwrap();
    // two of the four end: both go to the other, although it had its turn
    for expected in [10, 11] {
        turns.finished(&party("a"));
        assert_eq!(turns.take(), Some((party("b"), expected)));
    }
    // both have their share now, and a worker is free all the same
    assert!(turns.take().is_some());
}

#[test]
fn the_queue_is_shared_while_others_wait() {
    let mut turns = Turns::new(8, 1, 0.5);
    for k in 0..6 {
        turns.push(party("a"), k).unwrap();
    }
    turns.push(party("b"), 10).unwrap();
    assert_eq!(turns.push(party("a"), 6), Err(NoPlace::Share), "it has more than half, and another waits");
    for k in 11..13 {
        turns.push(party("b"), k).unwrap();
    }
    // 6 + 3 > 8: the youngest of the one with most made way
    assert_eq!((turns.len(), turns.waiting_of(&party("a"))), (8, 5));
    assert_eq!(served(&mut turns), "abababaa");
}

#[test]
fn who_asks_for_little_is_not_refused_for_one_who_asks_for_much() {
    let mut turns = Turns::new(4, 1, 0.5);
    for k in 0..4 {
        turns.push(party("a"), k).unwrap();
    }
    assert!(!turns.has_room(&party("b")));
    assert_eq!(turns.push(party("b"), 10), Ok(Some(3)));
    assert_eq!(turns.push(party("c"), 20), Ok(Some(2)));
    // no place goes to and fro between equals
    assert_eq!(turns.push(party("b"), 11), Err(NoPlace::Full));
    assert_eq!(served(&mut turns), "abca");
}

#[test]
fn what_nobody_wants_any_more_gives_its_place_back() {
    let mut turns = Turns::new(4, 1, 0.5);
    for k in 0..4 {
        turns.push(party(if k % 2 == 0 { "a" } else { "b" }), k).unwrap();
    }
    assert_eq!(turns.retain(|k| k % 2 == 0), 2);
    assert_eq!((turns.len(), turns.order.len()), (2, 1));
    turns.take().unwrap();
    assert_eq!(turns.drain(), [2]);
    assert!(turns.is_empty() && turns.order.is_empty() && turns.lanes.len() == 1);
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
    /// Against a list that is searched: nothing is lost or done twice, each party's come in their
    /// order, no worker is idle while something waits, and who is at its share has no worker while
    /// another is below.
    #[test]
    fn every_history_keeps_the_law(
        limit in 1..9_usize, workers in 1..6_usize, share in 0.05..1.0_f64,
        steps in proptest::collection::vec(step(), 1..200),
    ) {
        let mut turns = Turns::new(limit, workers, share);
        let (mut waiting, mut running): (Vec<(Party, u32)>, Vec<Party>) = Default::default();
        let most = ((share * workers as f64) as usize).max(1);
        let places = ((share * limit as f64) as usize).max(1);
        for (number, step) in (0..).zip(steps) {
            let count = |list: &[(Party, u32)], whose: &Party| list.iter().filter(|(party, _)| party == whose).count();
            let at_work = |list: &[Party], whose: &Party| list.iter().filter(|party| *party == whose).count();
            match step {
                Step::Push(which) => {
                    let own = count(&waiting, &name(which));
                    let longest = waiting.iter().map(|(party, _)| count(&waiting, party)).max().unwrap_or(0);
                    match turns.push(name(which), number) {
                        Ok(None) => prop_assert!(waiting.len() < limit),
                        Ok(Some(gone)) => {
                            let at = waiting.iter().position(|(_, item)| *item == gone).unwrap();
                            let (loser, _) = waiting.remove(at);
                            prop_assert_eq!(count(&waiting, &loser) + 1, longest);
                            prop_assert!(longest > own + 1 && waiting.len() + 1 == limit);
                            prop_assert!(!waiting[at..].iter().any(|(party, _)| *party == loser), "its youngest");
                        }
                        Err(NoPlace::Full) => {
                            prop_assert!(waiting.len() == limit && longest <= own + 1);
                            continue;
                        }
                        Err(NoPlace::Share) => {
                            prop_assert!(own >= places && waiting.len() > own);
                            continue;
                        }
                    }
                    waiting.push((name(which), number));
                }
                Step::Take if running.len() < workers => {
                    let Some((party, item)) = turns.take() else {
                        prop_assert!(waiting.is_empty(), "a worker is idle");
                        continue;
                    };
                    let first = waiting.iter().position(|(whose, _)| *whose == party).unwrap();
                    prop_assert_eq!(waiting[first].1, item);
                    let below = waiting.iter().any(|(whose, _)| at_work(&running, whose) < most);
                    prop_assert!(!below || at_work(&running, &party) < most);
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
                    prop_assert_eq!(turns.retain(|item| !of.contains(item)), of.len());
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
        let mut turns = Turns::new(1000, 1, 1.0);
        for (which, length) in lengths.iter().enumerate() {
            (0..*length as u32).for_each(|k| { turns.push(name(which as u8), k).unwrap(); });
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
