//! A file of a gear tester as an iteration: nodes of one flank with their second-order surface, and
//! the evaluation of all traces.

use std::{collections::BTreeSet, sync::Arc};

use serde::Serialize;
use serde_with_macros::skip_serializing_none;

use super::{fits, records};
use crate::{
    api::{
        built::Built,
        faults::{Fault, Faults},
        fits::canonical,
        gears::{
            deviations,
            evaluation::{pitch::PitchRequestBody, request::EvaluateBody},
            files::{
                content,
                pitch::FilePitch,
                read::{measured, parsed},
                spec::ImportSpecBody,
            },
            fit_figures::OfFlank,
            gear::of_job,
            requirements::RequirementsBody,
        },
        json::{value::read_json_at, writer},
        problem::Problem,
        tables::{
            mapping::MappingBody,
            nodes::{self, TableNodes},
        },
        warning::WarningBody,
    },
    jobs::{Computed, IterationDraft, Job, Measurand, MeasurementDetails, RecordKind},
};
use flankfit_engine::{
    estimation::{
        FitSpec, Nodes, Plans,
        spec::{Degree, Model, PolynomialBasis, Terms},
    },
    formats::{GearFile, Table, table::HelixSign},
    gear::evaluation::OwnZeros,
    words::counted,
};

/// Moves errors to the file if the request has nothing else.
fn in_file(found: &Faults) -> Problem {
    let mut faults = Faults::default();
    for Fault { pointer, detail, .. } in found.list() {
        faults.push("/file", format!("its {}: {detail}", pointer.trim_start_matches('/').replace('/', " ")));
    }
    Problem::invalid(faults)
}

/// The stored request of a record: the file, and the data taken from it.
#[skip_serializing_none]
#[derive(Clone, Serialize)]
struct Asked<'a> {
    file: &'a str,
    file_sha256: String,
    file_bytes: usize,
    spec: &'a ImportSpecBody,
    mapping: Option<&'a MappingBody>,
    #[serde(flatten)]
    again: Option<Again<'a>>,
}

/// End of the note on traces with separate zeros.
const ZEROS_SET: &str = "; the zeros of its traces are chosen so that they fit one surface";

/// Evaluated data of the file, in the form in which it can be posted again.
#[derive(Clone, Copy, Serialize)]
#[serde(untagged)]
enum Again<'a> {
    Traces(&'a EvaluateBody),
    Pitch(&'a PitchRequestBody),
}

/// Reads, evaluates and fits. Processor work.
pub fn draft(
    content: &[u8],
    name: Option<&str>,
    spec: Option<&[u8]>,
    mapping: Option<&MappingBody>,
    job: &Job,
    plans: &Plans,
) -> Result<IterationDraft, Problem> {
    let spec: ImportSpecBody = match spec {
        Some(text) => read_json_at(text, "/spec")?,
        None => ImportSpecBody::default(),
    };
    let required = RequirementsBody::of(job);
    let file = parsed(content, name, &spec, mapping)?;
    if let GearFile::Table(table) = &file
        && !table.holds_points()
    {
        return of_table(table, name, spec, job, plans);
    }
    let mut read = measured(file, &spec, of_job(job)?.as_ref(), required)?;
    if job.gear.is_none() && spec.gear.is_none() {
        let message = "the job has no gear; the file is evaluated for the gear that it describes. Give the job a \
            `gear` by `PATCH` for figures of fits, limits and corrections";
        let notice = WarningBody::new("gear_missing", message);
        read.warnings.push(notice.clone());
        read.evaluation.iter_mut().for_each(|evaluation| evaluation.warnings.push(notice.clone()));
    }
    let flank = read.flank(&spec)?;
    let nodes = flank.nodes()?;
    let measurand = flank.measurand(&nodes).map_err(|faults| in_file(&faults))?;
    let (computed, told) = surface(&nodes, flank.own_zeros.as_ref(), plans, OfFlank::of(job, &measurand).as_ref())?;
    let name: String = name.unwrap_or("a file").chars().take(100).collect();
    let mut of = format!("{} flank of tooth {}{told}, imported from {name}", content::word(flank.side), flank.tooth);
    if flank.own_zeros.is_some() && flank.traces > 1 {
        of.push_str(ZEROS_SET);
    }
    if !read.warnings.is_empty() {
        let codes: BTreeSet<&str> = read.warnings.iter().map(|warning| warning.code.as_str()).collect();
        let codes: Vec<&str> = codes.into_iter().take(10).collect();
        of.push_str(&format!("; warnings in its records: {}", codes.join(", ")));
    }
    let asked = Asked {
        file: &name,
        file_sha256: canonical::request_sha256(content),
        file_bytes: content.len(),
        spec: &spec,
        mapping,
        again: None,
    };
    let keep = |kind, again: Option<Again<'_>>, built| {
        let request = writer::whole(&Asked { again, ..asked.clone() }).map_err(Problem::not_finite)?;
        records::draft(kind, &request, built)
    };
    let mut records = Vec::new();
    if let Some(evaluation) = &read.evaluation {
        let result = writer::whole(evaluation).map_err(Problem::not_finite)?;
        let built = Built { method: "import".to_owned(), result };
        records.push(keep(RecordKind::Evaluation, read.request.as_ref().map(Again::Traces), built)?);
    }
    if let Some(FilePitch { request, found }) = &read.pitch {
        let result = writer::whole(found).map_err(Problem::not_finite)?;
        let built = Built { method: "import".to_owned(), result };
        records.push(keep(RecordKind::Pitch, Some(Again::Pitch(request)), built)?);
    }
    if let Some(found) = &read.deviations {
        let built = deviations::imported(&read.gear, found, &read.warnings)?;
        records.push(keep(RecordKind::Deviations, None, built)?);
    }
    Ok(IterationDraft { records, ..of_file(nodes, computed, measurand, spec, of) })
}

