//! Database files that are removed or replaced while open: no write is acknowledged.

use std::{fs, path::Path, sync::Arc};

use flankfit::{
    jobs::{RepositoryError, SystemClock, Unfit},
    store::{OpenError, StoreSettings, open_sqlite},
};

use crate::support::Place;

fn moved(file: &Path) -> std::path::PathBuf {
    file.with_extension("moved")
}

#[tokio::test]
async fn nothing_is_acknowledged_that_goes_into_a_file_that_was_taken_away() {
    for log in [false, true] {
        let place = Place::new();
        let store = place.open().await;
        place.stored_job(&store).await;
        let file = if log { place.path("jobs.db-wal") } else { place.file() };
        let refused = async || {
            let outcome = store.insert_job(place.job("lost"), None).await;
            assert!(matches!(outcome, Err(RepositoryError::Unfit(Unfit::Misplaced))), "{outcome:?}");
            let ready = store.store.check_writable(place.now()).await;
            assert!(matches!(ready, Err(RepositoryError::Unfit(Unfit::Misplaced))), "{ready:?}");
        };
        // removed
        fs::rename(&file, moved(&file)).unwrap();
        refused().await;
        // replaced by another file
        fs::copy(moved(&file), &file).unwrap();
        refused().await;
        // restored
        fs::rename(moved(&file), &file).unwrap();
        store.store.check_writable(place.now()).await.unwrap();
        store.insert_job(place.job("kept"), None).await.unwrap();
        // the log of another database is not removed at the end
        fs::rename(&file, moved(&file)).unwrap();
        fs::write(place.path("jobs.db-wal"), "another").unwrap();
        store.close().await;
        assert_eq!(fs::read_to_string(place.path("jobs.db-wal")).unwrap(), "another");
    }
}

/// Another name of the file would have another lock file.
#[tokio::test]
async fn a_file_with_two_names_is_opened_by_neither() {
    let place = Place::new();
    place.open().await.close().await;
    let other = place.path("other.db");
    fs::hard_link(place.file(), &other).unwrap();
    for name in [place.file(), other.clone()] {
        let opened = open_sqlite(StoreSettings::of_file(&name), Arc::new(SystemClock)).await;
        assert!(matches!(opened.err(), Some(OpenError::Linked { path }) if path == name));
    }
    fs::remove_file(other).unwrap();
    place.open().await.close().await;
}
