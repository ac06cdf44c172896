//! Corrections of a machine under the names of OPC UA for Geometrical Measuring Systems 1.0 (OPC
//! 40210, `CorrectionType`).
//!
//! That standard names variables in an address space and no file. The text written here is CSV, a
//! line for each correction with the names of its variables as header: what an operator opens, a
//! machine control imports, and a server maps one column to one variable; a structured form is the
//! interface's own answer from the same [`Correction`]s.
//!
//! A correction has an absolute value, a relative one, or both: here the relative value is the
//! change to be added to the setting, the absolute one the setting after it. Limits are those of
//! the absolute value, or of the change where that is all there is.

use super::{number::real, table::field};
use flankfit_numerics::check::Faults;

/// Unit of a correction, as OPC UA has it: a code of UN/CEFACT recommendation 20.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Unit {
    /// µm, code 4H.
    Micrometre,
    /// mm, code MMT.
    Millimetre,
    /// Degree of angle, code DD.
    Degree,
    /// Minute of arc, code D61.
    ArcMinute,
    /// Second of arc, code D62.
    ArcSecond,
    /// rad, code C81.
    Radian,
    /// mrad, code C25.
    Milliradian,
    /// µrad, code B97.
    Microradian,
    /// Per cent, code P1.
    Percent,
    /// A number without unit.
    One,
    /// Another one, by its name alone.
    Other(String),
}

impl Unit {
    /// The unit of that name or sign.
    pub fn named(name: &str) -> Self {
        match name.trim() {
            "µm" | "μm" | "um" => Unit::Micrometre,
            "mm" => Unit::Millimetre,
            "°" | "deg" => Unit::Degree,
            "′" | "'" | "arcmin" => Unit::ArcMinute,
            "″" | "arcsec" => Unit::ArcSecond,
            "rad" => Unit::Radian,
            "mrad" => Unit::Milliradian,
            "µrad" | "μrad" | "urad" => Unit::Microradian,
            "%" => Unit::Percent,
            "" | "1" => Unit::One,
            other => Unit::Other(other.to_owned()),
        }
    }

    /// Displayed name of the unit.
    pub fn display_name(&self) -> &str {
        match self {
            Unit::Micrometre => "µm",
            Unit::Millimetre => "mm",
            Unit::Degree => "°",
            Unit::ArcMinute => "′",
            Unit::ArcSecond => "″",
            Unit::Radian => "rad",
            Unit::Milliradian => "mrad",
            Unit::Microradian => "µrad",
            Unit::Percent => "%",
            Unit::One => "1",
            Unit::Other(name) => name,
        }
    }

    /// The common code; `None` for other units.
    pub fn code(&self) -> Option<&'static str> {
        Some(match self {
            Unit::Micrometre => "4H",
            Unit::Millimetre => "MMT",
            Unit::Degree => "DD",
            Unit::ArcMinute => "D61",
            Unit::ArcSecond => "D62",
            Unit::Radian => "C81",
            Unit::Milliradian => "C25",
            Unit::Microradian => "B97",
            Unit::Percent => "P1",
            Unit::One => "C62",
            Unit::Other(_) => return None,
        })
    }

    /// `UnitId` of `EUInformation`: the characters of the code as bytes of a number, the first one
    /// highest (OPC 10000-8), −1 without a code.
    ///
    /// ```
    /// use flankfit_formats::gms::Unit;
    ///
    /// // MMT, read as bytes: 0x4D, 0x4D, 0x54.
    /// assert_eq!(Unit::named("mm").id(), 0x4D4D54);
    /// ```
    pub fn id(&self) -> i32 {
        self.code().map_or(-1, |code| code.bytes().fold(0, |id, byte| id << 8 | i32::from(byte)))
    }
}

