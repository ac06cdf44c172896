//! Measurements before and after an iteration, of the same flank and tooth.

use std::sync::Arc;

use flankfit::jobs::{
    Choice, Event, MadeCorrection, Measurand, NewIteration, Precondition, Predecessor, Predecessors, Record,
    RecordKind, RepositoryError, Resource, Successors,
};
use flankfit_engine::gear::Side;
use uuid::Uuid;

use super::pair::Pair;
use crate::support::actor;

fn of(flank: Side, tooth: &str) -> Measurand {
    Measurand {
        flank: Some(flank),
        tooth: Some(tooth.to_owned()),
        axes: Some(Arc::from(r#"{"u":{}}"#)),
        accept_units: false,
    }
}

pub async fn neighbours_are_of_the_same_flank_and_tooth(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    let [left, right, none] = [of(Side::Left, "3"), of(Side::Right, "3"), Measurand::default()];
    let mut fits: Vec<Uuid> = Vec::new();
    for measurand in [&left, &right, &none, &left, &right, &left, &none] {
        let iteration = NewIteration { measurand: measurand.clone(), ..NewIteration::clone(&place.iteration(job)) };
        fits.push(iteration.fit.id);
        store.insert_iteration(Arc::new(iteration), None).await.unwrap();
    }
    // another fit of iteration 4 is chosen by now
    let refit = Arc::new(place.fit(0.5));
    store.insert_fit(job, 4, refit.clone(), None).await.unwrap();
    let event = Event { reason: None, by: actor(), created_at: place.now() };
    store.choose(job, 4, Choice { fit_id: refit.id, event }, Precondition::None).await.unwrap();
    let one = |number: u32, fit_id| Predecessor { number, measurand: left.clone(), fit_id };
    let all = [one(1, fits[0]), one(4, refit.id), one(6, fits[5])];

    let found = async |of: &Measurand, from, before, most| {
        store.predecessors(job, Predecessors { of: of.clone(), from, before, most }).await.unwrap()
    };
    assert_eq!(found(&left, 1, None, 10).await, all);
    assert_eq!(found(&left, 1, None, 2).await, all[1..], "of many the last");
    assert_eq!(found(&left, 2, Some(6), 10).await, all[1..2]);
    assert_eq!(found(&left, 7, None, 10).await, []);
    // the meaning of the axes is compared elsewhere; two absent ones are equal
    let numbers = async |of: &Measurand| found(of, 1, None, 10).await.iter().map(|one| one.number).collect::<Vec<_>>();
    assert_eq!(numbers(&Measurand { axes: None, ..left.clone() }).await, [1, 4, 6]);
    assert_eq!(numbers(&none).await, [3, 7]);
    assert_eq!(numbers(&of(Side::Left, "4")).await, [0; 0]);

    for (number, alike, any) in [(1, Some(4), Some(2)), (2, Some(5), Some(3)), (3, Some(7), Some(4))] {
        assert_eq!(store.successors(job, number).await.unwrap(), Successors { alike, any });
    }
    assert_eq!(store.successors(job, 6).await.unwrap(), Successors { alike: None, any: Some(7) });
    assert_eq!(store.successors(job, 7).await.unwrap(), Successors::default());
    for (number, measurand) in [(1, left), (2, right), (3, none)] {
        assert_eq!(store.measurand(job, number).await.unwrap(), measurand);
    }
    let beyond = store.measurand(job, 8).await;
    assert!(matches!(beyond, Err(RepositoryError::NotFound(Resource::Iteration))), "{beyond:?}");
}

pub async fn rounds_list_iterations_and_corrections(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    assert_eq!(store.rounds(job).await.unwrap(), Default::default());
    let measured = [of(Side::Right, "3"), Measurand::default()];
    for measurand in &measured {
        let iteration = NewIteration { measurand: measurand.clone(), ..NewIteration::clone(&place.iteration(job)) };
        store.insert_iteration(Arc::new(iteration), None).await.unwrap();
    }
    let mut made = Vec::new();
    let kinds = [RecordKind::GearCorrection, RecordKind::Curve, RecordKind::Correction, RecordKind::Applied];
    for (k, kind) in kinds.into_iter().enumerate() {
        let (number, record) = (2 - k as u32 / 2, place.record(kind, kind.name()));
        store.insert_record(job, number, record.clone(), None).await.unwrap();
        let Record { id, created_at, .. } = *record;
        if matches!(kind, RecordKind::Correction | RecordKind::GearCorrection) {
            made.push(MadeCorrection { number, id, kind, created_at });
        }
    }
    let rounds = store.rounds(job).await.unwrap();
    assert_eq!(rounds.corrections, made);
    assert_eq!(rounds.newest_of_gear(), made.first());
    for (number, (one, measurand)) in (1..).zip(rounds.iterations.iter().zip(measured)) {
        assert_eq!((one.number, &one.measurand), (number, &Measurand { axes: None, ..measurand }));
        assert_eq!(one.created_at, store.iteration(job, number).await.unwrap().created_at);
    }
}
