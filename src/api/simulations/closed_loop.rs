//! A closed loop simulated: measure, correct, machine again, with hidden errors of the machine and
//! noise of the probe.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

use super::faults;
use crate::{
    api::{
        built::Built,
        faults::{Faults, Field},
        fits::{canonical, spec::regularization_json},
        gears::correction,
        jobs::{fits, records},
        json::part::read_json,
        problem::Problem,
    },
    jobs::{IterationDraft, JobDraft, Measurand, MeasurementDetails, RecordDraft, RecordKind},
};
use flankfit_engine::{
    estimation::{
        Faults as FitFaults, Field as FitField, FitSpec, Nodes, Plans,
        spec::{Degree, Include, Model, PolynomialBasis, Regularization, Scaling, Terms},
    },
    fault::words::entries,
    gear::{
        correction as gear_correction,
        correction::{Correction, DEFAULT_RESPONSE_UNCERTAINTY, Damping, Setting, fault::CorrectionField},
        simulation::{MachineSpec, Simulation, Strategy, case, closed_loop},
    },
};

/// Most corrections of a run.
const MOST_CORRECTIONS: usize = 20;

/// A machine whose settings are off, and ways to correct it. Without a word it is the
/// ill-conditioned case: 5 × 9 nodes, six settings of which the sixth is nearly a mixture of two
/// others.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = ClosedLoopRequest)]
pub struct ClosedLoopBody {
    /// Of everything that is drawn. Default 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// How often the machine is corrected. Default 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 20)]
    pub corrections: Option<usize>,
    /// Ways to correct. Default `spectral_uncertainty` (what corrections do by default) and
    /// `least_squares`; further `spectral_min_mse`, `ridge_gcv` and so on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strategies: Option<Vec<String>>,
    /// Names of the settings, with `matrix`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settings: Option<Vec<String>>,
    /// µm at each of the nodes for a unit of each setting: what corrections know of the machine.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub matrix: Option<Vec<Vec<f64>>>,
    /// Of the nodes of `matrix`, which then are a grid over [-1, 1] × [-1, 1]: rows and columns.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grid: Option<[usize; 2]>,
    /// Standard deviation of what each setting is off by at first. Default 12 µm in the
    /// ill-conditioned case; needed with `matrix`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub setting_error: Option<Vec<f64>>,
    /// By how much an entry of the true response differs from the matrix, relative to it (standard
    /// deviation). Default 0.01.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0, maximum = 1)]
    pub response_noise: Option<f64>,
    /// What corrections take it to be. Default 0.02.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0, maximum = 1)]
    pub response_uncertainty: Option<f64>,
    /// Default 0.3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0, maximum = 1e6)]
    pub probe_noise_um: Option<f64>,
    /// Share of the nodes that a measurement misses; as many as there are settings must be left.
    /// Default 0.1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0, exclusive_maximum = 1)]
    pub missing: Option<f64>,
    /// Whether each run is kept as a job with its iterations and corrections, all in one
    /// transaction. Default false.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub store: Option<bool>,
}

/// What became of the machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ClosedLoop)]
pub struct ClosedLoopResultBody {
    /// The seed that was used: the same one gives the same runs.
    pub seed: u64,
    /// Condition of JᵀJ, as posted; left out where settings depend on each other exactly.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition: Option<f64>,
    /// One for each way to correct, all from the same machine.
    pub runs: Vec<ClosedLoopRunBody>,
}

/// One way to correct.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ClosedLoopRun)]
pub struct ClosedLoopRunBody {
    /// How corrections were computed, such as `least_squares`, or the regularisation and its
    /// criterion.
    pub strategy: String,
    /// Where it is kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub job_id: Option<Uuid>,
    /// Measurements: the first one, and one after each correction.
    pub rounds: Vec<ClosedLoopRoundBody>,
}

/// A measurement and the correction that followed from it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ClosedLoopRound)]
pub struct ClosedLoopRoundBody {
    /// Number of the iteration.
    pub iteration: u32,
    /// Of the nodes that were measured.
    pub rms_measured_um: f64,
    /// Without noise, over all nodes: only a simulation knows.
    pub rms_true_um: f64,
    /// What the correction promised; left out after the last measurement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rms_predicted_um: Option<f64>,
    /// The changes of the settings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub changes: Option<Vec<f64>>,
}

/// A run with everything that may be kept of it.
pub struct Told {
    pub run: ClosedLoopRunBody,
    pub kept: Option<Kept>,
}

/// Where a run is to be kept.
pub struct Kept {
    pub job: JobDraft,
    /// For each round the iteration, with the correction that followed.
    pub rounds: Vec<IterationDraft>,
}

