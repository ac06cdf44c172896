//! Files of the database that are taken away while it is open: nothing is said to be stored there.

use std::{fs, path::Path, sync::Arc};

use flankfit::{
    jobs::{RepositoryError, SystemClock, Unfit},
    store::{OpenError, SqliteStore, StoreSettings},
};

use crate::support::{Place, ids};

fn moved(file: &Path) -> std::path::PathBuf {
    file.with_extension("moved")
}

#[tokio::test]
async fn nothing_is_acknowledged_that_goes_into_a_file_that_was_taken_away() {
    for log in [false, true] {
        let place = Place::new();
        let store = place.open().await;
        place.stored_job(&store).await;
        let file = if log { place.beside("jobs.db-wal") } else { place.file() };
        let refused = async || {
            let outcome = store.insert_job(place.job("lost"), None).await;
            assert!(matches!(outcome, Err(RepositoryError::Unfit(Unfit::Misplaced))), "{outcome:?}");
            let ready = store.store.check_writable(place.now()).await;
            assert!(matches!(ready, Err(RepositoryError::Unfit(Unfit::Misplaced))), "{ready:?}");
        };
        // taken away
        fs::rename(&file, moved(&file)).unwrap();
        refused().await;
        // another one in its place
        fs::copy(moved(&file), &file).unwrap();
        refused().await;
        // brought back
        fs::rename(moved(&file), &file).unwrap();
        store.store.check_writable(place.now()).await.unwrap();
        store.insert_job(place.job("kept"), None).await.unwrap();
        // a log that is another database's is not taken away at the end
        fs::rename(&file, moved(&file)).unwrap();
        fs::write(place.beside("jobs.db-wal"), "another").unwrap();
        store.close().await;
        assert_eq!(fs::read_to_string(place.beside("jobs.db-wal")).unwrap(), "another");
    }
}

/// Another name of the file has another lock beside it.
#[tokio::test]
async fn a_file_with_two_names_is_opened_by_neither() {
    let place = Place::new();
    place.open().await.close().await;
    let other = place.beside("other.db");
    fs::hard_link(place.file(), &other).unwrap();
    for name in [place.file(), other.clone()] {
        let opened = SqliteStore::open(StoreSettings::of_file(&name), ids(), Arc::new(SystemClock)).await;
        assert!(matches!(opened.err(), Some(OpenError::Linked { path }) if path == name));
    }
    fs::remove_file(other).unwrap();
    place.open().await.close().await;
}
