//! Faults of input: where, and what is wrong there.

mod sentences;

use std::fmt::{self, Display};

pub use sentences::{
    deviation_exceeds, length_exceeds, negative, not_ascending, not_finite, not_positive, per_node, per_position, range,
};

/// A value that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Path to the value from the object that was checked, such as `regularization.weights[1]`;
    /// empty for the object itself.
    pub path: String,
    /// Description of the error and its remedy: one sentence without a full stop, names in
    /// backticks.
    pub message: String,
}

/// The message; the path goes before it, as "at `path`: ".
impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.path.is_empty() {
            write!(f, "at `{}`: ", self.path)?;
        }
        f.write_str(&self.message)
    }
}

impl std::error::Error for Fault {}

/// All errors that were found. The first [`Faults::MOST`] are kept, all are counted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    list: Vec<Fault>,
    count: usize,
}

impl Faults {
    /// Number of errors that are kept.
    pub const MOST: usize = 100;

    /// Returns a single fault.
    pub fn one(path: impl Display, message: impl Display) -> Self {
        let mut faults = Self::default();
        faults.push(path, message);
        faults
    }

    /// Adds a fault; text is made only where it is kept.
    pub fn push(&mut self, path: impl Display, message: impl Display) {
        self.count += 1;
        if self.list.len() < Self::MOST {
            self.list.push(Fault { path: path.to_string(), message: message.to_string() });
        }
    }

    /// Adds the errors of another list.
    pub fn append(&mut self, other: Self) {
        self.count += other.count;
        let left = Self::MOST - self.list.len();
        self.list.extend(other.list.into_iter().take(left));
    }

    /// Places each fault in a larger object, in which the checked one is at `path`.
    #[must_use]
    pub fn within(self, path: &str) -> Self {
        self.map(|Fault { path: inner, message }| {
            let separator = if path.is_empty() || inner.is_empty() || inner.starts_with('[') { "" } else { "." };
            Fault { path: format!("{path}{separator}{inner}"), message }
        })
    }

    /// Moves the errors at and within `from` to `to`.
    #[must_use]
    pub fn moved(self, from: &str, to: &str) -> Self {
        self.map(|fault| match rest_of(&fault.path, from) {
            Some(rest) => Fault { path: format!("{to}{rest}"), message: fault.message },
            None => fault,
        })
    }

    /// Changes each fault that was kept.
    #[must_use]
    pub fn map(mut self, change: impl Fn(Fault) -> Fault) -> Self {
        self.list = self.list.into_iter().map(change).collect();
        self
    }

    /// Errors that were kept.
    pub fn list(&self) -> &[Fault] {
        &self.list
    }

    /// Number of errors that were found.
    pub fn count(&self) -> usize {
        self.count
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Returns `Ok(value)` where there are none.
    pub fn into_result<T>(self, value: T) -> Result<T, Self> {
        if self.is_empty() { Ok(value) } else { Err(self) }
    }
}

/// Returns the path from `place` to what is at `path`, where that is within `place` or `place`
/// itself.
pub fn rest_of<'a>(path: &'a str, place: &str) -> Option<&'a str> {
    path.strip_prefix(place).filter(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
}

impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, Fault { path, message }) in self.list.iter().enumerate() {
            let between = if k == 0 { "" } else { "; " };
            let colon = if path.is_empty() { "" } else { ": " };
            write!(f, "{between}{path}{colon}{message}")?;
        }
        match self.count - self.list.len() {
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
    fn errors_are_placed_within_a_larger_object() {
        let mut inner = Faults::one("weights[1]", "-1 is not a finite number of at least 0");
        inner.push("[0]", "missing");
        inner.push("", "too many");
        let mut outer = Faults::default();
        outer.append(inner.within("regularization"));
        let paths: Vec<&str> = outer.list().iter().map(|fault| &*fault.path).collect();
        assert_eq!(paths, ["regularization.weights[1]", "regularization[0]", "regularization"]);
        assert_eq!(outer.count(), 3);
        assert!(outer.to_string().starts_with("regularization.weights[1]: -1 is not"));
    }

    #[test]
    fn moving_a_path_moves_everything_within_it() {
        let mut faults = Faults::one("nodes.z[3][7]", "missing");
        ["nodes", "nodes_read", "model"].into_iter().for_each(|path| faults.push(path, "wrong"));
        let moved = faults.moved("nodes", "grid");
        let paths: Vec<&str> = moved.list().iter().map(|fault| &*fault.path).collect();
        assert_eq!(paths, ["grid.z[3][7]", "grid", "nodes_read", "model"]);
    }

    #[test]
    fn only_the_first_errors_are_kept() {
        let mut faults = Faults::default();
        (0..150).for_each(|i| faults.push(format_args!("z[{i}]"), "the number is not finite"));
        assert_eq!((faults.list().len(), faults.count()), (Faults::MOST, 150));
        assert!(faults.to_string().ends_with("; and 50 more"));
        assert_eq!(faults.clone().into_result(1), Err(faults));
        assert_eq!(Faults::default().into_result(1), Ok(1));
    }
}
