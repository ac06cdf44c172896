//! A closed loop simulated: measure, correct, machine again, with hidden errors of the machine and
//! noise of the probe.

use std::sync::Arc;

use super::{
    request::ClosedLoopBody,
    result::{ClosedLoopRoundBody, ClosedLoopRunBody},
};
use crate::{
    api::{
        built::Built,
        faults::{Faults, is_within, moved, pointer_of},
        fits::canonical,
        gears::correction::{result::CorrectionResultBody, target::AimName},
        jobs::{fits, records},
        json::value::read_json,
        problem::Problem,
    },
    jobs::{IterationDraft, JobDraft, Measurand, MeasurementDetails, RecordDraft, RecordKind},
};
use flankfit_engine::{
    estimation::{
        FitSpec, Nodes, Plans,
        spec::{Degree, Model, PolynomialBasis, Regularization, Scaling, Terms},
    },
    gear::{
        correction as gear_correction,
        correction::{Correction, DEFAULT_RESPONSE_UNCERTAINTY, Damping},
        simulation::{MachineSpec, Simulation, Strategy, closed_loop},
    },
    numerics::{cancel, check},
};

/// A run, and the job that stores it where that was requested.
pub struct SimulatedRun {
    pub run: ClosedLoopRunBody,
    pub draft: Option<RunDraft>,
}

/// The job of a run.
pub struct RunDraft {
    pub job: JobDraft,
    /// For each round the iteration, with the correction that followed.
    pub rounds: Vec<IterationDraft>,
}

/// Every run of a request. Processor work.
pub struct Simulated {
    pub seed: u64,
    pub condition: Option<f64>,
    pub runs: Vec<SimulatedRun>,
}

/// Simulates. Processor work.
pub fn simulate(text: &[u8], plans: &Plans) -> Result<Simulated, Problem> {
    let body: ClosedLoopBody = read_json(text)?;
    let (machine, grid) = body.machine().map_err(Problem::invalid)?;
    let strategies = body.strategies().map_err(Problem::invalid)?;
    let store = body.store.unwrap_or(false);
    if store && grid.iter().any(|&nodes| nodes < 3) {
        let detail = "each measurement is stored with its second-order surface, which needs 3 × 3 nodes";
        return Err(Problem::invalid(Faults::one("/grid", detail)));
    }
    let corrections = body.corrections.unwrap_or(2);
    let uncertainty = body.response_uncertainty.unwrap_or(DEFAULT_RESPONSE_UNCERTAINTY);
    let drawn = Simulation::new(machine.clone()).map_err(Problem::invalid)?;
    let condition = cancel::uncounted(|| condition(&machine))?;
    let all = cancel::parts(strategies.len());
    let run = |strategy| simulate_run(drawn.clone(), grid, strategy, uncertainty, corrections, store, plans);
    let runs = strategies
        .iter()
        .map(|strategy| all.run(1, || run(strategy)))
        .collect::<Result<Vec<SimulatedRun>, Problem>>()?;
    Ok(Simulated { seed: machine.seed, condition, runs })
}

/// Condition of JᵀJ; `None` where settings depend on each other exactly.
fn condition(machine: &MachineSpec) -> Result<Option<f64>, Problem> {
    let columns = machine.settings.len();
    let rows = machine.sensitivity.len() / columns.max(1);
    let spec = gear_correction::CorrectionSpec {
        scaling: Scaling::None,
        damping: Damping::Given(Regularization::None),
        ..gear_correction::CorrectionSpec::new(vec![0.0; rows], machine.sensitivity.clone(), machine.settings.clone())
    };
    let all = Correction::new(spec).map_err(|found| Problem::invalid(placed(&found, 0)))?;
    let solution = all.solve().map_err(|error| Problem::of_fit(error, |_| "/matrix".to_owned()))?;
    Ok(solution.fit.spectrum.condition)
}

/// Returns the map from paths of a failed run to places in the request; `number` is how often the
/// machine was corrected.
fn place(number: usize) -> impl Fn(&str) -> String {
    move |path| match path {
        _ if is_within(path, &["regularization"]) => "/strategies".to_owned(),
        // all nodes together determine the settings, as `condition` shows
        _ if is_within(path, &["model"]) => "/missing".to_owned(),
        // numbers within their limits are out of range only when settings have run away
        _ if number > 0 => "/corrections".to_owned(),
        _ => pointer_of(path),
    }
}

/// Converts a correction's errors to places in the request, where matrix and settings have no
/// object of their own; `number` is how often the machine was corrected.
fn placed(found: &check::Faults, number: usize) -> Faults {
    Faults::placed(found, |path| match number {
        0 => moved(path, &[("sensitivity", "")]),
        _ => "/corrections".to_owned(),
    })
}

