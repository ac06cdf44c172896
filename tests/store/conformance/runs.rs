//! Jobs that are stored with all their iterations, in one transaction.

use flankfit::jobs::{NewRun, RepositoryError};

use super::pair::Pair;
use crate::support::{WHOLE, all_jobs, receipt};

pub async fn runs_are_stored_atomically(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let run = |iterations: usize| {
        let job = place.job("run");
        let iterations = (0..iterations).map(|_| place.iteration(job.id)).collect();
        NewRun { job, iterations }
    };
    let scope = "POST /v1/simulations/closed-loop";
    let runs = [run(2), run(3)];
    store.insert_runs(runs.to_vec(), Some(receipt("k", scope)), place.now()).await.unwrap();
    for run in &runs {
        let trace = store.trace(run.job.id, WHOLE).await.unwrap();
        assert_eq!(
            trace.iterations.iter().map(|i| i.number).collect::<Vec<_>>(),
            Vec::from_iter(1..=run.iterations.len() as u32)
        );
    }
    // a key that is taken, or a job that is there already: nothing of it is stored
    let taken = store.insert_runs(vec![run(1)], Some(receipt("k", scope)), place.now()).await;
    assert!(matches!(taken, Err(RepositoryError::KeyTaken)), "{taken:?}");
    let twice = store.insert_runs(vec![run(1), runs[0].clone()], Some(receipt("l", scope)), place.now()).await;
    assert!(matches!(twice, Err(RepositoryError::Failed(_))), "{twice:?}");
    assert_eq!(store.jobs(all_jobs()).await.unwrap().items.len(), 2);
    assert!(store.answer("k".to_owned(), scope.to_owned()).await.unwrap().is_some());
    assert_eq!(store.answer("l".to_owned(), scope.to_owned()).await.unwrap(), None);
    // without a run the answer alone is kept
    store.insert_runs(Vec::new(), Some(receipt("l", scope)), place.now()).await.unwrap();
    assert!(store.answer("l".to_owned(), scope.to_owned()).await.unwrap().is_some());
}
