//! Description of nodes: flank, tooth and axes.

use std::sync::Arc;

use flankfit_engine::gear::{
    Side,
    tooth::{self, Position},
};
use jiff::Timestamp;

use super::outcome::RepositoryError;

/// Description of nodes; `None` for what was not given.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Measurand {
    pub flank: Option<Side>,
    pub tooth: Option<String>,
    /// Meaning of the axes of the nodes: a JSON document, checked on reading the request.
    pub axes: Option<Arc<str>>,
    /// Whether the units were confirmed although they are implausible.
    pub accept_units: bool,
}

impl Measurand {
    /// The contract's name of the flank.
    pub fn flank_name(&self) -> Option<&'static str> {
        self.flank.map(side_name)
    }

    /// Refuses a tooth that a gear with so many teeth has not got. A name that is no number is of
    /// any gear.
    pub fn check_tooth(&self, teeth: Option<u32>) -> Result<(), RepositoryError> {
        let (Some(tooth), Some(teeth)) = (&self.tooth, teeth) else { return Ok(()) };
        match has_no_tooth(tooth, teeth) {
            true => Err(RepositoryError::NoSuchTooth { tooth: tooth.clone(), teeth }),
            false => Ok(()),
        }
    }

    /// Returns whether both are of the same flank and tooth: what neither names is the same, what
    /// one of them names is not.
    pub fn is_alike(&self, other: &Measurand) -> bool {
        let name = |of: &Measurand| of.tooth.as_ref().map(|tooth| tooth::canonical(tooth).unwrap_or(tooth.clone()));
        self.flank == other.flank && name(self) == name(other)
    }

    /// In words: `the left flank of tooth 3`.
    pub fn words(&self) -> String {
        let flank = self.flank_name().map_or_else(|| "a flank".to_owned(), |name| format!("the {name} flank"));
        match &self.tooth {
            Some(tooth) => format!("{flank} of tooth {tooth}"),
            None => flank,
        }
    }
}

/// Whether the name of a tooth has a number that a gear with so many teeth has not got.
pub fn has_no_tooth(tooth: &str, teeth: u32) -> bool {
    Position::number(tooth).is_some_and(|number| !(1..=u64::from(teeth)).contains(&number))
}

/// Iterations after one, by their numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Successors {
    /// The first of the same flank and tooth; what neither of the two names is the same, what one
    /// of them names is not.
    pub alike: Option<u32>,
    /// The first of any.
    pub any: Option<u32>,
}

/// The contract's name.
pub fn side_name(side: Side) -> &'static str {
    match side {
        Side::Left => "left",
        Side::Right => "right",
    }
}

/// The flank of that name.
pub fn side_named(name: &str) -> Option<Side> {
    [Side::Left, Side::Right].into_iter().find(|side| side_name(*side) == name)
}

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeasurementDetails {
    pub measured_at: Option<Timestamp>,
    pub instrument: Option<String>,
    pub operator: Option<String>,
    pub note: Option<String>,
}
