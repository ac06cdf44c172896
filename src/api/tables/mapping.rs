//! How a table is to be read.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{
    json::{error::ReadError, value::read_json_at},
    measurand::units,
};
use flankfit_engine::formats::table::{ColumnSpec, Decimal, Layout, Mapping, Meaning, Separator, Unit};

/// How a table of nodes or points is to be read: as `POST /v1/nodes/read` proposes it, with
/// whatever is to be otherwise. What is left out is found from the content.
#[skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = TableMapping, example = json!({"separator": ";", "decimal": ","}))]
pub struct MappingBody {
    /// What separates cells.
    pub separator: Option<SeparatorName>,
    /// The decimal sign.
    pub decimal: Option<DecimalName>,
    /// Whether a line with names comes before the numbers.
    pub header: Option<bool>,
    /// Whether the first row holds v, the first column u and everything else heights.
    pub matrix: Option<bool>,
    /// Every column in the order of the table; of a matrix the first column, the first row and the
    /// heights.
    pub columns: Option<Vec<ColumnBody>>,
    /// How the nodes lie. `scattered` takes nodes that are on a grid as scattered ones; anything
    /// else is compared with what the table holds.
    pub layout: Option<LayoutName>,
}

/// A column of a table.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = TableColumn)]
pub struct ColumnBody {
    /// As the header has it; left out without a header. It changes nothing.
    pub name: Option<String>,
    /// What it holds.
    pub meaning: MeaningName,
    /// Its unit: `nm`, `um`, `mm` or `in`, of roll angles `deg`, `arcmin` or `rad`; `µm` is read
    /// too. Left out it is µm for deviations, deg for roll angles and mm for other places on a
    /// flank.
    #[schema(example = "um")]
    pub unit: Option<UnitName>,
}

/// Declares an enum of the wire beside one of the engine.
macro_rules! names {
    (
        $(#[$docs:meta])* $name:ident of $engine:ident {
            $($(#[$doc:meta])* $variant:ident = $text:tt $(| $other:tt)*,)*
        }
    ) => {
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
        $(#[$docs])*
        pub enum $name {
            $($(#[$doc])* #[serde(rename = $text $(, alias = $other)*)] $variant,)*
        }

        impl From<$engine> for $name {
            fn from(value: $engine) -> Self {
                match value {
                    $($engine::$variant => $name::$variant,)*
                }
            }
        }

        impl From<$name> for $engine {
            fn from(value: $name) -> Self {
                match value {
                    $($name::$variant => $engine::$variant,)*
                }
            }
        }
    };
}

names! {
    /// What separates the cells of a table.
    #[schema(as = TableSeparator)]
    SeparatorName of Separator {
        Comma = ",",
        Semicolon = ";",
        Tab = "tab",
        /// Any number of blanks and tabs.
        Spaces = "spaces",
    }
}

names! {
    /// The decimal sign of a table.
    #[schema(as = TableDecimal)]
    DecimalName of Decimal {
        Point = ".",
        Comma = ",",
    }
}

names! {
    /// How the nodes of a table lie.
    #[schema(as = TableLayout)]
    LayoutName of Layout {
        /// On the crossings of a few u and v; nodes may be missing.
        Grid = "grid",
        /// Anywhere on a surface.
        Scattered = "scattered",
        /// Along a curve.
        Curve = "curve",
        /// Points in space.
        Points = "points",
    }
}

names! {
    /// What a column of a table holds.
    #[schema(as = TableMeaning)]
    MeaningName of Meaning {
        /// Place along the profile; so are `diameter` and `roll_angle`.
        RollLength = "roll_length",
        Diameter = "diameter",
        RollAngle = "roll_angle",
        /// Place along the face width.
        FaceWidth = "face_width",
        /// Height.
        Deviation = "deviation",
        /// First abscissa of a surface that is none of a flank.
        U = "u",
        /// Second abscissa of such a surface.
        V = "v",
        /// Coordinate of a point, or abscissa of a curve.
        X = "x",
        /// Coordinate of a point, or height of a curve.
        Y = "y",
        /// Coordinate of a point, or height of a surface.
        Z = "z",
        /// Direction of a point; so are `j` and `k`.
        I = "i",
        J = "j",
        K = "k",
        Weight = "weight",
        /// Number or name of the tooth.
        Tooth = "tooth",
        /// The flank: left or right, links or rechts, L or R.
        Flank = "flank",
        /// Whether a trace is a profile or a helix.
        Trace = "trace",
        /// Name of a point.
        Id = "id",
        /// It is not read.
        Ignore = "ignore",
    }
}

names! {
    /// Unit of a column of a table.
    #[schema(as = TableUnit)]
    UnitName of Unit {
        Nanometre = "nm",
        Micrometre = "um" | "µm" | "μm",
        Millimetre = "mm",
        Inch = "in",
        Degree = "deg" | "°",
        ArcMinute = "arcmin" | "′",
        Radian = "rad",
    }
}

/// Reads the part `mapping` of a form.
pub fn read(text: Option<&[u8]>) -> Result<Option<MappingBody>, ReadError> {
    text.map(|text| read_json_at(text, "/mapping")).transpose()
}

impl From<&MappingBody> for Mapping {
    fn from(body: &MappingBody) -> Self {
        Mapping {
            separator: body.separator.map(Into::into),
            decimal: body.decimal.map(Into::into),
            header: body.header,
            matrix: body.matrix,
            columns: body.columns.as_ref().map(|columns| columns.iter().map(ColumnSpec::from).collect()),
            layout: body.layout.map(Into::into),
        }
    }
}

impl From<&ColumnBody> for ColumnSpec {
    /// The name is that of the header.
    fn from(body: &ColumnBody) -> Self {
        ColumnSpec { name: String::new(), meaning: body.meaning.into(), unit: body.unit.map(Into::into) }
    }
}

impl From<&ColumnSpec> for ColumnBody {
    fn from(column: &ColumnSpec) -> Self {
        ColumnBody {
            name: Some(column.name.clone()).filter(|name| !name.is_empty()),
            meaning: column.meaning.into(),
            unit: column.unit.map(Into::into),
        }
    }
}

/// The unit of the numbers that are read of a column, as axes call it.
pub fn axis_unit(unit: Unit) -> &'static str {
    // radians are read as degrees
    units::canonical(if unit == Unit::Radian { "deg" } else { unit.name() })
}
