//! Curves and surfaces kept with an iteration: what was asked for and what was answered, for good.

use std::sync::Arc;

use jiff::Timestamp;
use uuid::Uuid;

/// What a shape is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShapeKind {
    Curve,
    Surface,
}

impl ShapeKind {
    /// The contract's name.
    pub fn name(self) -> &'static str {
        match self {
            ShapeKind::Curve => "curve",
            ShapeKind::Surface => "surface",
        }
    }

    /// The kind of that name.
    pub fn named(name: &str) -> Option<Self> {
        [ShapeKind::Curve, ShapeKind::Surface].into_iter().find(|kind| kind.name() == name)
    }
}

/// A shape built, on its way to be stored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShapeDraft {
    pub kind: ShapeKind,
    /// The contract's name of the method that built it.
    pub method: String,
    /// What was asked for: a JSON document.
    pub request: Arc<str>,
    /// What was answered: a JSON document.
    pub result: Arc<str>,
}

/// A shape with its id and time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shape {
    pub id: Uuid,
    pub created_at: Timestamp,
    pub draft: ShapeDraft,
}

/// A stored shape in a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShapeSummary {
    pub id: Uuid,
    pub kind: ShapeKind,
    pub method: String,
    pub created_at: Timestamp,
}
