//! The estimator of a request: wire form to a checked [`Estimator`], with the contract's defaults
//! and ranges.

use super::l_estimator::{l_estimator, likelihood};
use crate::api::{
    faults::Faults,
    fits::spec::{contamination::ContaminationBody, estimator::*},
    json::{
        tags::{read_tag, unknown_type},
        value::read_value,
    },
};
use flankfit_engine::{
    estimation::spec::{Contamination, DEFAULT_COVERAGE, DEFAULT_K2, Estimator, Loss, MEstimator, ScaleRule, Start},
    words::{Counted, Shown, counted},
};

/// The estimators that there are.
const ESTIMATORS: &str = "least_squares, m_estimator, least_absolute_deviations, lp, quantile, least_trimmed_squares, \
    rank, l_estimator and maximum_likelihood are";

const AT: &str = "/estimator";
/// k₂ of proposal 2.
const K2: std::ops::RangeInclusive<f64> = 0.01..=100.0;

/// Reads the estimator; faults say where.
pub fn read_estimator(slice: &[u8], faults: &mut Faults) -> Option<Estimator> {
    let before = faults.count();
    let estimator = match read_tag(slice, AT, ESTIMATORS, faults)?.as_str() {
        "least_squares" => {
            let _checked: LeastSquaresEstimator = read_value(slice, AT, faults)?;
            Estimator::LeastSquares
        }
        "m_estimator" => Estimator::M(m_estimator(read_value(slice, AT, faults)?, faults)?),
        "least_absolute_deviations" => {
            let _checked: LeastAbsoluteDeviationsEstimator = read_value(slice, AT, faults)?;
            Estimator::LeastAbsolute
        }
        "lp" => {
            let LpEstimator { p, .. } = read_value(slice, AT, faults)?;
            if !(1.0..=2.0).contains(&p) {
                faults.push(format!("{AT}/p"), format!("{} is not between 1 and 2", Shown(p)));
            }
            Estimator::Lp { p }
        }
        "quantile" => {
            let QuantileEstimator { tau, .. } = read_value(slice, AT, faults)?;
            if !(tau > 0.0 && tau < 1.0) {
                faults.push(format!("{AT}/tau"), format!("{} is not between 0 and 1", Shown(tau)));
            }
            Estimator::Quantile { tau }
        }
        "least_trimmed_squares" => {
            let body: LeastTrimmedSquaresEstimator = read_value(slice, AT, faults)?;
            let (coverage, seed) = (body.coverage.unwrap_or(DEFAULT_COVERAGE), body.seed.unwrap_or(0));
            if !(0.5..=1.0).contains(&coverage) {
                faults.push(format!("{AT}/coverage"), format!("{} is not between 0.5 and 1", Shown(coverage)));
            }
            if seed > MOST_SEED {
                faults.push(format!("{AT}/seed"), format!("{seed} is greater than {MOST_SEED}"));
            }
            Estimator::LeastTrimmed { coverage, seed }
        }
        "rank" => {
            let body: RankEstimator = read_value(slice, AT, faults)?;
            match body.scores {
                None | Some(ScoresName::Wilcoxon) => Estimator::Rank,
                Some(ScoresName::Normal) => Estimator::NormalScores,
            }
        }
        "l_estimator" => Estimator::L(l_estimator(&read_value(slice, AT, faults)?, faults)?),
        "maximum_likelihood" => Estimator::Likelihood(likelihood(&read_value(slice, AT, faults)?, faults)?),
        other => {
            unknown_type(AT, other, ESTIMATORS, faults);
            return None;
        }
    };
    (faults.count() == before).then_some(estimator)
}

fn m_estimator(body: MEstimatorBody, faults: &mut Faults) -> Option<MEstimator> {
    let contamination = match body.contamination {
        Some(share) => Some(contamination(share, &body, faults)?),
        None => None,
    };
    let loss = match (&body.tuning, contamination) {
        (_, Some(contamination)) => MEstimator::minimax(contamination).loss,
        (None, None) => body.loss.usual(),
        (Some(tuning), None) => tuned(body.loss, tuning, faults)?,
    };
    let tolerance = body.tolerance.unwrap_or(MEstimator::TOLERANCE);
    if !(tolerance > 0.0 && tolerance <= 0.1) {
        faults.push(format!("{AT}/tolerance"), format!("{} is not greater than 0 and at most 0.1", Shown(tolerance)));
    }
    let max_iterations = body.max_iterations.unwrap_or(MEstimator::ITERATIONS);
    let most = MEstimator::MOST_ITERATIONS;
    if !(1..=most).contains(&max_iterations) {
        faults.push(format!("{AT}/max_iterations"), format!("{max_iterations} is not between 1 and {most}"));
    }
    Some(MEstimator {
        loss,
        scale: body.scale.map_or(Some(ScaleRule::default()), |scale| scale_rule(&scale, faults))?,
        tolerance,
        max_iterations,
        start: body.start.map_or_else(Start::default, Start::from),
        contamination,
    })
}