fn simulate_run(
    mut simulation: Simulation,
    [rows, columns]: [usize; 2],
    strategy: &Strategy,
    uncertainty: f64,
    corrections: usize,
    store: bool,
    plans: &Plans,
) -> Result<SimulatedRun, Problem> {
    let machine = simulation.spec().clone();
    let mut rounds = Vec::with_capacity(corrections + 1);
    let mut draft = Vec::with_capacity(corrections + 1);
    let told = cancel::parts(corrections + 1);
    for number in 0..=corrections {
        let measured = simulation.measure();
        let true_rms = simulation.true_rms();
        let nodes = grid(rows, columns, &measured)
            .map_err(|found| Problem::invalid(Faults::placed(&found.within("nodes"), place(number))))?;
        let mut round = ClosedLoopRoundBody {
            iteration: u32::try_from(number + 1).unwrap_or(u32::MAX),
            rms_measured_um: rms(&measured),
            rms_true_um: true_rms,
            rms_predicted_um: None,
            changes: None,
        };
        let mut record = None;
        if number < corrections {
            let spec = closed_loop::correction_spec(&simulation, measured, strategy, uncertainty);
            let request = request(&machine, uncertainty, strategy);
            let refused = |error| Problem::of_fit(error, place(number));
            let correction = Correction::new(spec).map_err(|found| Problem::invalid(placed(&found, number)))?;
            let solution = correction.solve().map_err(refused)?;
            let changes: Vec<f64> = solution.settings.iter().map(|setting| setting.change).collect();
            simulation.apply(&changes).map_err(Problem::invalid)?;
            round.rms_predicted_um = Some(solution.predicted.rms_um);
            round.changes = Some(changes);
            if store {
                let (aim, digest) = ((AimName::Nominal, None), canonical::request_sha256(&request));
                let body = CorrectionResultBody::new(&correction, &solution, aim, Vec::new(), &digest);
                let built = Built { method: "matrix".to_owned(), result: body.map_err(Problem::not_finite)?.text()? };
                record = Some(records::draft(RecordKind::Correction, &request, built)?);
            }
        }
        if store {
            draft.push(iteration(nodes, strategy, number, record, plans)?);
        }
        rounds.push(round);
        told.run(1, || ());
    }
    let run = ClosedLoopRunBody { strategy: strategy.name.clone(), job_id: None, rounds };
    let job = JobDraft {
        name: format!("Closed loop, seed {}, {}", machine.seed, strategy.name),
        machine: Some("simulated".to_owned()),
        ..JobDraft::default()
    };
    Ok(SimulatedRun { run, draft: store.then_some(RunDraft { job, rounds: draft }) })
}

/// Root mean square of the nodes that were measured.
fn rms(measured: &[f64]) -> f64 {
    let (sum, count) =
        measured.iter().filter(|d| !d.is_nan()).fold((0.0, 0.0), |(sum, count), d| (sum + d * d, count + 1.0));
    f64::sqrt(sum / f64::max(count, 1.0))
}

/// Deviations over [-1, 1] × [-1, 1].
fn grid(rows: usize, columns: usize, measured: &[f64]) -> Result<Nodes, check::Faults> {
    let axis = |n: usize| (0..n).map(|i| 2.0 * i as f64 / (n - 1) as f64 - 1.0).collect::<Vec<f64>>();
    Nodes::grid(axis(rows), axis(columns), measured.to_vec(), None, None)
}

/// A measurement with its second-order surface and the correction that followed.
fn iteration(
    nodes: Nodes,
    strategy: &Strategy,
    number: usize,
    record: Option<RecordDraft>,
    plans: &Plans,
) -> Result<IterationDraft, Problem> {
    let spec = FitSpec::new(Model::Polynomial {
        degree: Degree::Both(2),
        terms: Terms::Total,
        basis: PolynomialBasis::Monomial,
    });
    let computed = fits::compute_at(&nodes, &spec, plans, None, place(number))?;
    let note = match number {
        0 => "simulated; the machine as it was".to_owned(),
        n => format!("simulated; after correction {n} by {}", strategy.name),
    };
    Ok(IterationDraft {
        nodes: Arc::new(nodes),
        computed,
        measurand: Measurand::default(),
        details: MeasurementDetails {
            instrument: Some("simulated probe".to_owned()),
            note: Some(note),
            ..MeasurementDetails::default()
        },
        records: record.into_iter().collect(),
        expected_gear: None,
    })
}

/// The request that a client would have posted for this correction.
fn request(machine: &MachineSpec, uncertainty: f64, strategy: &Strategy) -> Vec<u8> {
    let columns = machine.settings.len();
    let names: Vec<&str> = machine.settings.iter().map(|setting| setting.name.as_str()).collect();
    let units: Vec<&str> = machine.settings.iter().map(|setting| setting.unit.as_str()).collect();
    let mut request = serde_json::json!({
        "sensitivity": {
            "type": "matrix",
            "settings": names,
            "units": units,
            "matrix": machine.sensitivity.chunks(columns.max(1)).collect::<Vec<_>>(),
        },
        "response_uncertainty": uncertainty,
    });
    if machine.probe_noise > 0.0 {
        request["noise_sigma_um"] = machine.probe_noise.into();
    }
    if let Damping::Given(regularization) = &strategy.damping {
        request["regularization"] = serde_json::json!(regularization);
    }
    request.to_string().into_bytes()
}
