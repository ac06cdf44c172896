//! Gear models in REXS 1.0 to 2.0, as XML or JSON: the cylindrical gears of a model and the
//! measurements of their flanks.
//!
//! A gear is a component of type `cylindrical_gear` or `ring_gear`. Pressure angle and profile
//! shift are attributes of its flanks (components `flank_geometry` up to version 1.2,
//! `cylindrical_gear_flank` from 1.3 on, tied to it by a relation of type `flank` with the roles
//! `gear`, `left` and `right`) or of the gear itself. Lengths and angles are converted by the unit
//! that each attribute names. A positive helix angle is right-hand (ISO 21771).
//!
//! A topography is three lists on a flank, `topographical_deviation_amounts`,
//! `diameters_of_topographical_deviation` and `coordinates_of_topographical_deviation`: one amount
//! for each pair of diameter and coordinate (then the coordinates run fastest, which is noted as
//! assumed, since the specification names no order), or one amount for each entry of two lists of
//! the same length. Version 2.0 has none of the three. Amounts keep their sign.
//!
//! Measured traces are components `profile_deviation` and `helix_deviation` (since 1.2), which a
//! relation of type `reference` ties to their flank (roles `origin` and `referenced`): amounts at
//! diameters or roll lengths of a profile, or at coordinates of a helix.
//!
//! Document types and entities other than the five of XML are refused. Results of load cases are
//! ignored.

mod base64;
mod document;
mod json;
mod model;
mod topography;

pub use model::{RexsFlank, RexsGear, RexsModel, RexsTrace, ScatteredDeviation, TracePlaces};

use super::{file_error::FileError, source::decode};

/// Reads a model.
///
/// ```
/// use flankfit_formats::rexs;
///
/// let model = rexs::read(
///     br#"<model version="1.4"><components>
///           <component id="15" type="cylindrical_gear" name="pinion">
///             <attribute id="number_of_teeth" unit="none">27</attribute>
///             <attribute id="normal_module" unit="mm">4.5</attribute>
///           </component>
///         </components></model>"#,
/// )?;
/// let facts = &model.gears[0].facts;
/// assert_eq!((facts.teeth, facts.normal_module), (Some(27), Some(4.5)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read(bytes: &[u8]) -> Result<RexsModel, FileError> {
    parse(&decode(bytes)?)
}

pub(super) fn parse(text: &str) -> Result<RexsModel, FileError> {
    let document = if text.trim_start().starts_with('{') { json::parse(text) } else { document::Document::parse(text) };
    RexsModel::of(text, document?)
}
