//! The bundled gear, from the first measurement to acceptance, printed as one screen.
//!
//! Both flanks are measured, evaluated and corrected; the changes entered on the machine are
//! recorded, and a second measurement shows how the machine responded.

use std::io::Write;

use serde_json::{Value, json};

use super::{
    NodeSet,
    client::Client,
    node_file::Units,
    numbers::{as_certain_as, significant},
    story::{Story, chosen},
};
use crate::{
    api::jobs::{iterations::NewIterationBody, job::JobBody},
    cli::{CommandError, table::Table},
};
use flankfit_engine::{estimation::result::Cause, gear::evaluation::flank_surface::Figure};

const JOB: &str = include_str!("../../../examples/requests/job.json");
const REQUIREMENTS: &str = include_str!("../../../examples/requests/job_requirements.json");
const EVALUATION: &str = include_str!("../../../examples/requests/iteration_evaluation.json");
const PITCH: &str = include_str!("../../../examples/requests/iteration_pitch.json");

/// Flanks after the first and after the second grinding; `examples/flank_z52.md` describes how the
/// files were generated.
const FIRST: [&str; 2] =
    [include_str!("../../../examples/flank_z52.json"), include_str!("../../../examples/flank_z52_right.json")];
const SECOND: [&str; 2] = [
    include_str!("../../../examples/flank_z52_remachined.json"),
    include_str!("../../../examples/flank_z52_right_remachined.json"),
];

/// Runs the job and prints one screen or, with `verbose`, every table of every fit. Returns the
/// path of the job.
pub fn run(client: &Client, out: &mut impl Write, verbose: bool) -> Result<String, CommandError> {
    let mut job: Value = serde_json::from_str(JOB)?;
    let mut requirements: Value = serde_json::from_str(REQUIREMENTS)?;
    job["requirements"] = requirements["requirements"].take();
    let created: JobBody = client.post("/v1/jobs", &job)?;
    let path = format!("/v1/jobs/{}", created.id);
    writeln!(out, "Open {} in a browser.\n", client.url(path.trim_start_matches("/v1")))?;

    let before = measure(client, &path, FIRST, "first measurement", out, verbose)?;
    let _: Value = client.post(&format!("{path}/iterations/1/evaluations"), &serde_json::from_str(EVALUATION)?)?;
    let _: Value = client.post(&format!("{path}/iterations/1/pitch"), &serde_json::from_str(PITCH)?)?;
    decide(client, &path, &before)?;

    let asked = json!({"sensitivity": {"type": "machine", "machine": "form_grinding"},
        "limits": {"profile_angle": {"increment": 0.05}, "helix_angle": {"increment": 0.01},
            "profile_crowning": {"increment": 0.1}, "helix_crowning": {"increment": 0.1}}});
    let correction = format!("{path}/iterations/1/correction");
    let proposed: Value = client.post(&correction, &asked)?;
    let changes = changed(&proposed);
    let entered: Value = changes.iter().map(|(name, change, _)| ((*name).to_owned(), json!(change))).collect();
    let note = "entered at the control of form grinder 3";
    let _: Value = client.post(&format!("{correction}/applied"), &json!({"settings": entered, "note": note}))?;

    let after = measure(client, &path, SECOND, "after the correction", out, verbose)?;
    decide(client, &path, &after)?;
    let answered: Value = client.get(&correction)?;

    if verbose {
        Story { client, out: &mut *out }.trace(&path)?;
        writeln!(out)?;
    }
    writeln!(out, "{} ({}), class 6 of ISO 1328-1", created.name, created.part_number.as_deref().unwrap_or_default())?;
    write!(out, "{}", results(&before, &after))?;
    writeln!(out, "\nChanges of the machine")?;
    for (name, change, unit) in &changes {
        writeln!(out, "  {:<18}{}{}", words(name), significant(*change, 3), symbol(unit))?;
    }
    for (reason, text) in
        [("within_limits", "left alone, within the limits"), ("not_distinguishable", "left alone, no change found")]
    {
        let names = settings(&proposed).filter(|setting| setting["unchanged"] == reason);
        list(out, text, names)?;
    }
    writeln!(out, "\nNot determined by the nodes")?;
    list(out, "no common zero", settings(&proposed).filter(|setting| setting["undetermined"] == true))?;
    for iteration in &before {
        let result = chosen(iteration)?.result.value()?;
        let dependencies = result.collinearity.near_dependencies.iter();
        for dependency in dependencies.filter(|dependency| dependency.cause == Cause::Nodes) {
            writeln!(out, "  {}", dependency.sentence)?;
        }
    }
    let sentence = answered["answer"]["sentence"].as_str().unwrap_or_default();
    writeln!(out, "\nSecond measurement\n  {}", sentence.replace(", ", ",\n  "))?;
    Ok(path)
}

