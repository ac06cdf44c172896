//! A file, read by what it is.

use super::{
    content::{FileRead, nothing_measured, unreadable},
    curves, points,
    spec::ImportSpecBody,
};
use crate::api::{gears::requirements::RequirementsBody, problem::Problem};
use flankfit_engine::{
    formats::gear_file::{self, GearFile},
    gear::Gear,
};

/// Reads a file; `own` is the gear of the job that it belongs to, and `required` what its flanks
/// must be like. Processor work.
pub fn read(
    bytes: &[u8],
    name: Option<&str>,
    spec: &ImportSpecBody,
    own: Option<&Gear>,
    required: Option<RequirementsBody>,
) -> Result<FileRead, Problem> {
    let posted = spec.gear.as_ref().map(|gear| gear.checked("/spec/gear")).transpose().map_err(Problem::invalid)?;
    let own = posted.as_ref().or(own);
    let file = gear_file::read(bytes, name).map_err(|error| unreadable(&error))?;
    spec.belongs_to(&file)?;
    match file {
        GearFile::Curves(curves) => curves::read(&curves, spec, own, required),
        GearFile::Points(points) => points::of_list(&points, spec, own),
        GearFile::Values(values) => Err(nothing_measured(&format!(
            "a file of {} results; import the file of curves (.mka) that they were made of",
            values.results.len()
        ))),
        GearFile::Model(model) => points::of_model(&model, spec, own, required),
    }
}
