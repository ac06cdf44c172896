//! `demo --nodes FILE`: whatever a caller has at hand, as fit requests.
//!
//! - JSON: a fit request, or a `nodes` object alone.
//! - a table of nodes, as `POST /v1/nodes/read` reads it; an empty height is a missing node. Of one
//!   with traces of a gear tester, of each flank the tooth with the most nodes.
//! - what `POST …/import` takes: curves of a gear tester (.mka), a REXS model with topographies. Of
//!   each flank the tooth with the most nodes.

use std::{collections::BTreeSet, path::Path, sync::Arc};

use flankfit_engine::{
    estimation::{
        FitSpec, Nodes, Plans,
        spec::{Degree, Model, PolynomialBasis, Terms},
    },
    formats::{
        Table,
        table::{Crossings, Layout, Meaning, NodeSet as TableNodes},
    },
    gear::{Side, evaluation::OwnZeros},
};
use serde_json::{Value, json};

use super::numbers::short;
use crate::{
    api::{
        fits::nodes_text,
        gears::files::{content, read, spec::ImportSpecBody},
        jobs::{fits::compute_at, import::surfaces},
        problem::Problem,
        tables::nodes,
    },
    cli::{CommandError, content_of},
};

/// Nodes to be shown, as the body of a fit request.
#[derive(Debug)]
pub struct NodeSet {
    pub name: String,
    pub request: Value,
    pub units: Units,
    /// Report of nodes read and left out.
    pub report: String,
}

/// Meaning of the numbers of a node set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Units {
    /// Deviations in µm over roll length and face width in mm.
    FlankDeviation,
    /// The caller's own length unit, which the file does not name.
    Callers,
}

/// Reads a file of any of the known forms.
pub fn read(path: &Path) -> Result<Vec<NodeSet>, CommandError> {
    of_content(path, &content_of(path, "a fit request or nodes")?)
}

/// The same of a file that has been read.
pub fn of_content(path: &Path, content: &[u8]) -> Result<Vec<NodeSet>, CommandError> {
    let name = name_of(path);
    if is_of_a_tester(&name, content) {
        let refused = |problem: Problem| format!("{}: {}", path.display(), problem.detail).into();
        return from_tester(&name, content).map_err(refused);
    }
    let start = content.strip_prefix(b"\xef\xbb\xbf").unwrap_or(content).trim_ascii_start();
    if start.starts_with(b"{") {
        return from_json(path, start).map(|set| vec![set]);
    }
    from_table(path, content)
}

/// Nodes with the model that suits their type: a second-order surface, a cubic, the columns
/// themselves.
pub fn request_for(nodes: Value) -> Value {
    let model = match nodes.get("type").and_then(Value::as_str) {
        Some("matrix") => json!({"type": "linear"}),
        Some("curve") => json!({"type": "polynomial", "degree": 3, "basis": "legendre"}),
        _ => json!({"type": "polynomial", "degree": [2, 2], "basis": "legendre"}),
    };
    json!({"nodes": nodes, "model": model})
}

/// Returns nodes of a file with the model that suits their type; on a flank that they do not
/// determine so many terms of, with the surface that an import fits, which the report then says.
fn determined_for(nodes: Nodes, own: Option<&OwnZeros>, report: &mut String) -> Result<Value, Problem> {
    let suited = Model::Polynomial { degree: Degree::Both(2), terms: Terms::Tensor, basis: PolynomialBasis::Legendre };
    let mut model = None;
    if matches!(nodes, Nodes::Scattered(_) | Nodes::Grid(_)) {
        let tried = own.is_none_or(|own| own.whole).then_some((suited, ""));
        let is_determined = |(model, _): &(Model, &str)| {
            compute_at(&nodes, &FitSpec::new(model.clone()), &Plans::default(), None, |_| String::new()).is_ok()
        };
        model = tried.into_iter().chain(surfaces(&nodes, own, PolynomialBasis::Legendre)).find(is_determined);
    }
    let nodes = serde_json::from_slice(&nodes_text::to_json(Arc::new(nodes)).whole()).map_err(Problem::internal)?;
    let mut request = request_for(nodes);
    if let Some((model, said)) = model {
        if !said.is_empty() {
            report.push_str(&format!("  The surface of the flank{said}.\n"));
        }
        request["model"] = serde_json::to_value(model).map_err(Problem::internal)?;
    }
    Ok(request)
}

fn name_of(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}

fn from_json(path: &Path, text: &[u8]) -> Result<NodeSet, CommandError> {
    let value: Value =
        serde_json::from_slice(text).map_err(|error| format!("{} is not valid JSON: {error}", path.display()))?;
    let request = if value.get("nodes").is_some() {
        value
    } else if value.get("type").is_some() {
        request_for(value)
    } else {
        let path = path.display();
        return Err(format!(
            "{path} holds neither a fit request (an object with \"nodes\") nor nodes (an object with \"type\")"
        )
        .into());
    };
    Ok(NodeSet { name: name_of(path), request, units: Units::Callers, report: String::new() })
}

/// A table, by the reader of the service; of traces the tooth of each flank with the most nodes.
fn from_table(path: &Path, content: &[u8]) -> Result<Vec<NodeSet>, CommandError> {
    let refused = |problem: Problem| {
        let each: Vec<&str> = problem.errors.iter().map(|error| error.detail.as_str()).collect();
        let faults = if each.is_empty() { problem.detail.clone() } else { each.join("; ") };
        CommandError::from(format!("{}: {faults}", path.display()))
    };
    let table = nodes::table(content, None, "/nodes").map_err(|error| refused(error.into()))?;
    let mut sets = table.node_sets().map_err(|error| refused(nodes::refusal(&error, "/nodes").into()))?;
    let several = sets.len() > 1;
    let mut others = Vec::new();
    if table.texts(Meaning::Trace).is_some() {
        let mut flanks = BTreeSet::new();
        others = sets.extract_if(.., |set| !flanks.insert(set.flank)).collect();
    }
    sets.into_iter().map(|set| from_set(path, &table, set, several, &others).map_err(refused)).collect()
}

