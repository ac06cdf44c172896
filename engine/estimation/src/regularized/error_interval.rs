//! An interval of the squared error of a filtered estimate.
//!
//! Along the eigenvectors the error is `fa − α = (f − 1)a + (a − α)`, and a − α lies in the
//! ellipsoid `Σ λᵢ(aᵢ − αᵢ)² ≤ ρ²` with the probability of the level, ρ² = nσ̂²F. So the least and
//! the greatest squared length of the error over the ellipsoid hold at least as often, however f
//! was chosen.

use super::context::Context;
use crate::selection::Filtered;
use flankfit_numerics::{
    distribution::{chi_squared, fisher},
    root::boundary,
};

/// Returns the least and the greatest squared error at the level of the spec; `None` without noise,
/// or where a direction is not determined.
pub(super) fn error_interval(context: &Context, filtered: &[Filtered]) -> Option<[f64; 2]> {
    let (spec, spectrum, n) = (context.spec, context.spectrum, filtered.len() as f64);
    if !spectrum.full_rank() {
        return None;
    }
    let miss = 1.0 - spec.level;
    let radius = match spec.noise_sigma {
        Some(_) => chi_squared::upper_quantile(miss, n),
        None if context.degrees_of_freedom > 0 => {
            n * fisher::upper_quantile(miss, n, context.degrees_of_freedom as f64)
        }
        None => return None,
    };
    let sigma = context.variance?.sqrt();
    let moved = filtered.iter().zip(&spectrum.a).map(|(one, a)| -one.removed * a);
    let axes: Vec<[f64; 2]> = moved.zip(&spectrum.lambda).map(|(d, lambda)| [d, sigma / lambda.sqrt()]).collect();
    Some([least(&axes, radius), greatest(&axes, radius)]).filter(|ends| ends.iter().all(|x| x.is_finite()))
}

/// z of the extreme of `Σ(d + sz)²` over a ball with the multiplier `mu`, and its squared length.
fn at(axes: &[[f64; 2]], mu: f64) -> (Vec<f64>, f64) {
    let z: Vec<f64> = axes.iter().map(|[d, s]| if *d == 0.0 { 0.0 } else { s * d / (mu - s * s) }).collect();
    let square = z.iter().map(|z| z * z).sum();
    (z, square)
}

fn value(axes: &[[f64; 2]], z: &[f64]) -> f64 {
    axes.iter().zip(z).map(|([d, s], z)| (d + s * z).powi(2)).sum()
}

fn least(axes: &[[f64; 2]], radius: f64) -> f64 {
    if at(axes, 0.0).1 <= radius {
        return 0.0;
    }
    let far = axes.iter().map(|[d, s]| (s * d).abs()).sum::<f64>() / radius.sqrt();
    let [outside, _] = boundary([0.0, -far], 0.0, |mu| at(axes, mu).1 > radius);
    value(axes, &at(axes, outside).0)
}

fn greatest(axes: &[[f64; 2]], radius: f64) -> f64 {
    let longest = axes.iter().map(|[_, s]| s * s).fold(0.0, f64::max);
    let far = longest + axes.iter().map(|[d, s]| (s * d).abs()).sum::<f64>() / radius.sqrt();
    let [_, within] = boundary([longest, far], 0.0, |mu| at(axes, mu).1 > radius);
    let (z, square) = at(axes, within);
    // where the longest axis is not displaced the rest of the ball lies along it
    value(axes, &z) + longest * (radius - square).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Extremes over a dense set of directions on the circle.
    #[test]
    fn the_ends_are_the_extremes_over_the_ball() {
        for axes in
            [[[0.3, 1.0], [-2.0, 0.5]], [[0.0, 1.0], [0.7, 0.2]], [[5.0, 0.1], [-3.0, 0.2]], [[0.0, 1.0], [0.0, 3.0]]]
        {
            let radius: f64 = 6.0;
            let (mut low, mut high) = (f64::INFINITY, 0.0f64);
            for k in 0..20_000 {
                let angle = f64::from(k) * std::f64::consts::PI / 10_000.0;
                for share in 0..=20 {
                    let r = radius.sqrt() * f64::from(share) / 20.0;
                    let found = value(&axes, &[r * angle.cos(), r * angle.sin()]);
                    (low, high) = (low.min(found), high.max(found));
                }
            }
            let [least, greatest] = [least(&axes, radius), greatest(&axes, radius)];
            assert!((greatest - high).abs() < 1e-6 * high, "{axes:?}: {greatest} {high}");
            assert!(least <= low + 1e-9 && low - least < 0.02 * (1.0 + low), "{axes:?}: {least} {low}");
        }
    }
}