/// An iteration without records; `of` is its note where the spec has none.
fn of_file(nodes: Nodes, computed: Computed, measurand: Measurand, spec: ImportSpecBody, of: String) -> IterationDraft {
    IterationDraft {
        nodes: Arc::new(nodes),
        computed,
        measurand,
        details: MeasurementDetails {
            note: Some(spec.note.unwrap_or(of)),
            instrument: spec.instrument.map(String::from),
            ..MeasurementDetails::default()
        },
        records: Vec::new(),
        expected_gear: None,
    }
}

/// Nodes of a flank as a table has them: in its own units, on its grid where it is one.
fn of_table(
    table: &Table,
    name: Option<&str>,
    spec: ImportSpecBody,
    job: &Job,
    plans: &Plans,
) -> Result<IterationDraft, Problem> {
    if let Some(gear) = &spec.gear {
        gear.checked("/spec/gear").map_err(Problem::invalid)?;
        let detail = "it belongs to files of curves, models or points; nodes of a table use the job's gear";
        return Err(Problem::invalid(Faults::one("/spec/gear", detail)));
    }
    let side = spec.flank;
    let TableNodes { nodes, missing, helix_sign, own_zeros, measurand } =
        nodes::chosen(table, spec.tooth.as_deref(), side, "/file")?;
    let measurand = measurand.checked(Some(&nodes)).map_err(|faults| in_file(&faults))?;
    let (computed, told) = surface(&nodes, own_zeros.as_ref(), plans, OfFlank::of(job, &measurand).as_ref())?;
    let name: String = name.unwrap_or("a file").chars().take(100).collect();
    let mut of = format!("{}{told}, imported from {name}", counted(nodes.posted(), "node", "nodes"));
    if missing > 0 {
        of.push_str(&format!("; {missing} without a height"));
    }
    match helix_sign {
        Some(HelixSign::Turned) => {
            of.push_str("; its helix traces have the opposite sign of its profiles and are reversed");
        }
        Some(HelixSign::Undetermined) => of.push_str("; the sign of its helix traces is that of the file"),
        Some(HelixSign::AsGiven) | None => {}
    }
    if own_zeros.is_some() {
        of.push_str(ZEROS_SET);
    }
    Ok(of_file(nodes, computed, measurand, spec, of))
}

/// Returns the surface of second order, or the first of [`surfaces`] that the nodes determine, and
/// what is to be said of it.
fn surface(
    nodes: &Nodes,
    own: Option<&OwnZeros>,
    plans: &Plans,
    on: Option<&OfFlank>,
) -> Result<(Computed, &'static str), Problem> {
    let mut refused = None;
    for (model, said) in surfaces(nodes, own, PolynomialBasis::Monomial) {
        // neither nodes nor model are the caller's
        match fits::compute_at(nodes, &FitSpec::new(model), plans, on, |_| "/file".to_owned()) {
            Ok(computed) => return Ok((computed, said)),
            Err(problem) => refused = refused.or(Some(problem)),
        }
    }
    Err(refused.unwrap_or_else(|| Problem::internal("no surface was tried")))
}

/// Returns surfaces to try, those with most terms first: of second order, without the squares
/// across two parallel traces, or a plane; and what is to be said of each. Where traces have a zero
/// each, what lies across parallel ones is not measured, and a plain cross determines no twist.
pub fn surfaces(nodes: &Nodes, own: Option<&OwnZeros>, basis: PolynomialBasis) -> Vec<(Model, &'static str)> {
    let of = |degree, terms| Model::Polynomial { degree, terms, basis };
    let whole = (of(Degree::Both(2), Terms::Total), "");
    let plane = (of(Degree::Both(1), Terms::Total), " (a plane: its nodes do not determine a twist)");
    let along = |degree| {
        const ALONG: &str =
            " (along its parallel traces only: each has its own zero, so nothing across them is measured)";
        (of(degree, Terms::Tensor), ALONG)
    };
    const TWO: &str = " (without the square across its two parallel traces)";
    match own {
        _ if matches!(nodes, Nodes::Curve(_)) => vec![whole],
        None => vec![
            whole,
            (of(Degree::Each(2, 1), Terms::Tensor), TWO),
            (of(Degree::Each(1, 2), Terms::Tensor), TWO),
            plane,
        ],
        Some(OwnZeros { whole: true, .. }) => vec![whole, plane],
        Some(OwnZeros { along: [true, false], .. }) => vec![along(Degree::Each(2, 0)), along(Degree::Each(1, 0))],
        Some(OwnZeros { along: [false, true], .. }) => vec![along(Degree::Each(0, 2)), along(Degree::Each(0, 1))],
        Some(_) => vec![plane],
    }
}
