//! `flankfit evaluate FILE`: a file of a gear tester as a table, without a server.

use std::{fmt::Write as _, io::Write as _, path::PathBuf};

use clap::Args;
use serde::Deserialize;
use utoipa::ToSchema;

use crate::{
    api::{
        gears::{
            deviations,
            evaluation::{answer::EvaluationBody, request::EvaluationSettingsBody},
            files::{
                content::FileRead,
                gears::{self, GearsOfFileBody},
                read::read,
                spec::ImportSpecBody,
            },
            gear::GearBody,
        },
        json::value::read_json,
        problem::Problem,
    },
    cli::{CommandError, called, content_of, out::out, progress, table::Table, wrong_in},
    jobs::side_name,
};
use flankfit_engine::{
    formats::{GearFile, gear_file, klingelnberg::ResultValue},
    gear::{
        Gear, Kind,
        evaluation::{Evaluated, flank_surface::Figure},
    },
    words::Shown,
};

#[derive(Debug, Args)]
pub struct EvaluateArguments {
    /// File with curves (.mka) or values (.mew) of a gear tester, a table of points (with --gear)
    /// or a REXS model; `-` reads standard input.
    file: PathBuf,
    /// The gear as JSON; replaces the gear data of the file.
    #[arg(long, value_name = "FILE")]
    gear: Option<PathBuf>,
    /// Evaluation settings as JSON, as `evaluation` of `POST /v1/gears/evaluate`; default ranges
    /// are those of the file.
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
    /// Id of the gear in a REXS model whose topographies are evaluated; without it the gears are
    /// listed.
    #[arg(long, value_name = "ID")]
    component: Option<String>,
    /// Print the JSON answer of `POST /v1/gears/evaluate` (for points and topographies, of `POST
    /// /v1/gears/deviations`) instead of a table.
    #[arg(long)]
    json: bool,
}

/// Prints the table to standard output and errors to standard error.
pub fn run(arguments: &EvaluateArguments) -> Result<(), CommandError> {
    let text = progress::shown("evaluate", || text(arguments))?;
    Ok(out().write_all(text.as_bytes())?)
}

/// Reads settings from their own file.
fn settings<T: for<'a> Deserialize<'a> + ToSchema>(
    file: Option<&PathBuf>,
    what: &str,
) -> Result<Option<T>, CommandError> {
    let Some(file) = file else { return Ok(None) };
    let read = read_json(&content_of(file, what)?);
    Ok(Some(read.map_err(|error| wrong_in(file, &error.into()))?))
}

fn text(arguments: &EvaluateArguments) -> Result<String, CommandError> {
    let in_words = |problem: Problem| wrong_in(&arguments.file, &problem);
    let content = content_of(&arguments.file, "curves, values or points of a gear tester, or a REXS model")?;
    let name = arguments.file.file_name().map(|name| name.to_string_lossy().into_owned());
    let parsed = gear_file::read(&content, name.as_deref(), None);
    if let (Ok(GearFile::Model(_)), None) = (&parsed, &arguments.component) {
        return gears(&gears::read(&content, name.as_deref()).map_err(in_words)?, arguments.json);
    }
    if let Ok(GearFile::Values(values)) = parsed {
        let mut table = Table::new(["code", "result", "value"], 2);
        for result in &values.results {
            let reading = match result.reading {
                ResultValue::Value(value) => value.to_string(),
                ResultValue::NotMeasured => "not measured".to_owned(),
                ResultValue::NotAvailable => "not available".to_owned(),
            };
            table.row([result.code.to_string(), result.name.clone(), reading]);
        }
        return Ok(table.to_string());
    }
    let gear = settings::<GearBody>(arguments.gear.as_ref(), "a gear as JSON")?;
    let evaluation = settings::<EvaluationSettingsBody>(arguments.settings.as_ref(), "evaluation settings as JSON")?;
    let component = arguments.component.clone();
    let spec = ImportSpecBody { gear, evaluation, component, ..ImportSpecBody::default() };
    let read = read(&content, name.as_deref(), &spec, None, None).map_err(in_words)?;
    for warning in &read.warnings {
        eprintln!("{}: {}", warning.code, warning.message);
    }
    if let Some(found) = &read.deviations {
        if arguments.json {
            let built = deviations::imported(&read.gear, found, &read.warnings).map_err(in_words)?;
            return Ok(String::from_utf8(built.result)? + "\n");
        }
        return Ok(flanks(&read)?);
    }
    let Some(found) = &read.evaluation else {
        let file = called(&arguments.file);
        return Err(format!("{file}: there is no trace to evaluate, or no range to evaluate it on (see above)").into());
    };
    if arguments.json {
        return Ok(serde_json::to_string_pretty(found)? + "\n");
    }
    Ok(tables(&read, found)?)
}

