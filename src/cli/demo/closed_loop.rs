//! `flankfit demo --closed-loop`: a machine whose settings cannot be separated, corrected with and
//! without λ*.

use std::io::Write;

use flankfit_engine::numerics::cancel::parts;
use serde::Deserialize;
use serde_json::json;

use super::client::Client;
use crate::cli::{CommandError, progress, table::Table};

/// Machines that are simulated in addition to the one that is stored.
const SEEDS: u64 = 100;
/// RMS of a good flank, µm.
const GOOD: f64 = 0.5;
/// Re-machinings.
const CORRECTIONS: usize = 2;

#[derive(Deserialize)]
struct Loop {
    condition: f64,
    runs: Vec<Run>,
}

#[derive(Deserialize)]
struct Run {
    strategy: String,
    job_id: Option<String>,
    rounds: Vec<Round>,
}

#[derive(Deserialize)]
struct Round {
    iteration: u32,
    rms_measured_um: f64,
    rms_true_um: f64,
    rms_predicted_um: Option<f64>,
}

#[derive(Deserialize)]
struct StoredCorrection {
    answer: Option<Answer>,
}

#[derive(Deserialize)]
struct Answer {
    sentence: String,
}

/// Prints the results of a closed loop, and returns the paths of the stored jobs.
pub fn run(client: &Client, out: &mut impl Write) -> Result<Vec<String>, CommandError> {
    let ask = |seed: u64, store: bool| -> Result<Loop, CommandError> {
        let body = json!({"seed": seed, "store": store, "corrections": CORRECTIONS});
        client.post("/v1/simulations/closed-loop", &body)
    };
    let first = ask(1, true)?;
    writeln!(
        out,
        "\n5 × 9 nodes, six settings of which the sixth is nearly a combination of two others (condition of JᵀJ \
         {:.1e});\nthe response of the machine is 1 % off, the probe is 0.3 µm off and misses every tenth node.",
        first.condition
    )?;
    let mut jobs = Vec::new();
    for run in &first.runs {
        let what = match run.strategy.as_str() {
            "least_squares" => "Plain least squares",
            _ => "Spectral λ*, by the noise and the uncertainty of the sensitivity (the default of corrections)",
        };
        writeln!(out, "\n{what}")?;
        let mut table = Table::new(["iteration", "measured RMS µm", "without noise", "predicted of the next"], 0);
        for round in &run.rounds {
            let predicted = round.rms_predicted_um.map_or_else(String::new, |rms| format!("{rms:.3}"));
            table.row([
                round.iteration.to_string(),
                format!("{:.3}", round.rms_measured_um),
                format!("{:.3}", round.rms_true_um),
                predicted,
            ]);
        }
        write!(out, "{table}")?;
        let Some(job) = run.job_id.as_ref().map(|id| format!("/v1/jobs/{id}")) else { continue };
        for number in 1..=CORRECTIONS {
            let kept: StoredCorrection = client.get(&format!("{job}/iterations/{number}/correction"))?;
            if let Some(answer) = kept.answer {
                writeln!(out, "  correction {number}: {}", answer.sentence)?;
            }
        }
        jobs.push(job);
    }
    let mut good = vec![0; first.runs.len()];
    progress::shown("closed loops", || -> Result<(), CommandError> {
        let each = parts(SEEDS as usize);
        for seed in 0..SEEDS {
            for (good, run) in good.iter_mut().zip(each.run(1, || ask(seed, false))?.runs) {
                *good += usize::from(run.rounds.last().is_some_and(|round| round.rms_true_um < GOOD));
            }
        }
        Ok(())
    })?;
    writeln!(out, "\nOf {SEEDS} such machines, below {GOOD} µm RMS after {CORRECTIONS} re-machinings:")?;
    let mut table = Table::new(["way to correct", "machines"], 1);
    for (run, good) in first.runs.iter().zip(good) {
        table.row([run.strategy.clone(), good.to_string()]);
    }
    write!(out, "{table}")?;
    Ok(jobs)
}
