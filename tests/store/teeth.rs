//! Teeth by the names that were stored.

use std::sync::Arc;

use flankfit::jobs::{Later, Measurand, NewIteration, Repository};
use uuid::Uuid;

use crate::support::Place;

fn of(tooth: &str) -> Measurand {
    Measurand::named(Some("left"), Some(tooth.to_owned()), None).unwrap()
}

fn iteration(place: &Place, job: Uuid, tooth: &str) -> Arc<NewIteration> {
    Arc::new(NewIteration { measurand: of(tooth), ..NewIteration::clone(&place.iteration(job)) })
}

/// Names of teeth that were stored before there was one way to write them.
#[tokio::test]
async fn an_older_name_of_a_tooth_is_that_tooth() {
    let place = Place::new();
    let store = place.open().await;
    let job = place.stored_job(&store).await.id;
    for tooth in ["01", "2", "B", " 1"] {
        store.insert_iteration(iteration(&place, job, tooth), None).await.unwrap();
    }
    assert_eq!(store.later(job, 1).await.unwrap(), Later { alike: Some(4), any: Some(2) });
    assert_eq!(store.later(job, 2).await.unwrap(), Later { alike: None, any: Some(3) });
    assert_eq!(store.later(job, 4).await.unwrap(), Later::default());
}