/// The gears of a file.
fn gears(found: &GearsOfFileBody, json: bool) -> Result<String, CommandError> {
    if json {
        return Ok(serde_json::to_string_pretty(found)? + "\n");
    }
    for warning in &found.warnings {
        eprintln!("{}: {}", warning.code, warning.message);
    }
    let mut table = Table::new(["id", "name", "z", "m_n", "α_n", "β", "x", "topographies", "missing"], 2);
    for of in &found.gears {
        let text = |value: Option<String>| value.unwrap_or_else(|| "–".to_owned());
        let gear = of.gear.as_ref();
        let number = |value: Option<f64>| text(value.map(|value| Shown(value).to_string()));
        table.row([
            text(of.id.clone()),
            text(of.name.clone()),
            text(gear.map(|gear| gear.teeth.to_string())),
            number(gear.map(|gear| gear.normal_module_mm)),
            number(gear.and_then(|gear| gear.normal_pressure_angle_deg)),
            number(gear.and_then(|gear| gear.helix_angle_deg)),
            number(gear.and_then(|gear| gear.profile_shift_coefficient)),
            of.topographies.iter().map(|side| side_name(*side)).collect::<Vec<_>>().join(" "),
            of.missing.join(" "),
        ]);
    }
    Ok(table.to_string())
}

/// With one decimal, and no sign where that leaves 0.
fn tenths(x: f64) -> String {
    format!("{:.1}", (10.0 * x).round() / 10.0 + 0.0)
}

fn of_gear(gear: &Gear) -> String {
    let data = gear.data();
    format!(
        "z = {}, m_n = {} mm, β = {:.4}°, d_b = {:.4} mm\n",
        data.teeth,
        data.normal_module,
        data.helix_angle.to_degrees(),
        2.0 * gear.base_radius()
    )
}

/// Deviations flank by flank.
fn flanks(read: &FileRead) -> Result<String, std::fmt::Error> {
    let mut out = of_gear(&read.gear);
    writeln!(out, "\nDeviations along the normal, µm")?;
    let mut table = Table::new(["tooth", "flank", "nodes", "mean", "rms", "least", "greatest"], 2);
    for flank in &read.nodes {
        let deviations = || flank.places.iter().map(|place| place[2]);
        let count = flank.places.len() as f64;
        let number = |x: f64| format!("{x:.2}");
        table.row([
            flank.tooth.clone(),
            side_name(flank.side).to_owned(),
            flank.places.len().to_string(),
            number(deviations().sum::<f64>() / count),
            number((deviations().map(|d| d * d).sum::<f64>() / count).sqrt()),
            number(deviations().fold(f64::INFINITY, f64::min)),
            number(deviations().fold(f64::NEG_INFINITY, f64::max)),
        ]);
    }
    write!(out, "{table}")?;
    Ok(out)
}

fn tables(read: &FileRead, found: &EvaluationBody) -> Result<String, std::fmt::Error> {
    let mut out = of_gear(&read.gear);
    trace_table(&mut out, found, Kind::Profile, "Profiles", ["f_Hα", "f_fα", "F_α", "C_α"])?;
    trace_table(&mut out, found, Kind::Helix, "Helices", ["f_Hβ", "f_fβ", "F_β", "C_β"])?;
    surface_table(&mut out, found)?;
    twists(&mut out, found)?;
    Ok(out)
}