/// The nodes of one flank of a table; `others` are those of further teeth.
fn from_set(
    path: &Path,
    table: &Table,
    set: TableNodes,
    several: bool,
    others: &[TableNodes],
) -> Result<NodeSet, Problem> {
    let (count, missing, layout) = (set.count, set.missing, set.layout);
    let mut report = format!("  {count} nodes used, {missing} missing (no height).\n");
    if let Some(crossings) = &set.crossings {
        report.push_str(&at_crossings(crossings));
    }
    if set.own_zeros.is_some() {
        report.push_str("  Each trace is taken to have a zero of its own, which is subtracted.\n");
    }
    let others = others.iter().filter(|other| other.flank == set.flank);
    let others: Vec<&str> = others.filter_map(|other| other.tooth.as_deref()).collect();
    if !others.is_empty() {
        report.push_str(&format!("  Not used: teeth {} of this flank, which have fewer nodes.\n", others.join(", ")));
    }
    let mut name = name_of(path);
    if several {
        let side = set.flank.map_or("flank", |side| if side == Side::Left { "left flank" } else { "right flank" });
        name = format!("{name}, {side} of tooth {}", set.tooth.as_deref().unwrap_or("?"));
    }
    let read = nodes::of_set(table, set, "/nodes")?;
    let request = determined_for(read.nodes, read.own_zeros.as_ref(), &mut report)?;
    let units =
        if layout != Layout::Curve && nodes::is_in_micrometres(table) { Units::FlankDeviation } else { Units::Callers };
    Ok(NodeSet { name, request, units, report })
}

/// How well leads and profiles agree, in the unit of the heights.
fn at_crossings(crossings: &Crossings) -> String {
    let [as_given, turned] = [crossings.as_given, crossings.turned].map(short);
    if crossings.helices_are_turned() {
        format!(
            "  Leads turned to count material as the profiles do: at the crossings they then agree within {turned} rms \
             (as in the file: {as_given}).\n"
        )
    } else {
        format!(
            "  Signs as in the file: at the crossings leads and profiles agree within {as_given} rms (turned: \
             {turned}).\n"
        )
    }
}

/// Whether content or ending say curves, values or a gear model. CSV is taken for nodes: points on
/// a gear need the gear in addition.
fn is_of_a_tester(name: &str, content: &[u8]) -> bool {
    let start = content.strip_prefix(b"\xef\xbb\xbf").unwrap_or(content).trim_ascii_start();
    let ending = name.rsplit_once('.').map(|(_, ending)| ending.to_lowercase());
    start.starts_with(b"<")
        || start.get(..6).is_some_and(|word| word.eq_ignore_ascii_case(b"HEADER"))
        || ending.is_some_and(|ending| ["mka", "mew", "rexs", "xml"].contains(&ending.as_str()))
}

/// Returns the nodes that an import would read, of each flank the tooth with the most nodes.
fn from_tester(name: &str, content: &[u8]) -> Result<Vec<NodeSet>, Problem> {
    let read = read::read(content, Some(name), &ImportSpecBody::default(), None, None)?;
    let mut report = String::new();
    for warning in &read.warnings {
        report.push_str(&format!("  {}: {}\n", warning.code, warning.message));
    }
    let mut sets = Vec::new();
    for side in [Side::Left, Side::Right] {
        let Some(flank) = read.nodes.iter().find(|flank| flank.side == side) else { continue };
        let of = format!("{}, {} flank of tooth {}", name, content::word(side), flank.tooth);
        let count = flank.places.len();
        let mut report = match flank.traces {
            0 => format!("{report}  {count} points of the flank used.\n"),
            traces => format!("{report}  {count} samples of {traces} traces used.\n"),
        };
        let request = determined_for(flank.nodes()?, flank.own_zeros.as_ref(), &mut report)?;
        sets.push(NodeSet { name: of, request, units: Units::FlankDeviation, report });
    }
    if sets.is_empty() {
        // says which flanks there are: none with a known place
        read.flank(&ImportSpecBody::default())?;
    }
    Ok(sets)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(name: &str, text: &str) -> Result<Vec<NodeSet>, CommandError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        read(&path)
    }

    #[test]
    fn unreadable_files_and_cells_are_named() {
        let error = read(Path::new("nowhere.csv")).unwrap_err().to_string();
        assert!(error.contains("nowhere.csv"), "{error}");
        let error = read_text("a.csv", "u,v,z\n1,2,three\n").unwrap_err().to_string();
        assert!(error.contains("line 2, column 3 (z): `three`"), "{error}");
        let text = "flank,tooth_tag,trace,roll_length_mm,z_mm,deviation_um_DIN_sign\nleft,1,lead,seven,0,1\n";
        let error = read_text("a.csv", text).unwrap_err().to_string();
        assert!(error.contains("line 2, column 4 (roll_length_mm): `seven`"), "{error}");
        let error = read_text("a.csv", "roll length,b,c\n1,2,3\n").unwrap_err().to_string();
        assert!(error.contains("none of them has heights"), "{error}");
        let error = read_text("a.json", "{}").unwrap_err().to_string();
        assert!(error.contains("neither a fit request"), "{error}");
    }
}
