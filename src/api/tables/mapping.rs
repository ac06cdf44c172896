//! How a table is to be read.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{
    json::{error::ReadError, value::read_json_at},
    measurand::units,
};
use flankfit_engine::formats::table::{ColumnSpec, Decimal, Layout, Mapping, Meaning, Separator, Unit};

/// How to read a table of nodes or points: the proposal of `POST /v1/nodes/read`, with corrections.
/// Omitted fields are found from the content.
#[skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = TableMapping, example = json!({"separator": ";", "decimal": ","}))]
pub struct MappingBody {
    /// Separator of cells.
    pub separator: Option<Separator>,
    /// The decimal sign.
    pub decimal: Option<Decimal>,
    /// True if a line with names precedes the numbers.
    pub header: Option<bool>,
    /// True if the first row holds v, the first column u, and everything else heights.
    pub matrix: Option<bool>,
    /// Every column in the order of the table; of a matrix the first column, the first row and the
    /// heights.
    pub columns: Option<Vec<ColumnBody>>,
    /// Layout of the nodes. `scattered` treats nodes on a grid as scattered; any other value is
    /// checked against the table.
    pub layout: Option<Layout>,
}

/// A column of a table.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = TableColumn)]
pub struct ColumnBody {
    /// Name in the header; absent without a header. It has no effect.
    pub name: Option<String>,
    /// Meaning of the column.
    pub meaning: Meaning,
    /// Its unit: `nm`, `um`, `mm` or `in`, for roll angles `deg`, `arcmin` or `rad`; `µm` is
    /// accepted too. By default µm for deviations, deg for roll angles and mm for other places on a
    /// flank.
    #[schema(example = "um")]
    pub unit: Option<Unit>,
}

/// Reads the part `mapping` of a form.
pub fn read(text: Option<&[u8]>) -> Result<Option<MappingBody>, ReadError> {
    text.map(|text| read_json_at(text, "/mapping")).transpose()
}

impl From<&MappingBody> for Mapping {
    fn from(body: &MappingBody) -> Self {
        Mapping {
            separator: body.separator,
            decimal: body.decimal,
            header: body.header,
            matrix: body.matrix,
            columns: body.columns.as_ref().map(|columns| columns.iter().map(ColumnSpec::from).collect()),
            layout: body.layout,
        }
    }
}

impl From<&ColumnBody> for ColumnSpec {
    /// The name is that of the header.
    fn from(body: &ColumnBody) -> Self {
        ColumnSpec { name: String::new(), meaning: body.meaning, unit: body.unit }
    }
}

impl From<&ColumnSpec> for ColumnBody {
    fn from(column: &ColumnSpec) -> Self {
        ColumnBody {
            name: Some(column.name.clone()).filter(|name| !name.is_empty()),
            meaning: column.meaning,
            unit: column.unit,
        }
    }
}

/// The unit of the numbers that are read of a column, as axes call it.
pub fn axis_unit(unit: Unit) -> &'static str {
    // radians are read as degrees
    units::canonical(if unit == Unit::Radian { "deg" } else { unit.name() })
}
