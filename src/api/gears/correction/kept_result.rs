//! The parts of a kept correction that are read again.

use serde::Deserialize;

use super::{result::LeftName, target::AimBody};
use crate::api::gears::evaluation::request::{DirectionName, ReferenceName};

/// A correction as it was kept: the changes that it asked for.
#[derive(Deserialize)]
pub struct StoredResult {
    pub settings: Vec<Changed>,
    #[serde(default)]
    pub target: Option<AimBody>,
    #[serde(default)]
    pub direction: Option<DirectionName>,
    #[serde(default)]
    pub reference: Option<ReferenceName>,
}

#[derive(Deserialize)]
pub struct Changed {
    pub name: String,
    #[serde(default)]
    pub unit: String,
    pub change: f64,
    #[serde(default)]
    pub left: Option<LeftName>,
}
