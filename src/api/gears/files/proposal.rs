//! Proposed mapping of a table of nodes or points.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{
    fits::{nodes_text, spec::nodes::NodesBody},
    json::writer,
    measurand::{axes::AxesBody, units},
    problem::Problem,
    tables::{
        mapping::{ColumnBody, MappingBody, axis_unit},
        nodes,
    },
    warning::WarningBody,
};
use flankfit_engine::{
    estimation::Nodes,
    formats::{
        FileError, Table,
        table::{Decimal, FlankFault, HelixSign, Layout, Meaning, NodeSet, Separator, Unit},
    },
    gear::Side,
    words::rounded,
};

/// Additional parts of the response about a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = TableInclude)]
pub enum TableIncludeName {
    /// The nodes of the first flank, as a fit takes them.
    Nodes,
}

/// Source of a proposal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = TableProposedFrom)]
pub enum ProposedFromName {
    /// The mapping of the request.
    Mapping,
    /// The mapping by which the last table of this form and instrument became an iteration.
    Kept,
    /// The content of the file.
    File,
}

/// Proposed interpretation of a table. Its first six members are a mapping, to be sent with the
/// file to an import, with corrections.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = TableProposal, example = json!({
    "separator": ";", "decimal": ",", "header": true, "matrix": false,
    "columns": [
        {"name": "Rollweg [mm]", "meaning": "roll_length", "unit": "mm"},
        {"name": "Zahnbreite [mm]", "meaning": "face_width", "unit": "mm"},
        {"name": "Abweichung [µm]", "meaning": "deviation", "unit": "um"}
    ],
    "layout": "grid", "proposed_from": "file", "nodes": 132, "missing": 3, "flanks": [{"nodes": 132, "missing": 3}],
    "preview": {
        "text": "greatest deviation 12 µm, roll length 5.97–11.5 mm, face width 0.75–14.2 mm",
        "greatest_deviation_um": 11.96,
        "ranges": [
            {"column": 0, "meaning": "roll_length", "unit": "mm", "min": 5.9665, "max": 11.5183},
            {"column": 1, "meaning": "face_width", "unit": "mm", "min": 0.75, "max": 14.25},
            {"column": 2, "meaning": "deviation", "unit": "um", "min": -11.96, "max": 1.82}
        ]
    },
    "warnings": []
}))]
pub struct ProposalBody {
    /// Separator of cells.
    pub separator: Separator,
    /// The decimal sign.
    pub decimal: Decimal,
    /// True if a line with names precedes the numbers.
    pub header: bool,
    /// True if the first row holds v, the first column u, and everything else heights.
    pub matrix: bool,
    /// Every column in the order of the table; of a matrix the first column, the first row and the
    /// heights. Unknown columns are `ignore`.
    pub columns: Vec<ColumnBody>,
    /// Layout of the nodes; absent if their columns are not known.
    pub layout: Option<Layout>,
    /// Source of the members above.
    pub proposed_from: ProposedFromName,
    /// Nodes with a height, or points.
    pub nodes: usize,
    /// Rows without a height, and crossings of a grid without a row.
    pub missing: usize,
    /// The flanks that the table has nodes of, those with the most first; the first 1,000.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub flanks: Vec<TableFlankBody>,
    /// Axes of the nodes in the form of an iteration; absent if the columns are not those of a
    /// flank.
    pub axes: Option<AxesBody>,
    /// Preview of the numbers with this mapping.
    pub preview: PreviewBody,
    /// Assumptions, and parts that were left out.
    pub warnings: Vec<WarningBody>,
    /// With `include=nodes`: the nodes of the first flank.
    pub read: Option<NodesBody>,
}

/// A flank that a table has nodes of.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = TableFlank)]
pub struct TableFlankBody {
    /// Absent if the table does not give it.
    pub tooth: Option<String>,
    /// Absent if the table does not give it.
    pub flank: Option<Side>,
    /// Nodes with a height.
    pub nodes: usize,
    /// Rows without a height, and crossings of a grid without a row.
    pub missing: usize,
}

/// Preview of the numbers of a table.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = TablePreview)]
pub struct PreviewBody {
    /// In words.
    #[schema(example = "greatest deviation 20.8 µm, roll length 5.97–11.52 mm, face width 0.75–14.2 mm")]
    pub text: String,
    /// Greatest amount of a deviation; absent without deviations.
    pub greatest_deviation_um: Option<f64>,
    /// Range of every column with numbers.
    pub ranges: Vec<TableRangeBody>,
}

/// The least and the greatest number of a column.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = TableRange)]
pub struct TableRangeBody {
    /// Number of the column, from 0.
    pub column: usize,
    /// Meaning of the column.
    pub meaning: Meaning,
    /// Unit of the column; absent if it has none. Roll angles in radians are stored, and shown
    /// here, in `deg`.
    pub unit: Option<String>,
    /// The least number.
    pub min: f64,
    /// The greatest number.
    pub max: f64,
}

