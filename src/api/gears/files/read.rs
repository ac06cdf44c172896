//! A file, read by what it is.

use super::{
    content::{FileRead, nothing_measured, unreadable},
    curves, points,
    spec::ImportSpecBody,
};
use crate::api::{gears::requirements::RequirementsBody, problem::Problem, tables::mapping::MappingBody};
use flankfit_engine::{
    formats::{
        gear_file::{self, GearFile},
        table::Mapping,
    },
    gear::Gear,
};

/// Reads a file by what it is.
pub fn parsed(
    bytes: &[u8],
    name: Option<&str>,
    spec: &ImportSpecBody,
    mapping: Option<&MappingBody>,
) -> Result<GearFile, Problem> {
    let mapping = mapping.map(Mapping::from);
    let file = gear_file::read(bytes, name, mapping.as_ref()).map_err(|error| unreadable(&error))?;
    spec.belongs_to(&file)?;
    Ok(file)
}

/// Reads a file; `own` is the gear of the job that it belongs to, and `required` what its flanks
/// must be like. Processor work.
pub fn read(
    bytes: &[u8],
    name: Option<&str>,
    spec: &ImportSpecBody,
    own: Option<&Gear>,
    required: Option<RequirementsBody>,
) -> Result<FileRead, Problem> {
    measured(parsed(bytes, name, spec, None)?, spec, own, required)
}

/// Reads the measurements of a gear from a file.
pub fn measured(
    file: GearFile,
    spec: &ImportSpecBody,
    own: Option<&Gear>,
    required: Option<RequirementsBody>,
) -> Result<FileRead, Problem> {
    let posted = spec.gear.as_ref().map(|gear| gear.checked("/spec/gear")).transpose().map_err(Problem::invalid)?;
    let own = posted.as_ref().or(own);
    match file {
        GearFile::Curves(curves) => curves::read(&curves, spec, own, required),
        GearFile::Table(table) => {
            let list = table.points().map_err(|error| unreadable(&error))?;
            points::of_list(&list, spec, own)
        }
        GearFile::Values(values) => Err(nothing_measured(&format!(
            "a file of {} results; import the file of curves (.mka) with their data",
            values.results.len()
        ))),
        GearFile::Model(model) => points::of_model(&model, spec, own, required),
    }
}
