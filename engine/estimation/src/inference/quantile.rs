//! Half-widths of intervals about an estimate that may be off by a known bound.

use super::noise::Noise;
use flankfit_numerics::root::root;

/// q with P(|T + u| ≤ q) = level, T Student's: half the width, in standard errors, of an interval
/// about an estimate whose bias may reach u ≥ 0 standard errors. Covers what it says for normal
/// errors at every bias up to u: at level 0.95 and from 3 degrees of freedom on 0.950–0.956 where
/// the bias is u itself (by integration over χ²), and up to 1 where it is smaller.
///
/// ```
/// use flankfit_estimation::inference::{Noise, biased_quantile};
///
/// let noise = Noise::known(1.0, 0.95);
/// // no bias: 1.96; much: the bias and one tail
/// assert!((biased_quantile(&noise, 0.0) - 1.959_964).abs() < 1e-6);
/// assert!((biased_quantile(&noise, 1.0) - 2.646_145_5).abs() < 1e-7);
/// assert!((biased_quantile(&noise, 9.0) - (9.0 + 1.644_854)).abs() < 1e-6);
/// ```
pub fn biased_quantile(noise: &Noise, u: f64) -> f64 {
    let two_sided = noise.quantile();
    if !(u > 0.0) {
        return two_sided;
    }
    let one_sided = noise.student.upper_quantile(noise.miss);
    between(noise, u, u + one_sided, u + two_sided)
}

/// The same between bounds: the whole miss on one side, and half of it on each.
fn between(noise: &Noise, u: f64, low: f64, high: f64) -> f64 {
    let student = &noise.student;
    let over = |q: f64| student.upper_tail(q - u) + student.upper_tail(q + u) - noise.miss;
    let (at_low, at_high) = (over(low), over(high));
    // no change of sign but by rounding, at an end
    let end = if at_high >= 0.0 { high } else { low };
    root([(low, at_low), (high, at_high)], |q| 1e-13 * q, over).unwrap_or(end)
}

/// Half the width of the interval about an estimate with standard error `error` and a bias of at
/// most `bias`.
pub fn half_width(noise: &Noise, error: f64, bias: f64) -> f64 {
    // without noise the bias is all there is; where the ratio overflows as well
    let u = bias / error;
    if u.is_finite() { error * biased_quantile(noise, u) } else { bias }
}

/// q as [`biased_quantile`] has it, and its derivative to u.
pub(super) fn with_slope(noise: &Noise, u: f64, one_sided: f64, two_sided: f64) -> (f64, f64) {
    let q = if u > 0.0 { between(noise, u, u + one_sided, u + two_sided) } else { two_sided };
    let (near, far) = (noise.student.density(q - u), noise.student.density(q + u));
    (q, (near - far) / (near + far))
}

#[cfg(test)]
mod tests {
    use super::*;
    use flankfit_numerics::distribution::normal;

    /// Coverage of an interval about an estimate of standard error 1 that is off by `off`, if its
    /// bias is known to be at most `bias` and its standard error is estimated: the integral over
    /// the density of χ.
    fn coverage(freedom: f64, bias: f64, off: f64) -> f64 {
        const STEPS: u32 = 600;
        let (mut held, mut whole) = (0.0, 0.0);
        for k in 0..STEPS {
            let s = 5.0 * (f64::from(k) + 0.5) / f64::from(STEPS);
            let weight = libm::exp((freedom - 1.0) * libm::log(s) - 0.5 * freedom * s * s);
            let half = half_width(&Noise::estimated(s, freedom, 0.95), s, bias);
            held += weight * (normal::upper_tail(-half - off) - normal::upper_tail(half - off));
            whole += weight;
        }
        held / whole
    }

    #[test]
    fn it_holds_at_every_bias_up_to_the_bound() {
        for freedom in [3.0, 10.0, 40.0] {
            for bias in [0.0, 0.25, 0.5, 1.0, 2.0, 4.0] {
                let at_worst = coverage(freedom, bias, bias);
                assert!((0.9495..0.9575).contains(&at_worst), "{freedom} {bias}: {at_worst}");
                let less = [0.0, 0.5 * bias].map(|off| coverage(freedom, bias, off));
                assert!(less.iter().all(|held| *held >= at_worst - 1e-9), "{freedom} {bias}: {less:?}");
            }
        }
    }
}
