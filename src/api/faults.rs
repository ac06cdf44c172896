//! Errors of a request, by JSON Pointers.
//!
//! The engine names errors by paths, which become pointers.

use std::fmt;

use flankfit_engine::numerics::check;

/// One fault, by its place in the request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// JSON Pointer (RFC 6901) into the request, such as `/nodes/z/3/7`.
    pub pointer: String,
    /// The error at this place, and its remedy.
    pub detail: String,
    /// True if the value is missing.
    pub missing: bool,
}

/// Every fault found (the first [`Faults::MOST`] are kept, all are counted).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    faults: Vec<Fault>,
    count: usize,
}

impl Faults {
    /// Number of errors that are kept.
    pub const MOST: usize = 100;

    /// A single fault.
    pub fn one(pointer: impl Into<String>, detail: impl Into<String>) -> Self {
        let mut faults = Self::default();
        faults.push(pointer, detail);
        faults
    }

    /// Adds a fault.
    pub fn push(&mut self, pointer: impl Into<String>, detail: impl Into<String>) {
        self.add(Fault { pointer: pointer.into(), detail: detail.into(), missing: false });
    }

    /// Adds that a required value is missing.
    pub fn push_missing(&mut self, pointer: impl Into<String>, detail: impl Into<String>) {
        self.add(Fault { pointer: pointer.into(), detail: detail.into(), missing: true });
    }

    /// Adds a fault that was found elsewhere.
    pub fn add(&mut self, fault: Fault) {
        self.count += 1;
        if self.faults.len() < Self::MOST {
            self.faults.push(fault);
        }
    }

    /// Adds an error whose message takes time to make: it is made only while errors are kept.
    pub fn push_with(&mut self, pointer: impl Into<String>, detail: impl FnOnce() -> String) {
        let kept = self.faults.len() < Self::MOST;
        self.push(pointer, if kept { detail() } else { String::new() });
    }

    /// Places each fault in a larger object, in which the checked one is at `pointer`.
    pub fn within(mut self, pointer: &str) -> Self {
        self.faults.iter_mut().for_each(|fault| fault.pointer.insert_str(0, pointer));
        self
    }

    /// Takes over the errors of another list.
    pub fn append(&mut self, other: impl Into<Faults>) {
        let other = other.into();
        self.count += other.count;
        let room = Self::MOST - self.faults.len();
        self.faults.extend(other.faults.into_iter().take(room));
    }

    /// The errors that are kept.
    pub fn list(&self) -> &[Fault] {
        &self.faults
    }

    /// How many there were.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// `Ok(value)` when there are none.
    pub fn into_result<T>(self, value: T) -> Result<T, Faults> {
        if self.is_empty() { Ok(value) } else { Err(self) }
    }
}

/// The JSON Pointer of a path of the engine, such as `/regularization/weights/1`.
pub fn pointer_of(path: &str) -> String {
    let mut pointer = String::with_capacity(path.len() + 1);
    for name in path.split(['.', '[']).filter(|name| !name.is_empty()) {
        pointer.extend(["/", name.trim_end_matches(']')]);
    }
    pointer
}

/// Tells if a path of the engine is one of `places`, or within one.
pub fn is_within(path: &str, places: &[&str]) -> bool {
    places.iter().any(|place| check::rest_of(path, place).is_some())
}

/// Returns the pointer of a path of the engine; the first of each pair of places becomes the
/// second.
pub fn moved(path: &str, places: &[(&str, &str)]) -> String {
    let within = places.iter().find_map(|(from, to)| Some((check::rest_of(path, from)?, to)));
    within.map_or_else(|| pointer_of(path), |(rest, to)| format!("{to}{}", pointer_of(rest)))
}

impl Faults {
    /// Converts the engine's errors of the object at `base`, a JSON Pointer.
    pub fn of_engine(base: &str, found: &check::Faults) -> Self {
        Self::placed(found, |path| format!("{base}{}", pointer_of(path)))
    }

    /// Converts the engine's errors if a request has other places.
    pub fn placed(found: &check::Faults, pointer: impl Fn(&str) -> String) -> Self {
        let each = found.list().iter().map(|check::Fault { path, message }| Fault {
            pointer: pointer(path),
            detail: message.clone(),
            missing: false,
        });
        Faults { faults: each.collect(), count: found.count() }
    }
}

impl From<check::Faults> for Faults {
    fn from(found: check::Faults) -> Self {
        Faults::of_engine("", &found)
    }
}

impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, Fault { pointer, detail, .. }) in self.faults.iter().enumerate() {
            let between = if k == 0 { "" } else { "; " };
            write!(f, "{between}{pointer}: {detail}")?;
        }
        match self.count - self.faults.len() {
            0 => Ok(()),
            more => write!(f, "; and {more} more"),
        }
    }
}

impl std::error::Error for Faults {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_that_nobody_reads_are_not_made() {
        let (mut faults, mut made) = (Faults::default(), 0);
        for i in 0..3 * Faults::MOST {
            faults.push_with(format!("/{i}"), || {
                made += 1;
                "no such field".to_owned()
            });
        }
        assert_eq!((made, faults.list().len(), faults.count()), (Faults::MOST, Faults::MOST, 3 * Faults::MOST));
    }

    #[test]
    fn paths_of_the_engine_are_pointers() {
        for (path, pointer) in
            [("", ""), ("a.b[3][7].c", "/a/b/3/7/c"), ("[2]", "/2"), ("z[0]", "/z/0"), ("model", "/model")]
        {
            assert_eq!(pointer_of(path), pointer);
        }
        for (path, pointer) in [("nodes.z[3]", "/grid/z/3"), ("nodes", "/grid"), ("nodes_read", "/nodes_read")] {
            assert_eq!(moved(path, &[("model", "/method"), ("nodes", "/grid")]), pointer);
        }
        let found = check::Faults::one("gear.teeth", "too few").within("left");
        assert_eq!(Faults::of_engine("/spec", &found).list()[0].pointer, "/spec/left/gear/teeth");
    }
}
