use proptest::prelude::*;

use super::*;

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
