//! The noise of the nodes of now and of those before.

use super::{
    current::{Current, PooledNoise},
    observe::Observed,
};
use crate::result::Warning;
use flankfit_numerics::{check::Faults, distribution::fisher};

/// Probability below which two σ count as different.
const IMPROBABLE: f64 = 1e-3;

/// σ that was given, or that of all residuals together.
pub(super) fn pooled(current: &Current, observed: &[Observed]) -> Result<PooledNoise, Faults> {
    if let Some(sigma) = current.spec.noise_sigma {
        return Ok(PooledNoise { sigma, freedom: None });
    }
    let earlier = of_earlier(observed);
    let freedom = current.freedom + earlier.1;
    let sigma = ((current.rss + earlier.0) / freedom as f64).sqrt();
    if freedom > 0 && sigma > 0.0 {
        return Ok(PooledNoise { sigma, freedom: Some(freedom) });
    }
    Err(Faults::one("noise_sigma", "there is no estimate of the noise, which the `prior` needs: give `noise_sigma`"))
}

/// Compares σ of the present nodes with that of all earlier residuals together, by Fisher's ratio
/// of variances; `None` if they agree.
pub(super) fn unequal(current: &Current, observed: &[Observed]) -> Option<Warning> {
    let (rss, freedom) = of_earlier(observed);
    if current.spec.noise_sigma.is_some() || current.freedom == 0 || freedom == 0 {
        return None;
    }
    let [mine, theirs] = [current.freedom as f64, freedom as f64];
    let (now, earlier) = (current.rss / mine, rss / theirs);
    let larger = if now > earlier {
        fisher::upper_tail(now / earlier, mine, theirs)
    } else {
        fisher::upper_tail(earlier / now, theirs, mine)
    };
    let p = (2.0 * larger).min(1.0);
    (p < IMPROBABLE).then(|| Warning::UnequalNoise { now: now.sqrt(), earlier: earlier.sqrt(), p })
}

/// Residual sum of squares and degrees of freedom.
fn of_earlier(observed: &[Observed]) -> (f64, usize) {
    observed.iter().fold((0.0, 0), |(rss, freedom), one| (rss + one.rss, freedom + one.freedom))
}
