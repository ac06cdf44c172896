//! The gear of a job and the measured teeth are compared where they are written.

use std::sync::Arc;

use flankfit::jobs::{
    ExpectedGear, JobGear, JobPatch, Measurand, NewIteration, NewStream, Precondition, Record, RecordKind, Repository,
    RepositoryError, Successors, Update,
};
use flankfit_engine::gear::Side;
use uuid::Uuid;

use super::pair::Pair;
use crate::support::{Values, caller};

fn of(tooth: &str) -> Measurand {
    Measurand { flank: Some(Side::Left), tooth: Some(tooth.to_owned()), axes: None, accept_units: false }
}

fn iteration(place: &Values, job: Uuid, tooth: &str) -> Arc<NewIteration> {
    Arc::new(NewIteration { measurand: of(tooth), ..NewIteration::clone(&place.iteration(job)) })
}

async fn patched(place: &Values, store: &Arc<dyn Repository>, job: Uuid, teeth: u32) -> Result<(), RepositoryError> {
    let gear = Update::Set(JobGear::from(format!(r#"{{"teeth":{teeth},"normal_module_mm":1.0}}"#)));
    let patch = JobPatch { gear, ..JobPatch::default() };
    store.patch_job(job, patch, Precondition::None, place.now()).await.map(drop)
}

/// No check before the write can know what another request writes meanwhile: here the write itself
/// is asked.
pub async fn unknown_teeth_are_not_stored(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    patched(&place, &store, job, 30).await.unwrap();
    let refused = store.insert_iteration(iteration(&place, job, "40"), None).await;
    assert!(matches!(refused, Err(RepositoryError::NoSuchTooth { teeth: 30, .. })), "{refused:?}");
    let stream = NewStream { measurand: of("31"), ..place.stream(job) };
    let refused = store.insert_stream(Arc::new(stream), None).await;
    assert!(matches!(refused, Err(RepositoryError::NoSuchTooth { .. })), "{refused:?}");
    assert!(matches!(store.iteration(job, 1).await, Err(RepositoryError::NotFound(_))), "nothing was stored");
    // in one group with others, that are stored and numbered without a gap; of one handle, which
    // keeps their order
    let one = pair.handles[0].of(&caller("default"));
    let each = ["30", "40", "master", "1"].map(|tooth| one.insert_iteration(iteration(&place, job, tooth), None));
    let answers = futures_util::future::join_all(each).await;
    let numbers: Vec<Option<u32>> = answers.into_iter().map(|answer| answer.ok().map(|stored| stored.number)).collect();
    assert_eq!(numbers, [Some(1), None, Some(2), Some(3)]);
    let refused = patched(&place, &store, job, 29).await;
    assert!(
        matches!(&refused, Err(RepositoryError::ToothMeasured { tooth, iteration: Some(1), .. }) if tooth == "30"),
        "{refused:?}"
    );
    // nor does a tooth go that an open stream is of, until the stream is gone
    let other = place.stored_job(&store).await.id;
    let stream = Arc::new(NewStream { measurand: of("30"), ..place.stream(other) });
    store.insert_stream(stream.clone(), None).await.unwrap();
    let refused = patched(&place, &store, other, 29).await;
    assert!(matches!(refused, Err(RepositoryError::ToothMeasured { iteration: None, .. })), "{refused:?}");
    store.delete_stream(stream.id, Precondition::None, place.now()).await.unwrap();
    patched(&place, &store, other, 29).await.unwrap();
    assert_eq!(store.job(job).await.unwrap().version, 2);
}

/// An import is read by the gear that the job had when it began; nothing may have changed by its
/// end.
pub async fn results_of_another_gear_are_not_stored(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await;
    let made_with = |gear: Option<&str>| {
        let expected_gear = Some(ExpectedGear(gear.map(|text| JobGear::from(text.to_owned()))));
        Arc::new(NewIteration { expected_gear, ..NewIteration::clone(&place.iteration(job.id)) })
    };
    store.insert_iteration(made_with(job.gear.as_deref()), None).await.unwrap();
    patched(&place, &store, job.id, 60).await.unwrap();
    for gear in [job.gear.as_deref(), None] {
        let refused = store.insert_iteration(made_with(gear), None).await;
        assert!(matches!(refused, Err(RepositoryError::GearChanged)), "{refused:?}");
    }
    let now = store.job(job.id).await.unwrap().gear;
    assert_eq!(store.insert_iteration(made_with(now.as_deref()), None).await.unwrap().number, 2);
}

/// Names of teeth that were stored before there was one way to write them.
pub async fn an_older_name_of_a_tooth_is_that_tooth(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    for tooth in ["01", "2", "B", " 1"] {
        store.insert_iteration(iteration(&place, job, tooth), None).await.unwrap();
    }
    assert_eq!(store.successors(job, 1).await.unwrap(), Successors { alike: Some(4), any: Some(2) });
    assert_eq!(store.successors(job, 2).await.unwrap(), Successors { alike: None, any: Some(3) });
    assert_eq!(store.successors(job, 4).await.unwrap(), Successors::default());
}

pub async fn a_record_keeps_its_gear(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await;
    place.stored_iteration(&store, job.id).await;
    let mut record = Record::clone(&place.record(RecordKind::Correction, "form_grinding"));
    record.draft.gear = job.gear.as_deref().map(Into::into);
    store.insert_record(job.id, 1, Arc::new(record.clone()), None).await.unwrap();
    patched(&place, &store, job.id, 60).await.unwrap();
    assert_eq!(store.latest_record(job.id, 1, RecordKind::Correction).await.unwrap(), Some(record.clone()));
    assert_eq!(store.record(job.id, 1, record.id).await.unwrap(), record);
}
