//! Whole runs: measure, fit, correct, machine again.

use super::{MOST_CORRECTIONS, MachineSpec, Simulation, rms};
use crate::correction::{self, Answer, Correction, Damping, Noise, Solution, compare};
use flankfit_estimation::{
    FitError,
    spec::{Count, Criterion, DEFAULT_CONDITION_LIMIT, Parameter, Regularization, Scheme},
};
use flankfit_numerics::{cancel, check::Faults};

/// A way to correct.
#[derive(Clone, Debug, PartialEq)]
pub struct Strategy {
    /// Name in the run's results.
    pub name: String,
    /// How λ* is chosen.
    pub damping: Damping,
}

impl Strategy {
    /// Plain least squares.
    pub fn least_squares() -> Self {
        Strategy { name: "least_squares".into(), damping: Damping::Given(Regularization::None) }
    }

    /// The default of corrections: spectral, λ* from the uncertainty of J and the noise.
    pub fn uncertainty() -> Self {
        Strategy { name: "spectral_uncertainty".into(), damping: Damping::Uncertainty }
    }

    /// Spectral regularisation with its own count and a criterion.
    pub fn spectral(criterion: Criterion) -> Self {
        let regularization = Regularization::Spectral {
            scheme: Scheme::FirstOrder,
            count: Count::Auto,
            condition_limit: DEFAULT_CONDITION_LIMIT,
            lambda_star: Parameter::Criterion(criterion),
        };
        Strategy { name: format!("spectral_{}", criterion.name()), damping: Damping::Given(regularization) }
    }

    /// Ridge with a criterion.
    pub fn ridge(criterion: Criterion) -> Self {
        let regularization = Regularization::Ridge { parameter: Parameter::Criterion(criterion) };
        Strategy { name: format!("ridge_{}", criterion.name()), damping: Damping::Given(regularization) }
    }

    /// All that are worth comparing, the default first and plain least squares second.
    pub fn all() -> Vec<Strategy> {
        let mut all = vec![Self::uncertainty(), Self::least_squares()];
        all.extend(Criterion::ALL.map(Self::spectral));
        all.extend([Criterion::MinMse, Criterion::Gcv, Criterion::Hkb, Criterion::LawlessWang].map(Self::ridge));
        all
    }
}

/// One measurement with the correction that followed from it, if any.
#[derive(Clone, Debug, PartialEq)]
pub struct Round {
    /// Corrections before.
    pub number: u64,
    /// Deviations, µm for each node, NaN where undefined.
    pub measured: Vec<f64>,
    /// Root mean square of `measured` over its defined nodes, µm.
    pub measured_rms: f64,
    /// Without noise and over all nodes, which only a simulation knows.
    pub true_rms: f64,
    /// How the machine answered to the correction before; `None` for the first measurement.
    pub answer: Option<Answer>,
    /// `None` for the last measurement.
    pub solution: Option<Solution>,
}

/// All rounds of one machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Name of the strategy.
    pub strategy: String,
    /// One more than corrections.
    pub rounds: Vec<Round>,
}

/// Specification of the correction in a round: the probe noise is known, the uncertainty of the
/// response is what the caller says it is.
pub fn correction_spec(
    simulation: &Simulation,
    measured: Vec<f64>,
    strategy: &Strategy,
    response_uncertainty: f64,
) -> correction::CorrectionSpec {
    let MachineSpec { sensitivity, settings, probe_noise, .. } = simulation.spec();
    correction::CorrectionSpec {
        damping: strategy.damping.clone(),
        noise_sigma: Some(*probe_noise).filter(|sigma| *sigma > 0.0),
        response_uncertainty,
        ..correction::CorrectionSpec::new(measured, sensitivity.clone(), settings.clone())
    }
}

fn changes(solution: &Solution) -> Vec<f64> {
    solution.settings.iter().map(|setting| setting.change).collect()
}

/// Corrects a machine `corrections` times. Refuses more than [`MOST_CORRECTIONS`] and what
/// [`Simulation::new`] refuses.
pub fn run(
    machine: &MachineSpec,
    strategy: &Strategy,
    response_uncertainty: f64,
    corrections: usize,
) -> Result<Run, FitError> {
    if corrections > MOST_CORRECTIONS {
        let message = format_args!("{corrections} corrections; at most {MOST_CORRECTIONS}");
        return Err(Faults::one("corrections", message).into());
    }
    let mut simulation = Simulation::new(machine.clone())?;
    let mut rounds: Vec<Round> = Vec::with_capacity(corrections + 1);
    let mut last: Option<Correction> = None;
    for number in 0..=corrections {
        cancel::checkpoint();
        let (measured, true_rms) = (simulation.measure(), simulation.true_rms());
        let answer = match (rounds.last().and_then(|round| round.solution.as_ref()), last.take()) {
            (Some(solution), Some(correction)) => {
                let noise = Noise { sigma: machine.probe_noise, freedom: None };
                let leverage = solution.leverage.clone();
                Some(compare(&correction.comparison(&changes(solution), leverage, noise, measured.clone()))?)
            }
            _ => None,
        };
        let solution = match number < corrections {
            true => {
                let asked = correction_spec(&simulation, measured.clone(), strategy, response_uncertainty);
                let correction = Correction::new(asked)?;
                let solution = correction.solve()?;
                last = Some(correction);
                simulation.apply(&changes(&solution))?;
                Some(solution)
            }
            false => None,
        };
        let measured_rms = rms(&measured);
        rounds.push(Round { number: number as u64, measured, measured_rms, true_rms, answer, solution });
    }
    Ok(Run { strategy: strategy.name.clone(), rounds })
}
