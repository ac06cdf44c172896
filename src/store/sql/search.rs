//! Looks up jobs by parts of their text.
//!
//! A filter by text or tag searches for parts of the text of [`Job::searched`]. Both databases
//! index that text by short parts: the index finds the jobs that have all of them, and the filter
//! itself is applied to those. If many jobs have them, scanning in the order of the list is faster,
//! since a page is soon full.
//!
//! [`Job::searched`]: crate::jobs::Job::searched

use std::collections::BTreeSet;

use crate::jobs::{JobFilter, folded};

/// Up to this many jobs are looked up by the index and sorted. It is about the root of the length
/// of a page times the number of jobs of a large tenant.
pub const FEW: i64 = 2000;

/// Length of the longest indexed parts, in letters.
const LETTERS: usize = 3;

/// Greatest number of parts in a query; more would hardly narrow the search.
const MOST_PARTS: usize = 32;

/// The parts of the texts of a filter.
#[derive(Debug, PartialEq)]
pub enum Parts {
    /// Parts of the full indexed length.
    Whole(BTreeSet<String>),
    /// A single shorter part.
    Short(String),
}

impl Parts {
    /// Returns the parts that a job must have; `None` if the filter has neither text nor tag.
    pub fn of(filter: &JobFilter) -> Option<Self> {
        // each tag is on its own line
        let tag = filter.tag.as_ref().map(|tag| format!("\n{}", folded(tag)));
        let texts: Vec<Vec<char>> = filter.text.iter().chain(&tag).map(|text| text.chars().collect()).collect();
        let whole: BTreeSet<String> =
            texts.iter().flat_map(|text| text.windows(LETTERS)).map(String::from_iter).collect();
        match texts.first() {
            None => None,
            Some(_) if !whole.is_empty() => Some(Parts::Whole(whole.into_iter().take(MOST_PARTS).collect())),
            Some(short) => Some(Parts::Short(short.iter().collect())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts(text: Option<&str>, tag: Option<&str>) -> Option<Parts> {
        let owned = |text: Option<&str>| text.map(str::to_owned);
        Parts::of(&JobFilter { text: owned(text), tag: owned(tag), ..JobFilter::default() })
    }

    #[test]
    fn a_filter_asks_for_all_parts_of_its_texts() {
        let whole = |parts: &[&str]| Some(Parts::Whole(parts.iter().map(|part| (*part).to_owned()).collect()));
        assert_eq!(parts(None, None), None);
        assert_eq!(parts(Some("wälzw"), None), whole(&["wäl", "älz", "lzw"]));
        assert_eq!(parts(None, Some("Fit:1")), whole(&["\nfi", "fit", "it:", "t:1"]));
        assert_eq!(parts(Some("ab"), Some("cd")), whole(&["\ncd"]));
        assert_eq!(parts(Some("ä"), None), Some(Parts::Short("ä".to_owned())));
        assert_eq!(parts(None, Some("X")), Some(Parts::Short("\nx".to_owned())));
        assert_eq!(parts(Some("ab"), Some("c")), Some(Parts::Short("ab".to_owned())));
    }
}
