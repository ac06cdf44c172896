//! Texts of collinearity reports that many results share.
//!
//! A plan hands the same report to every fit on its grid, and its text is most of a short answer:
//! it is written once. A text is found by the identity of its report, whose address stays taken as
//! long as the weak reference to it is kept here.

use std::sync::{Arc, Mutex, PoisonError, Weak};

use flankfit_engine::estimation::result::CollinearityReport;

/// Texts kept at most: as many as there are plans.
const KEPT: usize = 32;

struct Entry {
    report: Weak<CollinearityReport>,
    /// Whether the matrices were written as well.
    squares: bool,
    text: Arc<[u8]>,
}

/// The latest used one first.
static TEXTS: Mutex<Vec<Entry>> = Mutex::new(Vec::new());

/// The text of `report`, where it has been written before.
pub fn find(report: &Arc<CollinearityReport>, squares: bool) -> Option<Arc<[u8]>> {
    let mut texts = TEXTS.lock().unwrap_or_else(PoisonError::into_inner);
    let own = |entry: &Entry| entry.squares == squares && entry.report.as_ptr() == Arc::as_ptr(report);
    let at = texts.iter().position(own)?;
    texts[..=at].rotate_right(1);
    Some(Arc::clone(&texts[0].text))
}

/// Keeps the text of `report` for the next result that shares it.
pub fn keep(report: &Arc<CollinearityReport>, squares: bool, text: &[u8]) {
    let entry = Entry { report: Arc::downgrade(report), squares, text: text.into() };
    let mut texts = TEXTS.lock().unwrap_or_else(PoisonError::into_inner);
    texts.retain(|entry| entry.report.strong_count() > 0);
    texts.truncate(KEPT - 1);
    texts.insert(0, entry);
}
