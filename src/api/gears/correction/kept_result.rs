//! The parts of a kept correction that are read again.

use serde::Deserialize;

use super::{result::LeftName, target::AimBody};
use crate::api::{
    gears::evaluation::request::{DirectionName, ReferenceName},
    measurand::side::SideName,
};

/// A correction as it was kept: the changes that it asked for.
#[derive(Debug, Deserialize)]
pub struct StoredResult {
    pub settings: Vec<Changed>,
    #[serde(default)]
    pub absolute: Option<bool>,
    #[serde(default)]
    pub iterations: Vec<u32>,
    #[serde(default)]
    pub flanks: Vec<SideName>,
    #[serde(default)]
    pub target: Option<AimBody>,
    #[serde(default)]
    pub direction: Option<DirectionName>,
    #[serde(default)]
    pub reference: Option<ReferenceName>,
}

#[derive(Debug, Deserialize)]
pub struct Changed {
    pub name: String,
    #[serde(default)]
    pub unit: String,
    pub change: f64,
    #[serde(default)]
    pub left: Option<LeftName>,
}
