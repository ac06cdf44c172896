//! L-estimators and likelihoods of a request, checked.

use crate::api::{faults::Faults, fits::spec::estimator::*};
use flankfit_engine::{
    estimation::spec::{DEFAULT_SHARE, Distribution, LEstimator, QuantileWeights},
    words::Shown,
};

const AT: &str = "/estimator";

pub(super) fn l_estimator(body: &LEstimatorBody, faults: &mut Faults) -> Option<LEstimator> {
    let combined = body.form == LEstimatorForm::Quantiles;
    let lists = [("quantiles", body.quantiles.is_some()), ("weights", body.weights.is_some())];
    for (name, given) in lists {
        if given != combined {
            let detail =
                if combined { "missing; the form `quantiles` needs it" } else { "only the form `quantiles` takes it" };
            faults.push(format!("{AT}/{name}"), detail);
        }
    }
    if combined && body.share.is_some() {
        faults.push(format!("{AT}/share"), "only the forms `trimmed` and `winsorized` take it");
    }
    let share = body.share.unwrap_or(DEFAULT_SHARE);
    if !(share > 0.0 && share < 0.5) {
        faults.push(format!("{AT}/share"), format!("{} is not between 0 and 0.5", Shown(share)));
    }
    match body.form {
        LEstimatorForm::Trimmed => Some(LEstimator::Trimmed { share }),
        LEstimatorForm::Winsorized => Some(LEstimator::Winsorized { share }),
        LEstimatorForm::Quantiles => {
            quantiles(body.quantiles.as_deref()?, body.weights.as_deref()?, faults).map(LEstimator::Quantiles)
        }
    }
}

fn quantiles(taus: &[f64], weights: &[f64], faults: &mut Faults) -> Option<QuantileWeights> {
    const MOST: usize = QuantileWeights::MOST;
    if taus.is_empty() || taus.len() > MOST {
        faults.push(format!("{AT}/quantiles"), format!("{} quantiles; 1 to {MOST} can be asked for", taus.len()));
        return None;
    }
    if taus.len() != weights.len() {
        faults.push(format!("{AT}/weights"), format!("{} weights for {} quantiles", weights.len(), taus.len()));
        return None;
    }
    for (i, tau) in taus.iter().enumerate() {
        if !(*tau > 0.0 && *tau < 1.0) {
            faults.push(format!("{AT}/quantiles/{i}"), format!("{} is not between 0 and 1", Shown(*tau)));
            return None;
        }
        if i > 0 && *tau <= taus[i - 1] {
            faults.push(format!("{AT}/quantiles/{i}"), format!("{} is not above the one before", Shown(*tau)));
            return None;
        }
    }
    let pairs: Vec<[f64; 2]> = taus.iter().zip(weights).map(|(tau, weight)| [*tau, *weight]).collect();
    let found = QuantileWeights::new(&pairs);
    if found.is_none() {
        let sum: f64 = weights.iter().sum();
        faults.push(format!("{AT}/weights"), format!("the weights add up to {}, not to 1", Shown(sum)));
    }
    found
}

pub(super) fn likelihood(body: &MaximumLikelihoodEstimator, faults: &mut Faults) -> Option<Distribution> {
    let range = match body.distribution {
        DistributionName::Student => Distribution::FREEDOM,
        DistributionName::GeneralizedNormal => Distribution::EXPONENT,
        DistributionName::Laplace => {
            if body.shape.is_some() {
                faults.push(format!("{AT}/shape"), "the distribution `laplace` takes none");
            }
            return Some(Distribution::Laplace);
        }
    };
    if let Some(shape) = body.shape.filter(|shape| !(range[0] <= *shape && *shape <= range[1])) {
        let [low, high] = range;
        faults.push(format!("{AT}/shape"), format!("{} is not between {low} and {high}", Shown(shape)));
    }
    Some(match body.distribution {
        DistributionName::Student => Distribution::Student { freedom: body.shape },
        _ => Distribution::GeneralizedNormal { exponent: body.shape },
    })
}
