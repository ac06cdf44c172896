//! Contents of a file of a gear tester: its traces, and the values that it prints.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use flankfit_engine::{
    formats::{
        klingelnberg::{Characteristic, Curve, MeasuringPosition, ResultLine, ResultValue, Section, Statistic},
        rexs::RexsTrace,
    },
    gear::{Kind, Side},
};

/// A trace of a file. An import turns the traces of one flank of one tooth (without the letter
/// after its number) into nodes; `tooth` and `flank` of the import name it.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = FileTrace)]
pub struct FileTraceBody {
    /// Tooth as in evaluations: a letter after the number marks a trace off the middle.
    pub tooth: String,
    pub flank: Side,
    pub kind: Kind,
    /// All samples of the trace.
    pub samples: usize,
    /// Samples without a deviation.
    pub undefined: usize,
    /// For a profile: its z, if the file has it.
    pub section_z_mm: Option<f64>,
    /// For a helix: its diameter, if the file has it.
    pub section_diameter_mm: Option<f64>,
    /// For a helix: the roll length of its cylinder, if the file has it.
    pub section_roll_length_mm: Option<f64>,
    /// Its first line in the file, from 1.
    pub line: usize,
}

/// A value that a file prints.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = FileValue)]
pub struct FileValueBody {
    /// Code of the value in the instrument.
    pub code: u32,
    /// Printed name.
    pub name: String,
    /// Its symbol, such as `f_Halpha`; absent if the code is not known.
    pub characteristic: Option<String>,
    pub position: MeasuringPosition,
    pub statistic: Statistic,
    /// Flank of the value; absent if it belongs to none.
    pub flank: Option<Side>,
    /// For a value of one tooth: the tooth, if the label names it.
    pub tooth: Option<String>,
    /// In `unit`; absent if there is none, for the reason in `state`.
    pub value: Option<f64>,
    /// `um` or `mm`; absent if the code is not known.
    pub unit: Option<String>,
    pub state: FileValueStateName,
    /// Its line in the file, from 1.
    pub line: usize,
}

/// State of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = FileValueState)]
pub enum FileValueStateName {
    Measured,
    NotMeasured,
    /// It could not be formed.
    NotAvailable,
}

impl From<&Curve> for FileTraceBody {
    fn from(curve: &Curve) -> Self {
        let mut body = FileTraceBody {
            tooth: curve.tooth.clone(),
            flank: curve.side,
            kind: curve.kind,
            samples: curve.values.len(),
            undefined: curve.undefined,
            section_z_mm: None,
            section_diameter_mm: None,
            section_roll_length_mm: None,
            line: curve.line,
        };
        match curve.section {
            Section::Z(z) => body.section_z_mm = Some(z),
            Section::Diameter(diameter) => body.section_diameter_mm = Some(diameter),
            Section::RollLength(length) => body.section_roll_length_mm = Some(length),
            Section::NotGiven => {}
        }
        body
    }
}

/// Returns a measured trace of a model; all traces of a model are on one tooth.
pub(super) fn of_model(trace: &RexsTrace, side: Side) -> FileTraceBody {
    let kind = trace.kind();
    FileTraceBody {
        tooth: "1".to_owned(),
        flank: side,
        kind,
        samples: trace.deviation.len(),
        undefined: trace.deviation.iter().filter(|deviation| deviation.is_nan()).count(),
        section_z_mm: trace.section.filter(|_| kind == Kind::Profile),
        section_diameter_mm: trace.section.filter(|_| kind == Kind::Helix),
        section_roll_length_mm: None,
        line: trace.line,
    }
}

impl From<&ResultLine> for FileValueBody {
    fn from(result: &ResultLine) -> Self {
        FileValueBody {
            code: result.code,
            name: result.name.clone(),
            characteristic: result.characteristic.map(|of| of.symbol().to_owned()),
            position: result.place,
            statistic: result.statistic,
            flank: result.side,
            tooth: result.tooth.clone(),
            value: result.reading.value(),
            unit: result.characteristic.map(|of| unit(of).to_owned()),
            state: match result.reading {
                ResultValue::Value(_) => FileValueStateName::Measured,
                ResultValue::NotMeasured => FileValueStateName::NotMeasured,
                ResultValue::NotAvailable => FileValueStateName::NotAvailable,
            },
            line: result.line,
        }
    }
}

/// The unit that instruments print a characteristic in.
fn unit(of: Characteristic) -> &'static str {
    match of {
        Characteristic::RootDiameter
        | Characteristic::TipDiameter
        | Characteristic::DimensionOverBalls
        | Characteristic::Span => "mm",
        _ => "um",
    }
}