/// Every run of a request. Processor work.
pub struct Simulated {
    pub seed: u64,
    pub condition: Option<f64>,
    pub runs: Vec<Told>,
}

/// Simulates. Processor work.
pub fn simulate(text: &[u8], plans: &Plans) -> Result<Simulated, Problem> {
    let body: ClosedLoopBody = read_json(text)?;
    let (machine, grid) = body.machine().map_err(Problem::invalid)?;
    let strategies = body.strategies().map_err(Problem::invalid)?;
    let store = body.store.unwrap_or(false);
    if store && grid.iter().any(|&nodes| nodes < 3) {
        let detail = "each measurement is kept with its surface of second order, which takes 3 × 3 nodes";
        return Err(Problem::invalid(Faults::one("/grid", detail)));
    }
    let corrections = body.corrections.unwrap_or(2);
    if !(1..=MOST_CORRECTIONS).contains(&corrections) {
        let detail = format!("{corrections} is not one of 1 to {MOST_CORRECTIONS}");
        return Err(Problem::invalid(Faults::one("/corrections", detail)));
    }
    let uncertainty = body.response_uncertainty.unwrap_or(DEFAULT_RESPONSE_UNCERTAINTY);
    let drawn = Simulation::new(machine.clone()).map_err(Problem::invalid)?;
    let condition = condition(&machine)?;
    let runs = strategies
        .iter()
        .map(|strategy| tell(drawn.clone(), grid, strategy, uncertainty, corrections, store, plans))
        .collect::<Result<Vec<Told>, Problem>>()?;
    Ok(Simulated { seed: machine.seed, condition, runs })
}

impl ClosedLoopBody {
    fn machine(&self) -> Result<(MachineSpec, [usize; 2]), Faults> {
        let mut machine = case::ill_conditioned(self.seed.unwrap_or(0));
        let mut grid = case::GRID;
        let mut faults = Faults::default();
        match (&self.matrix, &self.settings, &self.grid, &self.setting_error) {
            (Some(matrix), Some(settings), Some([rows, columns]), Some(error)) => {
                let nodes = rows.saturating_mul(*columns);
                if matrix.len() != nodes || *rows < 2 || *columns < 2 {
                    faults.push("/grid", format!("{rows} × {columns} nodes do not match {} rows", matrix.len()));
                }
                for (k, row) in matrix.iter().enumerate().filter(|(_, row)| row.len() != settings.len()) {
                    faults.push(
                        format!("/matrix/{k}"),
                        format!("{} for {} settings", entries(row.len()), settings.len()),
                    );
                }
                grid = [*rows, *columns];
                machine.sensitivity = matrix.concat();
                machine.settings = settings.iter().map(|name| Setting::free(name.clone(), "")).collect();
                machine.setting_error.clone_from(error);
            }
            (None, None, None, error) => {
                if let Some(error) = error {
                    machine.setting_error.clone_from(error);
                }
            }
            (matrix, settings, grid, error) => {
                let parts = [
                    ("/matrix", matrix.is_none()),
                    ("/settings", settings.is_none()),
                    ("/grid", grid.is_none()),
                    ("/setting_error", error.is_none()),
                ];
                for (pointer, _) in parts.into_iter().filter(|(_, missing)| *missing) {
                    faults.push(pointer, "missing: `matrix`, `settings`, `grid` and `setting_error` belong together");
                }
            }
        }
        machine.response_noise = self.response_noise.unwrap_or(machine.response_noise);
        machine.probe_noise = self.probe_noise_um.unwrap_or(machine.probe_noise);
        machine.missing = self.missing.unwrap_or(machine.missing);
        faults.into_result((machine, grid))
    }

    fn strategies(&self) -> Result<Vec<Strategy>, Faults> {
        let Some(names) = &self.strategies else {
            return Ok(vec![Strategy::uncertainty(), Strategy::least_squares()]);
        };
        let known = Strategy::all();
        let mut faults = Faults::default();
        if names.is_empty() {
            faults.push("/strategies", "there is none");
        }
        let mut found = Vec::with_capacity(names.len());
        for (k, name) in names.iter().enumerate() {
            match known.iter().find(|strategy| strategy.name == *name) {
                Some(strategy) if !found.contains(strategy) => found.push(strategy.clone()),
                Some(_) => faults.push(format!("/strategies/{k}"), "it is there twice"),
                None => {
                    let names: Vec<_> = known.iter().map(|strategy| format!("`{}`", strategy.name)).collect();
                    faults.push(format!("/strategies/{k}"), format!("not one of {}", names.join(", ")));
                }
            }
        }
        faults.into_result(found)
    }
}