/// A correction value for one characteristic.
#[derive(Clone, Debug, PartialEq)]
pub struct Correction {
    /// `Identifier`, unique in its list.
    pub identifier: String,
    /// `CharacteristicIdentifier`: what is corrected.
    pub characteristic: String,
    /// `CorrectionValueRelative`: change of the setting.
    pub relative: Option<f64>,
    /// `CorrectionValueAbsolute`: the setting after the change.
    pub absolute: Option<f64>,
    /// `UpperControlLimit`
    pub upper_limit: Option<f64>,
    /// `LowerControlLimit`
    pub lower_limit: Option<f64>,
    /// `EngineeringUnits` of all four values.
    pub unit: Unit,
    /// `Description`
    pub description: Option<String>,
    /// `ProgramName` of the machine or measuring program.
    pub program: Option<String>,
}

/// Columns, in the order of the standard's table; variables with a unit have it as a property.
pub const COLUMNS: [&str; 10] = [
    "Identifier",
    "CharacteristicIdentifier",
    "CorrectionValueRelative",
    "CorrectionValueAbsolute",
    "UpperControlLimit",
    "LowerControlLimit",
    "EngineeringUnits.DisplayName",
    "EngineeringUnits.UnitId",
    "Description",
    "ProgramName",
];

/// Writes a list of corrections: a header, then one line each with CRLF (RFC 4180). The columns of
/// the standard are followed by those of `about`, names with values, which identify what the
/// corrections are for.
pub fn write_csv(corrections: &[Correction], about: &[(&str, String)]) -> Result<String, Faults> {
    check(corrections)?;
    let names = COLUMNS.iter().copied().chain(about.iter().map(|(name, _)| *name));
    let mut out = names.collect::<Vec<_>>().join(",");
    out.push_str("\r\n");
    for correction in corrections {
        let value = |value: Option<f64>| value.map(real).unwrap_or_default();
        let text = |text: &Option<String>| text.as_deref().map(field).unwrap_or_default();
        let fields = [
            field(&correction.identifier),
            field(&correction.characteristic),
            value(correction.relative),
            value(correction.absolute),
            value(correction.upper_limit),
            value(correction.lower_limit),
            field(correction.unit.display_name()),
            correction.unit.id().to_string(),
            text(&correction.description),
            text(&correction.program),
        ];
        out.push_str(&fields.join(","));
        about.iter().for_each(|(_, value)| {
            out.push(',');
            out.push_str(&field(value));
        });
        out.push_str("\r\n");
    }
    Ok(out)
}

/// Refuses what is no correction by the standard: named, with a value, with limits in their order.
pub fn check(corrections: &[Correction]) -> Result<(), Faults> {
    let mut seen = std::collections::HashMap::with_capacity(corrections.len());
    for (index, correction) in corrections.iter().enumerate() {
        for (name, text) in [("identifier", &correction.identifier), ("characteristic", &correction.characteristic)] {
            if text.trim().is_empty() {
                return Err(Faults::one(
                    format_args!("[{index}].{name}"),
                    format_args!("correction {index} has no {name}"),
                ));
            }
        }
        if let Some(first) = seen.insert(correction.identifier.as_str(), index) {
            let identifier = &correction.identifier;
            return Err(Faults::one(
                format_args!("[{index}].identifier"),
                format_args!("corrections {first} and {index} have the same identifier {identifier}"),
            ));
        }
        let values = [
            ("relative", "the relative value", correction.relative),
            ("absolute", "the absolute value", correction.absolute),
            ("upper_limit", "the upper limit", correction.upper_limit),
            ("lower_limit", "the lower limit", correction.lower_limit),
        ];
        for (field, name, value) in values {
            if let Some(value) = value.filter(|value| !value.is_finite()) {
                return Err(Faults::one(
                    format_args!("[{index}].{field}"),
                    format_args!("correction {index}: {name} is {value}, not a finite number"),
                ));
            }
        }
        if correction.relative.is_none() && correction.absolute.is_none() {
            let message = format_args!("correction {index} has neither an absolute nor a relative value");
            return Err(Faults::one(format_args!("[{index}]"), message));
        }
        if let (Some(lower), Some(upper)) = (correction.lower_limit, correction.upper_limit)
            && lower > upper
        {
            return Err(Faults::one(
                format_args!("[{index}].lower_limit"),
                format_args!("correction {index}: the lower limit {lower} lies above the upper one, {upper}"),
            ));
        }
    }
    Ok(())
}
