//! Computing a stored fit again.

/// Result of a replay.
#[derive(Clone, Debug, PartialEq)]
pub enum Replay {
    /// The recomputed answer equals the stored one, bit by bit.
    Identical,
    Different(Difference),
}

/// Difference of two responses to the same request.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// The largest over all numbers of the two responses; `None` when they do not line up.
    pub max_relative_difference: Option<f64>,
    /// Who computed the stored answer.
    pub stored_engine: Option<String>,
    /// Who computed it now.
    pub replay_engine: Option<String>,
}

impl Replay {
    /// Compares two responses; how they differ is only looked at when they do.
    pub fn of<E>(
        stored: &str,
        recomputed: &str,
        difference: impl FnOnce(&str, &str) -> Result<Difference, E>,
    ) -> Result<Self, E> {
        if stored == recomputed {
            return Ok(Replay::Identical);
        }
        difference(stored, recomputed).map(Replay::Different)
    }
}
