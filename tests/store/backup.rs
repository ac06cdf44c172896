//! Backups: consistent while the service writes, and nothing is overwritten.

use std::sync::Arc;

use flankfit::store::{BackupError, StoreSettings, backup};

use crate::support::{Place, WHOLE};

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_backup_under_writing_holds_a_whole_prefix() {
    let place = Arc::new(Place::new());
    let store = Arc::new(place.open().await);
    let job = place.stored_job(&*store).await.id;
    for _ in 0..50 {
        place.stored_iteration(&*store, job).await;
    }
    let writing = tokio::spawn({
        let (place, store) = (place.clone(), store.clone());
        async move {
            for _ in 0..200 {
                place.stored_iteration(&*store, job).await;
            }
        }
    });
    let target = place.path("copy.db");
    backup(&StoreSettings::of_file(place.file()), &target).await.unwrap();
    writing.await.unwrap();
    assert!(!place.path("copy.db.partial").exists());

    let copy = place.open_with(StoreSettings::of_file(&target)).await;
    let trace = copy.trace(job, WHOLE).await.unwrap();
    assert!((50..=250).contains(&trace.iterations.len()));
    for (index, iteration) in trace.iterations.iter().enumerate() {
        assert_eq!(usize::try_from(iteration.number).unwrap(), index + 1);
        assert_eq!((iteration.fits.len(), iteration.choices.len()), (1, 1));
    }
}

#[tokio::test]
async fn nothing_is_overwritten_and_nothing_is_made_of_nothing() {
    let place = Place::new();
    let settings = StoreSettings::of_file(place.file());
    let target = place.path("copy.db");
    let nothing = backup(&settings, &target).await;
    assert!(matches!(nothing, Err(BackupError::NoSource(_))), "{nothing:?}");
    assert!(!target.exists() && !place.file().exists());

    place.open().await.close().await;
    std::fs::write(&target, "precious").unwrap();
    assert!(matches!(backup(&settings, &target).await, Err(BackupError::Exists(_))));
    assert_eq!(std::fs::read(&target).unwrap(), b"precious");
}
