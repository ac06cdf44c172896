//! Series of metrics that are counted with every request. The recorder finds a series by its
//! labels, which takes several times as long as counting; so each thread keeps those that it has
//! found.

use std::{borrow::Borrow, cell::RefCell, collections::HashMap, hash::Hash};

/// The series of one metric that a thread has found, by their labels. Labels come from lists that
/// are bounded (routes, statuses, outcomes), never from a client.
pub struct Known<K, H>(RefCell<HashMap<K, H>>);

impl<K: Eq + Hash, H> Default for Known<K, H> {
    fn default() -> Self {
        Known(RefCell::new(HashMap::new()))
    }
}

impl<K: Eq + Hash, H> Known<K, H> {
    /// Does `count` with the series of `labels`, which `find` asks the recorder for once.
    pub fn with<Q>(&self, labels: &Q, find: impl FnOnce(&Q) -> H, count: impl FnOnce(&mut H))
    where
        K: Borrow<Q>,
        Q: Eq + Hash + ToOwned<Owned = K> + ?Sized,
    {
        let mut known = self.0.borrow_mut();
        if let Some(series) = known.get_mut(labels) {
            return count(series);
        }
        count(known.entry(labels.to_owned()).or_insert(find(labels)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_series_is_created_once() {
        let known = Known::<String, u32>::default();
        let mut asked = 0;
        for _ in 0..3 {
            let find = |labels: &str| {
                asked += 1;
                labels.len() as u32
            };
            known.with("four", find, |counted| *counted += 1);
        }
        known.with("four", |_| unreachable!("it is known"), |counted| assert_eq!(*counted, 7));
        known.with("other", |_| 0, |counted| assert_eq!(*counted, 0));
        assert_eq!(asked, 1);
    }
}
