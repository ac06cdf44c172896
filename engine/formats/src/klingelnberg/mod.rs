//! Gear measurements of Klingelnberg's instruments: curves (`.mka`) and values (`.mew`).
//!
//! Both begin with a line `HEADER KS.MK.FILE` or `HEADER KS.MW.FILE`, a preamble `KEY value !
//! comment`, and numbered header lines. The number of a header line alone determines its meaning,
//! since its label follows the language of the instrument; that of a curve is the letter of its
//! section (`x=`, `d=`, `z=`). Curves come in blocks of traces, each with its tooth, flank and
//! number of values; values as numbered results.
//!
//! Conventions. Deviations are µm with the sign that is stored; [`Signs`] turns it. An undefined
//! point is NaN and counted, never left out. Positions are found with a gear's base circle
//! ([`Curves::place`]): samples are equidistant in **roll length** from the start to the end of the
//! measuring range for profiles, whatever the range is given in, and equidistant in z for leads.
//! With equal steps of roll length the slopes of a measured gear's 8 profiles come out 0.15 to 0.27
//! µm from the instrument's, with equal steps of diameter 0.3 to 0.7 µm.

mod curves;
mod header;
mod position;
mod results;
mod settings;
mod sign;
mod tables;
mod thickness;
mod trace_head;
mod values;

pub use curves::{Block, Curve, Curves, Section};
pub use header::{FileKind, Header, HeaderLine, Setting};
pub use position::{PositionedTrace, PositionedTraces, UnpositionedTrace};
pub use results::{Characteristic, MeasuringPosition, Statistic};
pub use settings::{HelixSetup, Length, PlusMaterial, ProfileAxis, ProfileSetup, Range, Rules, SectionPlane, Sides};
pub use sign::{SignConvention, Signs};
pub use tables::{Contact, Diameters, PitchRow, PitchTable, WhichDiameter};
pub use thickness::{Spread, Thickness};
pub use values::{ResultLine, ResultValue, Values};

use super::{file_error::FileError, source::decode};

/// Reads a file of curves (`.mka`).
///
/// ```
/// use flankfit_formats::klingelnberg::read_curves;
///
/// let file = read_curves(
///     b"HEADER KS.MK.FILE\nTYPE      STI\nSEPARATOR :\nUNITS     mm\nUNDEFINED -2147483.648\n\n\
///       Profil:\nZahn-Nr.: 1 rechts / 3  Werte  z= 7.5\n 0.5 -2147483.648 -1.25\n\n",
/// )?;
/// // µm; what was not measured keeps its place.
/// let curve = &file.curves[0];
/// assert_eq!((curve.tooth.as_str(), curve.undefined), ("1", 1));
/// assert_eq!((curve.values[0], curve.values[2]), (0.5, -1.25));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_curves(bytes: &[u8]) -> Result<Curves, FileError> {
    parse_curves(&decode(bytes)?)
}

/// Reads a file of values (`.mew`).
pub fn read_values(bytes: &[u8]) -> Result<Values, FileError> {
    parse_values(&decode(bytes)?)
}

pub(super) fn parse_curves(text: &str) -> Result<Curves, FileError> {
    Curves::parse(text)
}

pub(super) fn parse_values(text: &str) -> Result<Values, FileError> {
    Values::parse(text)
}

/// Kind of a text.
pub(super) fn kind_of(text: &str) -> Option<FileKind> {
    header::kind_of(super::source::Lines::new(text).find(|line| !line.is_blank())?.text)
}