/// Measures both flanks.
fn measure(
    client: &Client,
    job: &str,
    flanks: [&str; 2],
    note: &str,
    out: &mut impl Write,
    verbose: bool,
) -> Result<Vec<NewIterationBody>, CommandError> {
    let mut measured = Vec::new();
    for flank in flanks {
        let mut request: Value = serde_json::from_str(flank)?;
        request["instrument"] = "gear tester".into();
        request["note"] = note.into();
        let iteration: NewIterationBody = client.post(&format!("{job}/iterations"), &request)?;
        if verbose {
            let set = NodeSet { name: note.into(), request, units: Units::FlankDeviation, report: String::new() };
            Story { client, out: &mut *out }.print_iteration(job, &iteration, &set)?;
        }
        measured.push(iteration);
    }
    Ok(measured)
}

/// Accepts the flanks whose figures all lie within their limits, and decides to remachine the
/// others.
fn decide(client: &Client, job: &str, measured: &[NewIterationBody]) -> Result<(), CommandError> {
    for iteration in measured {
        let outside: Vec<String> = figures_of(iteration)
            .into_iter()
            .filter(|(_, figure)| figure.within == Some(false))
            .map(|(symbol, figure)| format!("{symbol} {} µm is outside {}", value(&figure), limits(&figure)))
            .collect();
        let (decision, reason) = match outside.is_empty() {
            true => ("accepted", "slopes, crownings and twist are within their limits".to_owned()),
            false => ("remachine", outside.join(", ")),
        };
        let body = json!({"decision": decision, "reason": reason});
        let _: Value = client.patch(&format!("{job}/iterations/{}", iteration.posted.measured.number), &body)?;
    }
    Ok(())
}

fn results(before: &[NewIterationBody], after: &[NewIterationBody]) -> Table {
    let mut table = Table::new(["µm, along the normal", "left", "right", "limits", "then left", "right"], 1);
    let columns: Vec<_> = before.iter().chain(after).map(figures_of).collect();
    for (i, (symbol, first)) in columns[0].iter().enumerate() {
        let cell = |column: usize| {
            columns
                .get(column)
                .and_then(|figures| figures.get(i))
                .map_or_else(String::new, |(_, figure)| marked(figure))
        };
        table.row([(*symbol).to_owned(), cell(0), cell(1), limits(first), cell(2), cell(3)]);
    }
    table
}

/// Returns figures with their symbols, in the order of a gear inspection sheet.
fn figures_of(iteration: &NewIterationBody) -> Vec<(&'static str, Figure)> {
    const NAMES: [&str; 5] =
        ["f_Hα  profile slope", "f_Hβ  helix slope", "C_α   profile crowning", "C_β   helix crowning", "S     twist"];
    let figures = iteration.fits.first().and_then(|fit| fit.figures.as_ref()?.value().ok());
    let Some(figures) = figures else { return Vec::new() };
    let named = NAMES.into_iter().zip(figures.figures.named());
    named.filter_map(|(name, (_, figure))| Some((name, figure?))).collect()
}

fn value(figure: &Figure) -> String {
    as_certain_as(figure.value, figure.std_error)
}

/// Formats the value with its standard error and ✓ or ✗.
fn marked(figure: &Figure) -> String {
    let mark = figure.within.map_or("", |within| if within { " ✓" } else { " ✗" });
    let error = figure.std_error.map_or_else(String::new, |error| format!(" ± {}", significant(error, 2)));
    format!("{}{error}{mark}", value(figure))
}

fn limits(figure: &Figure) -> String {
    let short = |end: f64| significant(end, 3);
    figure.conformity.map_or_else(String::new, |found| match found.limits {
        [low, high] if low == -high => format!("±{}", short(high)),
        [low, high] => format!("{} … {}", short(low), short(high)),
    })
}

fn settings(correction: &Value) -> impl Iterator<Item = &Value> {
    correction["result"]["settings"].as_array().into_iter().flatten()
}

/// Returns the settings that are changed: name, change, unit.
fn changed(correction: &Value) -> Vec<(&str, f64, &str)> {
    fn of(setting: &Value) -> Option<(&str, f64, &str)> {
        Some((setting["name"].as_str()?, setting["change"].as_f64()?, setting["unit"].as_str()?))
    }
    settings(correction).filter_map(of).filter(|(_, change, _)| *change != 0.0).collect()
}

fn symbol(unit: &str) -> String {
    match unit {
        "arcmin" => "′".into(),
        "um" => " µm".into(),
        other => format!(" {other}"),
    }
}

fn words(setting: &str) -> String {
    setting.replace('_', " ")
}

fn list<'a>(out: &mut impl Write, text: &str, settings: impl Iterator<Item = &'a Value>) -> Result<(), CommandError> {
    let names: Vec<String> = settings.filter_map(|setting| setting["name"].as_str()).map(words).collect();
    if !names.is_empty() {
        writeln!(out, "  {text}: {}", names.join(", "))?;
    }
    Ok(())
}