/// Answers what a table is read as: by the mapping, else by the one that was kept if the table can
/// be read by it. Processor work.
pub fn answer(
    content: &[u8],
    mapping: Option<&MappingBody>,
    kept: Option<&MappingBody>,
    with_nodes: bool,
) -> Result<Vec<u8>, Problem> {
    let by_kept = kept.and_then(|kept| nodes::table(content, Some(kept), "/file").ok());
    let (table, proposed_from) = match (by_kept, mapping) {
        (Some(table), _) => (table, ProposedFromName::Kept),
        (None, Some(_)) => (nodes::table(content, mapping, "/file")?, ProposedFromName::Mapping),
        (None, None) => (nodes::table(content, None, "/file")?, ProposedFromName::File),
    };
    let mut warnings: Vec<WarningBody> = table.notes.iter().map(|note| WarningBody::new(note.code(), note)).collect();
    let points = if table.holds_points() { table.points().map_or(0, |points| points.len()) } else { 0 };
    let (layout, sets) = match table.node_sets() {
        Ok(sets) => (Some(Layout::of(&sets)), sets),
        Err(_) if table.holds_points() => (Some(Layout::Points), Vec::new()),
        Err(error) => {
            warnings.push(unknown(&error));
            (None, Vec::new())
        }
    };
    for set in &sets {
        match set.crossings.map(|crossings| crossings.helix_sign()) {
            Some(HelixSign::Turned) => warnings.push(WarningBody::new("helices_turned", turned(set))),
            Some(HelixSign::Undetermined) => warnings.push(WarningBody::new("sign_assumed", sign_assumed(set))),
            Some(HelixSign::AsGiven) | None => {}
        }
    }
    for set in sets.iter().filter(|set| set.own_zeros.is_some()) {
        warnings.push(WarningBody::new("own_zeros_assumed", own_zeros(set)));
    }
    let zeros = sets.first().filter(|_| with_nodes).and_then(|set| set.own_zeros.as_ref());
    let proposal = ProposalBody {
        separator: table.separator,
        decimal: table.decimal,
        header: table.header,
        matrix: table.matrix,
        columns: table.columns.iter().map(ColumnBody::from).collect(),
        layout,
        proposed_from,
        nodes: points + sets.iter().map(|set| set.count).sum::<usize>(),
        missing: sets.iter().map(|set| set.missing).sum(),
        flanks: sets
            .iter()
            .take(1000)
            .map(|set| TableFlankBody {
                tooth: set.tooth.clone(),
                flank: set.flank,
                nodes: set.count,
                missing: set.missing,
            })
            .collect(),
        axes: layout.and_then(|layout| nodes::axes(&table, layout, zeros)),
        preview: preview(&table),
        warnings,
        read: None,
    };
    let mut text = writer::whole(&proposal).map_err(Problem::not_finite)?;
    let nodes: Option<Nodes> = sets.into_iter().next().filter(|_| with_nodes).and_then(|set| set.nodes.ok());
    if let Some(nodes) = nodes
        && text.pop_if(|last| *last == b'}').is_some()
    {
        // written as they are everywhere, which the body of the contract cannot do by itself
        text.extend_from_slice(b",\"read\":");
        text.extend(nodes_text::to_json(Arc::new(nodes)).whole());
        text.push(b'}');
    }
    Ok(text)
}

/// Why it is not known what the nodes of a table are.
fn unknown(error: &FileError) -> WarningBody {
    let fault = if let FileError::Table(fault) = error { Some(fault) } else { None };
    match fault.and_then(|fault| Some((fault.flanks?, &fault.message))) {
        Some((FlankFault::Unknown, message)) => WarningBody::new("flank_unknown", message),
        Some((FlankFault::TooMany, message)) => WarningBody::new("too_many_flanks", message),
        None => {
            let message = "the columns with places and heights are not known; name them as `columns`";
            WarningBody::new("columns_unknown", message)
        }
    }
}

/// Which helix traces are turned, and why.
fn turned(set: &NodeSet) -> String {
    format!(
        "{}: its helix traces have the opposite sign of the profiles that they cross, and are reversed",
        nodes::name_of(set)
    )
}

/// Which helix traces may count the other way.
fn sign_assumed(set: &NodeSet) -> String {
    format!(
        "{}: the crossings of its traces do not determine the sign of the helix traces; they are assumed to be \
         positive where material protrudes, like the profiles",
        nodes::name_of(set)
    )
}

/// Which traces have separate zeros, and how to say that they have not.
fn own_zeros(set: &NodeSet) -> String {
    format!(
        "{}: its traces do not agree at their crossings, or do not cross, so each is assumed to have its own zero, \
         which is subtracted; if all heights share one zero, map the column of traces as `ignore`",
        nodes::name_of(set)
    )
}

fn preview(table: &Table) -> PreviewBody {
    let mut ranges = Vec::new();
    let mut words = Vec::new();
    let mut greatest = None;
    for (column, spec) in table.columns.iter().enumerate() {
        let Some(numbers) = table.numbers_at(column) else { continue };
        let least = numbers.iter().copied().filter(|x| !x.is_nan()).min_by(f64::total_cmp);
        let most = numbers.iter().copied().filter(|x| !x.is_nan()).max_by(f64::total_cmp);
        let (Some(min), Some(max)) = (least, most) else { continue };
        let unit = spec.unit.map(axis_unit);
        let shown = unit.map_or(String::new(), |unit| format!(" {}", units::sign(unit)));
        match (spec.meaning, spec.unit.and_then(Unit::millimetres)) {
            (Meaning::Deviation, Some(mm)) => {
                let um = unit.and_then(units::micrometres).unwrap_or(1e3 * mm) * min.abs().max(max.abs());
                greatest = Some(um).filter(|um| um.is_finite());
                words.insert(0, format!("greatest deviation {} µm", rounded(um, 3)));
            }
            (Meaning::RollLength | Meaning::Diameter | Meaning::RollAngle | Meaning::FaceWidth, _) => {
                let name = spec.meaning.name().replace('_', " ");
                words.push(format!("{name} {}–{}{shown}", rounded(min, 3), rounded(max, 3)));
            }
            (Meaning::Weight | Meaning::I | Meaning::J | Meaning::K, _) => {}
            _ => words.push(format!("{} {}–{}{shown}", spec.meaning.name(), rounded(min, 3), rounded(max, 3))),
        }
        ranges.push(TableRangeBody { column, meaning: spec.meaning, unit: unit.map(str::to_owned), min, max });
    }
    PreviewBody { text: words.join(", "), greatest_deviation_um: greatest, ranges }
}