/// The traces of a kind, and their means.
fn trace_table(
    out: &mut String,
    found: &EvaluationBody,
    kind: Kind,
    title: &str,
    [slope, form, total, crowning]: [&str; 4],
) -> std::fmt::Result {
    let traces: Vec<&Evaluated> = found.traces.iter().filter(|trace| trace.kind == kind).collect();
    if traces.is_empty() {
        return Ok(());
    }
    writeln!(out, "\n{title}, µm")?;
    let mut table = Table::new(["tooth", "flank", slope, form, total, crowning, "class"], 2);
    for trace in traces {
        let number = |x: Option<f64>| x.map_or_else(|| "–".to_owned(), tenths);
        let class = trace.classes.as_ref().map_or_else(
            || "–".to_owned(),
            |class| {
                let worst = [class.slope, class.form, class.total].into_iter().flatten().max();
                if class.coarser_than_11.is_empty() {
                    worst.map_or_else(String::new, |c| c.to_string())
                } else {
                    "> 11".to_owned()
                }
            },
        );
        table.row([
            trace.tooth.clone(),
            side_name(trace.flank).to_owned(),
            number(trace.values.map(|values| values.slope_um)),
            number(trace.values.map(|values| values.form_um)),
            number(trace.values.map(|values| values.total_um)),
            number(trace.values.map(|values| values.crowning_um)),
            class,
        ]);
    }
    write!(out, "{table}")?;
    for mean in found.summaries.iter().filter(|mean| mean.kind == kind) {
        let flank = side_name(mean.flank);
        writeln!(
            out,
            "  {flank}, mean of {}: {slope} {:.1} (variation {:.1}), {form} {:.1}, {total} {:.1}",
            mean.count, mean.slope_um.mean, mean.slope_um.variation, mean.form_um.mean, mean.total_um.mean
        )?;
    }
    Ok(())
}

fn surface_table(out: &mut String, found: &EvaluationBody) -> std::fmt::Result {
    if found.surfaces.is_empty() {
        return Ok(());
    }
    writeln!(out, "\nSecond-order surfaces through all traces of a flank, µm over the evaluation ranges")?;
    let mut table =
        Table::new(["tooth", "flank", "traces", "f_Hα", "f_Hβ", "C_α", "C_β", "twist", "left over (rms)"], 2);
    for surface in &found.surfaces {
        let figure = |figure: &Option<Figure>| match figure {
            Some(Figure { value, std_error: Some(error), .. }) => {
                format!("{} ± {}", tenths(*value), tenths(*error))
            }
            Some(figure) => tenths(figure.value),
            None => "–".to_owned(),
        };
        let of = &surface.figures;
        table.row([
            surface.tooth.clone(),
            side_name(surface.flank).to_owned(),
            surface.traces.to_string(),
            figure(&of.profile_slope),
            figure(&of.helix_slope),
            figure(&of.profile_crowning),
            figure(&of.helix_crowning),
            figure(&of.twist),
            format!("{:.2}", surface.rms_um),
        ]);
    }
    writeln!(out, "{table}")
}

fn twists(out: &mut String, found: &EvaluationBody) -> std::fmt::Result {
    for twist in &found.twists {
        let by = if twist.kind == Kind::Helix { "helices" } else { "profiles" };
        let between = twist.sections_mm.map_or_else(String::new, |[a, b]| {
            let unit = if twist.kind == Kind::Helix { "d" } else { "z" };
            format!(" between {unit} {} and {} mm", Shown(a), Shown(b))
        });
        let flank = side_name(twist.flank);
        writeln!(out, "  twist of tooth {}, {flank} flank, by {by}{between}: {:.1} µm", twist.tooth, twist.twist_um)?;
    }
    Ok(())
}
