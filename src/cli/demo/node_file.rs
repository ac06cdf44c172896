//! `demo --nodes FILE`: whatever a caller has at hand, as fit requests.
//!
//! - JSON: a fit request, or a `nodes` object alone.
//! - CSV with the header `u,v,z[,weight]` or `x,y[,weight]`; an empty height is a missing node.
//! - CSV of gear tester traces, see [`super::traces`].
//! - what `POST …/import` takes: curves of a gear tester (.mka), a REXS model with topographies. Of
//!   each flank the tooth with the most nodes.

use std::{
    fs, io,
    path::{Path, PathBuf},
    sync::Arc,
};

use serde_json::{Value, json};

use super::traces;
use crate::api::{
    fits::{nodes_text, reader::read_csv},
    gears::files::{content, read, spec::ImportSpecBody},
    json::error::ReadError,
    problem::Problem,
};
use flankfit_engine::gear::Side;

/// Nodes to be shown, as the body of a fit request.
#[derive(Debug)]
pub struct NodeSet {
    pub name: String,
    pub request: Value,
    pub units: Units,
    /// What was read and what was left out, for the reader.
    pub report: String,
}

/// What the numbers of a node set mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Units {
    /// Deviations in µm over roll length and face width in mm.
    FlankDeviation,
    /// The caller's own length unit, which the file does not name.
    Callers,
}

/// A file that holds no nodes.
#[derive(Debug, thiserror::Error)]
pub enum NodeFileError {
    #[error("cannot read {}: {source}", path.display())]
    Unreadable {
        path: PathBuf,
        #[source]
        source: io::Error,
    },
    #[error("{} is not valid JSON: {source}", path.display())]
    Json {
        path: PathBuf,
        #[source]
        source: serde_json::Error,
    },
    #[error("{} holds neither a fit request (an object with \"nodes\") nor nodes (an object with \"type\")",
        path.display())]
    NoNodes { path: PathBuf },
    #[error("{}: {source}", path.display())]
    Csv {
        path: PathBuf,
        #[source]
        source: csv::Error,
    },
    #[error("{}: {faults}", path.display())]
    Nodes { path: PathBuf, faults: String },
    #[error("{}, line {line}, column {column}: {reason}", path.display())]
    Field { path: PathBuf, line: u64, column: String, reason: String },
    #[error("{} holds no samples", path.display())]
    Empty { path: PathBuf },
    #[error("{}: {reason}", path.display())]
    Measured { path: PathBuf, reason: String },
    #[error("{} is neither UTF-8 nor a file of a gear tester", path.display())]
    NotText { path: PathBuf },
}