/// Condition of JᵀJ; `None` where settings depend on each other exactly.
fn condition(machine: &MachineSpec) -> Result<Option<f64>, Problem> {
    let columns = machine.settings.len();
    let rows = machine.sensitivity.len() / columns.max(1);
    let asked = gear_correction::CorrectionSpec {
        scaling: Scaling::None,
        damping: Damping::Given(Regularization::None),
        ..gear_correction::CorrectionSpec::new(vec![0.0; rows], machine.sensitivity.clone(), machine.settings.clone())
    };
    let all = Correction::new(asked).map_err(|found| Problem::invalid(Faults::by(&found, faults::correction)))?;
    let solution = all.solve().map_err(|error| Problem::of_fit(error, |_| "/matrix".to_owned()))?;
    Ok(solution.fit.spectrum.condition)
}

/// What a run cannot go on with, by places in the request; `number` is how often the machine was
/// corrected.
fn place(number: usize) -> impl Fn(&FitField) -> String {
    move |field| match field {
        field if field.is_of_regularization() => "/strategies".to_owned(),
        // the settings can be told from all nodes, as `condition` knows
        field if field.is_of_model() => "/missing".to_owned(),
        // numbers within their limits are out of range only when settings have run away
        _ if number > 0 => "/corrections".to_owned(),
        field => field.pointer(),
    }
}

fn tell(
    mut simulation: Simulation,
    [rows, columns]: [usize; 2],
    strategy: &Strategy,
    uncertainty: f64,
    corrections: usize,
    store: bool,
    plans: &Plans,
) -> Result<Told, Problem> {
    let machine = simulation.asked().clone();
    let mut rounds = Vec::with_capacity(corrections + 1);
    let mut kept = Vec::with_capacity(corrections + 1);
    for number in 0..=corrections {
        let measured = simulation.measure();
        let true_rms = simulation.true_rms();
        let nodes =
            grid(rows, columns, &measured).map_err(|faults| Problem::invalid(Faults::by(&faults, place(number))))?;
        let mut round = ClosedLoopRoundBody {
            iteration: u32::try_from(number + 1).unwrap_or(u32::MAX),
            rms_measured_um: rms(&measured),
            rms_true_um: true_rms,
            rms_predicted_um: None,
            changes: None,
        };
        let mut record = None;
        if number < corrections {
            let asked = closed_loop::asked(&simulation, measured, strategy, uncertainty);
            let request = request(&machine, uncertainty, strategy);
            let refused = |error| Problem::of_fit(error, place(number));
            let correction = Correction::new(asked).map_err(|found| {
                let place = |field: &CorrectionField| match number {
                    0 => faults::correction(field),
                    _ => "/corrections".to_owned(),
                };
                Problem::invalid(Faults::by(&found, place))
            })?;
            let solution = correction.solve().map_err(refused)?;
            let changes: Vec<f64> = solution.settings.iter().map(|setting| setting.change).collect();
            simulation.apply(&changes).map_err(Problem::invalid)?;
            round.rms_predicted_um = Some(solution.predicted.rms);
            round.changes = Some(changes);
            if store {
                let result =
                    correction::write(&solution, None, &canonical::request_sha256(&request), Include::default())?;
                let built = Built { method: "matrix".to_owned(), result };
                record = Some(records::draft(RecordKind::Correction, &request, built)?);
            }
        }
        if store {
            kept.push(iteration(nodes, strategy, number, record, plans)?);
        }
        rounds.push(round);
    }
    let run = ClosedLoopRunBody { strategy: strategy.name.clone(), job_id: None, rounds };
    let job = JobDraft {
        name: format!("Closed loop, seed {}, {}", machine.seed, strategy.name),
        machine: Some("simulated".to_owned()),
        ..JobDraft::default()
    };
    Ok(Told { run, kept: store.then_some(Kept { job, rounds: kept }) })
}

/// Root mean square of the nodes that were measured.
fn rms(measured: &[f64]) -> f64 {
    let (sum, count) =
        measured.iter().filter(|d| !d.is_nan()).fold((0.0, 0.0), |(sum, count), d| (sum + d * d, count + 1.0));
    f64::sqrt(sum / f64::max(count, 1.0))
}

/// Deviations over [-1, 1] × [-1, 1].
fn grid(rows: usize, columns: usize, measured: &[f64]) -> Result<Nodes, FitFaults> {
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
    let computed = fits::compute_at(&nodes, &spec, plans, place(number))?;
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
        let body = regularization_json::regularization(regularization);
        request["regularization"] = serde_json::to_value(body).unwrap_or_default();
    }
    request.to_string().into_bytes()
}
