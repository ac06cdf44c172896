//! Pages of events, read once for all listeners at the same position.
//!
//! Many clients may listen to one job, and each stream reads after the last event it has sent.
//! Streams that were woken by the same change and are at the same position share one read and its
//! page.

use std::{
    collections::HashMap,
    sync::{Mutex, PoisonError},
    time::Instant,
};

use axum::response::sse::Event;
use tokio::sync::OnceCell;

use super::prelude::*;
use crate::jobs::{EventPlace, Tenant};

/// How long a page is shared before it is read again: listeners poll only seldom unless woken.
const FRESH: Duration = Duration::from_millis(500);

/// Selects events: of one job or of all jobs, after a position.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct PageKey {
    pub tenant: Tenant,
    pub job: Option<Uuid>,
    pub after: EventPlace,
}

/// Some events with the position of the last; `None` if there are none.
pub type EventPage = Option<(Arc<[Event]>, EventPlace)>;

/// A page that is being read, or has just been read.
#[derive(Debug)]
struct Kept {
    /// Count of wakes seen by the listener that started the read.
    wakes: u64,
    begun: Instant,
    page: Arc<OnceCell<EventPage>>,
}

/// See the module's documentation.
#[derive(Debug, Default)]
pub struct EventPages(Mutex<HashMap<PageKey, Kept>>);

impl EventPages {
    /// Returns a page read after this many wakes had been seen, by this caller or by another.
    pub async fn get<F>(&self, key: PageKey, wakes: u64, read: F) -> Result<EventPage, RepositoryError>
    where
        F: Future<Output = Result<EventPage, RepositoryError>>,
    {
        let page = self.kept(key, wakes);
        page.get_or_try_init(|| read).await.cloned()
    }

    fn kept(&self, key: PageKey, wakes: u64) -> Arc<OnceCell<EventPage>> {
        let mut pages = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(kept) = pages.get(&key).filter(|kept| kept.wakes == wakes && kept.begun.elapsed() < FRESH) {
            return kept.page.clone();
        }
        pages.retain(|_, kept| kept.begun.elapsed() < FRESH);
        let page = Arc::default();
        pages.insert(key, Kept { wakes, begun: Instant::now(), page: Arc::clone(&page) });
        page
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering};

    use futures_util::future::join_all;

    use super::*;

    #[tokio::test]
    async fn listeners_woken_together_share_one_read() {
        let (pages, reads) = (EventPages::default(), AtomicU64::new(0));
        let key = |number| PageKey { tenant: Tenant::root(), job: None, after: EventPlace { change: 0, number } };
        let read = async || {
            reads.fetch_add(1, Ordering::Relaxed);
            tokio::task::yield_now().await;
            Ok(Some((Arc::from([Event::default().data("x")]), EventPlace { change: 0, number: 7 })))
        };
        let told = join_all((0..1500).map(|_| pages.get(key(3), 1, read()))).await;
        let first = told[0].as_ref().unwrap().as_ref().unwrap().0.as_ptr();
        let same = |page: &Result<EventPage, _>| page.as_ref().unwrap().as_ref().unwrap().0.as_ptr() == first;
        assert!(told.iter().all(same), "the same page");
        assert_eq!(reads.load(Ordering::Relaxed), 1);
        // a listener woken later, or at another position, has its own read
        pages.get(key(3), 2, read()).await.unwrap();
        pages.get(key(4), 2, read()).await.unwrap();
        assert_eq!(reads.load(Ordering::Relaxed), 3);
        // a failed read is not shared
        let failed = pages.get(key(5), 2, async { Err(RepositoryError::Overloaded) }).await;
        assert!(failed.is_err());
        pages.get(key(5), 2, read()).await.unwrap();
        assert_eq!(reads.load(Ordering::Relaxed), 4);
    }
}