/// Reads a file of any of the known forms.
pub fn read(path: &Path) -> Result<Vec<NodeSet>, NodeFileError> {
    let content = fs::read(path).map_err(|source| NodeFileError::Unreadable { path: path.into(), source })?;
    let name = name_of(path);
    if is_of_a_tester(&name, &content) {
        return from_tester(&name, &content)
            .map_err(|problem| NodeFileError::Measured { path: path.into(), reason: problem.detail });
    }
    let text = std::str::from_utf8(&content).map_err(|_| NodeFileError::NotText { path: path.into() })?;
    let text = text.trim_start_matches('\u{feff}');
    if text.trim_start().starts_with('{') {
        return from_json(path, text).map(|set| vec![set]);
    }
    let header = text.lines().next().unwrap_or_default();
    if header.split(',').any(|column| column.trim() == traces::MARK) {
        return from_traces(path, text);
    }
    from_csv(path, text).map(|set| vec![set])
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

fn name_of(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}

fn from_json(path: &Path, text: &str) -> Result<NodeSet, NodeFileError> {
    let value: Value =
        serde_json::from_str(text).map_err(|source| NodeFileError::Json { path: path.into(), source })?;
    let request = if value.get("nodes").is_some() {
        value
    } else if value.get("type").is_some() {
        request_for(value)
    } else {
        return Err(NodeFileError::NoNodes { path: path.into() });
    };
    Ok(NodeSet { name: name_of(path), request, units: Units::Callers, report: String::new() })
}

fn from_traces(path: &Path, text: &str) -> Result<Vec<NodeSet>, NodeFileError> {
    let flanks = traces::read(text.as_bytes()).map_err(|source| with_column(path, text, source))?;
    if flanks.is_empty() {
        return Err(NodeFileError::Empty { path: path.into() });
    }
    let sets = flanks.into_iter().map(|flank| NodeSet {
        name: format!("{}, {}", name_of(path), flank.name),
        request: request_for(json!({"type": "scattered", "u": flank.u, "v": flank.v, "z": flank.z})),
        units: Units::FlankDeviation,
        report: flank.report,
    });
    Ok(sets.collect())
}

/// Whether content or ending say curves, values or a gear model. CSV is taken for nodes: points on
/// a gear need the gear beside them.
fn is_of_a_tester(name: &str, content: &[u8]) -> bool {
    let start = content.strip_prefix(b"\xef\xbb\xbf").unwrap_or(content).trim_ascii_start();
    let ending = name.rsplit_once('.').map(|(_, ending)| ending.to_lowercase());
    start.starts_with(b"<")
        || start.get(..6).is_some_and(|word| word.eq_ignore_ascii_case(b"HEADER"))
        || ending.is_some_and(|ending| ["mka", "mew", "rexs", "xml"].contains(&ending.as_str()))
}

/// What an import would make of the file, of each flank the tooth with the most nodes.
fn from_tester(name: &str, content: &[u8]) -> Result<Vec<NodeSet>, Problem> {
    let read = read::read(content, Some(name), &ImportSpecBody::default(), None, None)?;
    let mut report = String::new();
    for warning in &read.warnings {
        report.push_str(&format!("  {}: {}\n", warning.code, warning.message));
    }
    let mut sets = Vec::new();
    for side in [Side::Left, Side::Right] {
        let Some(flank) = read.nodes.iter().find(|flank| flank.side == side) else { continue };
        let nodes = serde_json::from_slice(&nodes_text::to_json(Arc::new(flank.nodes()?)).whole())
            .map_err(Problem::internal)?;
        let of = format!("{}, {} flank of tooth {}", name, content::word(side), flank.tooth);
        let count = flank.places.len();
        let report = match flank.traces {
            0 => format!("{report}  {count} points of the flank used.\n"),
            traces => format!("{report}  {count} samples of {traces} traces used.\n"),
        };
        sets.push(NodeSet { name: of, request: request_for(nodes), units: Units::FlankDeviation, report });
    }
    if sets.is_empty() {
        // says which flanks there are: none with a known place
        read.flank(&ImportSpecBody::default())?;
    }
    Ok(sets)
}

/// The reader's error, with the column's name where it knows only its number.
fn with_column(path: &Path, text: &str, source: csv::Error) -> NodeFileError {
    if let csv::ErrorKind::Deserialize { pos: Some(position), err } = source.kind()
        && let Some(column) =
            err.field().and_then(|field| text.lines().next()?.split(',').nth(usize::try_from(field).ok()?))
    {
        return NodeFileError::Field {
            path: path.into(),
            line: position.line(),
            column: column.trim().to_owned(),
            reason: err.kind().to_string(),
        };
    }
    NodeFileError::Csv { path: path.into(), source }
}

/// Plain nodes, by the reader of the service.
fn from_csv(path: &Path, text: &str) -> Result<NodeSet, NodeFileError> {
    let nodes = read_csv(text.as_bytes()).map_err(|error| NodeFileError::Nodes {
        path: path.into(),
        faults: match error {
            ReadError::Malformed { detail } => detail,
            ReadError::Invalid(faults) => {
                faults.list().iter().map(|f| f.detail.as_str()).collect::<Vec<_>>().join("; ")
            }
        },
    })?;
    let lines = text.lines().skip(1).filter(|line| !line.trim().is_empty()).count();
    let (used, missing) = (nodes.posted(), lines.saturating_sub(nodes.posted()));
    let nodes = serde_json::from_slice(&nodes_text::to_json(Arc::new(nodes)).whole())
        .map_err(|source| NodeFileError::Json { path: path.into(), source })?;
    Ok(NodeSet {
        name: name_of(path),
        request: request_for(nodes),
        units: Units::Callers,
        report: format!("  {used} nodes used, {missing} missing (no height).\n"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(name: &str, text: &str) -> Result<Vec<NodeSet>, NodeFileError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        read(&path)
    }

    #[test]
    fn plain_nodes_get_the_model_of_their_type() {
        let sets = read_text("flank.csv", "u,v,z\n1,2,3\n4,5,\n6,7,8.5\n").unwrap();
        assert_eq!(sets[0].request["nodes"]["z"], json!([3.0, 8.5]));
        assert_eq!(sets[0].request["model"]["degree"], json!([2, 2]));
        assert!(sets[0].report.contains("2 nodes used, 1 missing"));
        let sets = read_text("curve.json", r#"{"type":"curve","x":[1],"y":[2]}"#).unwrap();
        assert_eq!(sets[0].request["model"]["degree"], json!(3));
    }

    #[test]
    fn a_request_is_sent_as_it_is() {
        let text = r#"{"nodes":{"type":"curve","x":[1],"y":[2]},"model":{"type":"polynomial","degree":0}}"#;
        let sets = read_text("request.json", text).unwrap();
        assert_eq!(sets[0].request, serde_json::from_str::<Value>(text).unwrap());
    }

    #[test]
    fn what_cannot_be_read_is_named() {
        let error = read(Path::new("nowhere.csv")).unwrap_err().to_string();
        assert!(error.contains("nowhere.csv"), "{error}");
        let error = read_text("a.csv", "u,v,z\n1,2,three\n").unwrap_err().to_string();
        assert!(error.contains("line 2, column 3 (z): `three`"), "{error}");
        let text = "flank,tooth_tag,trace,roll_length_mm,z_mm,deviation_um_DIN_sign\nleft,1,lead,seven,0,1\n";
        let error = read_text("a.csv", text).unwrap_err().to_string();
        assert!(error.contains("line 2, column roll_length_mm: invalid float"), "{error}");
        let error = read_text("a.csv", "a,b\n1,2\n").unwrap_err().to_string();
        assert!(error.contains("the header is `a,b`"), "{error}");
        let error = read_text("a.json", "{}").unwrap_err().to_string();
        assert!(error.contains("neither a fit request"), "{error}");
    }
}
