//! Reader of every file of measurements and gears, recognised by its content.

use super::{
    archive,
    file_error::{FileError, shown},
    klingelnberg::{self, Curves, FileKind, Values},
    rexs::{self, RexsModel},
    source::decode,
    table::{self, Mapping, Table},
};

/// Content of a file.
#[derive(Clone, Debug, PartialEq)]
pub enum GearFile {
    /// `.mka`
    Curves(Box<Curves>),
    /// `.mew`
    Values(Box<Values>),
    /// REXS 1.x and 2.x
    Model(RexsModel),
    /// A table of nodes or points.
    Table(Box<Table>),
}

/// Reads a file. Its content decides; the ending of its `name` only says what was meant where the
/// content fits nothing, so that the error can name the line that is wrong. A `mapping` says that
/// it is a table, and which one.
///
/// ```
/// use flankfit_formats::{GearFile, gear_file};
///
/// // The content decides, whatever the file is called.
/// let file = gear_file::read(b"x,y,z\n1,2,3\n", Some("flank.mka"), None)?;
/// assert!(matches!(file, GearFile::Table(table) if table.rows() == 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read(bytes: &[u8], name: Option<&str>, mapping: Option<&Mapping>) -> Result<GearFile, FileError> {
    let unpacked = bytes.starts_with(archive::MAGIC).then(|| archive::unpack(bytes)).transpose()?;
    let (bytes, name) = match &unpacked {
        Some((name, bytes)) => (bytes.as_slice(), Some(name.as_str())),
        None => (bytes, name),
    };
    let text = decode(bytes)?;
    let parse_table = |mapping: &Mapping| table::parse(&text, mapping).map(|table| GearFile::Table(Box::new(table)));
    if let Some(mapping) = mapping {
        return parse_table(mapping);
    }
    let start = text.trim_start();
    let ending = name.and_then(|name| name.rsplit_once('.')).map(|(_, ending)| ending.to_lowercase());
    let meant = |endings: &[&str]| ending.as_deref().is_some_and(|ending| endings.contains(&ending));
    match klingelnberg::kind_of(&text) {
        Some(FileKind::Curves) => return Ok(GearFile::Curves(Box::new(klingelnberg::parse_curves(&text)?))),
        Some(FileKind::Values) => return Ok(GearFile::Values(Box::new(klingelnberg::parse_values(&text)?))),
        None => {}
    }
    if start.starts_with(['<', '{']) {
        return rexs::parse(&text).map(GearFile::Model);
    }
    if table::looks_like_a_table(&text) {
        return parse_table(&Mapping::default());
    }
    if meant(&["mka"]) {
        return klingelnberg::parse_curves(&text).map(|file| GearFile::Curves(Box::new(file)));
    }
    if meant(&["mew"]) {
        return klingelnberg::parse_values(&text).map(|file| GearFile::Values(Box::new(file)));
    }
    if meant(&["rexs", "rexsj", "xml"]) {
        return rexs::parse(&text).map(GearFile::Model);
    }
    if meant(&["csv", "txt", "tsv", "dat", "asc"]) {
        return parse_table(&Mapping::default());
    }
    let place = super::source::place_in(&text, text.len() - start.len());
    Err(FileError::Unrecognised { place, found: shown(start.lines().next().unwrap_or_default()) })
}