/// The share of gross errors, for Huber's loss without a tuning constant.
fn contamination(given: ContaminationBody, body: &MEstimatorBody, faults: &mut Faults) -> Option<Contamination> {
    let pointer = || format!("{AT}/contamination");
    if body.loss != LossName::Huber {
        faults.push(pointer(), "only the loss `huber` takes it");
        return None;
    }
    if body.tuning.is_some() {
        faults.push(pointer(), "the tuning constant follows from it: give one of both");
        return None;
    }
    let [low, high] = Contamination::SHARE;
    match given {
        ContaminationBody::Estimate(_) => Some(Contamination::Estimated),
        ContaminationBody::Share(share) if (low..=high).contains(&share) => Some(Contamination::Share(share)),
        ContaminationBody::Share(share) => {
            faults.push(pointer(), format!("{} is not between {low} and {high}", Shown(share)));
            None
        }
    }
}

fn tuned(loss: LossName, tuning: &[f64], faults: &mut Faults) -> Option<Loss> {
    for (i, value) in tuning.iter().enumerate() {
        if *value <= 0.0 {
            faults.push(format!("{AT}/tuning/{i}"), format!("{} is not greater than 0", Shown(*value)));
            return None;
        }
    }
    match (loss, tuning) {
        (LossName::Huber, &[k]) => Some(Loss::Huber { k }),
        (LossName::Tukey, &[c]) => Some(Loss::Tukey { c }),
        (LossName::Andrews, &[a]) => Some(Loss::Andrews { a }),
        (LossName::Hampel, &[a, b, c]) if a <= b && b < c => Some(Loss::Hampel { a, b, c }),
        (LossName::Hampel, &[a, b, c]) => {
            faults.push(
                format!("{AT}/tuning"),
                format!("{}, {}, {} do not ascend: a ≤ b < c is needed", Shown(a), Shown(b), Shown(c)),
            );
            None
        }
        (LossName::Hampel, other) => {
            faults.push(format!("{AT}/tuning"), format!("{}; hampel has three, a ≤ b < c", constants(other)));
            None
        }
        (_, other) => {
            faults.push(format!("{AT}/tuning"), format!("{}; this loss has one", constants(other)));
            None
        }
    }
}

fn constants(given: &[f64]) -> Counted {
    counted(given.len(), "constant", "constants")
}

fn scale_rule(scale: &ScaleBody, faults: &mut Faults) -> Option<ScaleRule> {
    let pointer = format!("{AT}/scale/value");
    match (scale.rule, scale.value) {
        (ScaleRuleName::Mad06745, None) => Some(ScaleRule::Mad06745),
        (ScaleRuleName::Mad, None) => Some(ScaleRule::Mad),
        (ScaleRuleName::Mad06745 | ScaleRuleName::Mad, Some(_)) => {
            faults.push(pointer, "only the rules `fixed` and `proposal2` take a value");
            None
        }
        (ScaleRuleName::Proposal2, value) => {
            let k2 = value.unwrap_or(DEFAULT_K2);
            if !K2.contains(&k2) {
                faults.push(pointer, format!("k₂ = {} is not between {} and {}", Shown(k2), K2.start(), K2.end()));
            }
            Some(ScaleRule::Proposal2 { k2 })
        }
        (ScaleRuleName::Fixed, Some(value)) => {
            if value <= 0.0 {
                faults.push(pointer, format!("{} is not greater than 0", Shown(value)));
            }
            Some(ScaleRule::Fixed(value))
        }
        (ScaleRuleName::Fixed, None) => {
            faults.push_missing(pointer, "missing; the rule `fixed` needs it");
            None
        }
    }
}
