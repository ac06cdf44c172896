//! Number of correct digits of the least-squares coefficients: a cautious estimate.
//!
//! For each coefficient it adds up, relative to its size: what the arithmetic may have left, what
//! the rounding of the posted numbers to doubles moves (heights directly, abscissae through the
//! slope of the fitted surface and through the residuals), and the rounding of the answer itself.
//! Numbers whose last bits are 0 (integers, halves …) are taken as exact.

use nalgebra::DMatrix;

use crate::{
    design::{Axis, Basis, Design},
    problem::{Evidence, SummaryStatistics},
};
use flankfit_geometry::polynomial::{self, Family};
use flankfit_numerics::{Dd, cancel::Asking, triangular};

/// Standard deviations counted as "may be".
const SIGMAS: f64 = 4.0;
/// Relative standard deviation of rounding to a double, at worst.
const ROUNDING: f64 = f64::EPSILON / 3.4641016151377544;
/// Number of nodes at which the slope of the surface is examined.
const LOOKED_AT: usize = 256;
/// Intervals of the lattice that replaces nodes that are not kept.
const LATTICE: usize = 16;
/// Never claimed more: certified references are printed to 15 digits, and a double holds not quite
/// 16.
const MOST_DIGITS: f64 = 14.5;

/// Up to so many coefficients R is inverted as a whole.
const FEW: usize = 64;

/// Parts of a fit from which its correct digits are estimated.
pub(crate) struct Fitted<'a> {
    pub design: &'a Design,
    pub evidence: Evidence<'a>,
    /// max √w |z|.
    pub largest_height: f64,
    /// R of the working basis.
    pub r: &'a DMatrix<Dd>,
    /// Its factors, where the nodes separate.
    pub axes: Option<[&'a DMatrix<Dd>; 2]>,
    /// Coefficients in the working basis.
    pub working: &'a [Dd],
    /// In the caller's.
    pub coefficients: &'a [f64],
    /// √((XᵀX)⁻¹)ⱼⱼ of each caller's coefficient.
    pub leverage: &'a [f64],
    /// ‖j-th row of (X̃ᵀX̃)⁻¹‖/scale of each caller's coefficient.
    pub sensitivity: &'a [f64],
    /// σ̂.
    pub sigma: Option<f64>,
    pub max_residual: f64,
    /// Relative error left by the arithmetic, and the length of b that it is relative to.
    pub relative_error: f64,
    pub length: f64,
}

/// True if a double is likely to be what was meant, not the rounding of a decimal fraction.
pub(crate) fn exact(x: f64) -> bool {
    x == 0.0 || (x.to_bits() | 1 << 52).trailing_zeros() >= 16
}

/// Largest modulus among numbers that may have been rounded.
fn rounded(values: impl Iterator<Item = f64>) -> f64 {
    values.filter(|x| !exact(*x)).map(f64::abs).fold(0.0, f64::max)
}

/// Correct decimal digits of the worst coefficient.
pub(crate) fn correct_digits(fit: &Fitted) -> f64 {
    let count = fit.evidence.count();
    let any_rounded = match fit.evidence {
        Evidence::Posted { sample, .. } => (0..count).any(|k| !exact(sample.z(k))),
        Evidence::Summed(summary) => summary.rounded_heights,
    };
    let heights = if any_rounded { ROUNDING * fit.largest_height } else { 0.0 };
    let (moved, through_residuals) = abscissae(fit);
    // the working columns move together, by as much as their slopes: ‖row of T⁻¹(WᵀW)⁻¹‖ ≤ leverage
    // · ‖R⁻¹‖
    let spread = if through_residuals > 0.0 && fit.design.domain.is_some() {
        let inverse = |r: &DMatrix<Dd>| triangular::inverse_upper(&r.map(|x| x.to_f64())).norm();
        let norm = match fit.axes {
            // ‖(R_u ⊗ R_v)⁻¹‖ is a product too
            Some([u, v]) if fit.coefficients.len() > FEW => inverse(u) * inverse(v),
            _ => inverse(fit.r),
        };
        (count as f64).sqrt() * norm
    } else {
        0.0
    };
    let mut worst: f64 = 0.0;
    for (j, &value) in fit.coefficients.iter().enumerate() {
        let through = if fit.design.domain.is_some() { fit.leverage[j] * spread } else { fit.sensitivity[j] };
        let error = SIGMAS * fit.leverage[j] * (heights + moved)
            + SIGMAS * through_residuals * through.max(fit.leverage[j])
            + fit.leverage[j] * fit.relative_error * fit.length;
        // a coefficient far below its own uncertainty is 0 for every purpose
        let size = value.abs().max(0.01 * fit.leverage[j] * fit.sigma.unwrap_or(0.0));
        if size > 0.0 {
            worst = worst.max(error / size);
        }
    }
    (-(worst + 0.5 * f64::EPSILON).log10()).clamp(0.0, MOST_DIGITS)
}

/// Standard deviation that rounded abscissae put into a height, and into the projection of the
/// residuals.
fn abscissae(fit: &Fitted) -> (f64, f64) {
    let sample = match fit.evidence {
        Evidence::Posted { sample, .. } => sample,
        Evidence::Summed(summary) => return abscissae_of_sums(fit, summary),
    };
    let count = sample.count();
    let stride = count.div_ceil(LOOKED_AT);
    let looked_at = || (0..count).step_by(stride);
    match &fit.design.basis {
        Basis::Columns { .. } => {
            let mut moved: f64 = 0.0;
            let mut any = false;
            for k in looked_at() {
                let row = sample.matrix_row(k).iter().zip(fit.coefficients).filter(|(x, _)| !exact(**x));
                let square: f64 = row.map(|(x, a)| (x * a).powi(2)).sum();
                any |= square > 0.0;
                moved = moved.max(square.sqrt() * sample.w(k).sqrt());
            }
            (ROUNDING * moved, if any { ROUNDING * fit.max_residual } else { 0.0 })
        }
        Basis::Product { u, v } => {
            let places = || looked_at().map(|k| sample.place(k));
            let (largest_u, largest_v) = (rounded(places().map(|p| p.0)), rounded(places().map(|p| p.1)));
            if largest_u == 0.0 && largest_v == 0.0 {
                return (0.0, 0.0);
            }
            of_product(fit, (u, v), (largest_u, largest_v), places())
        }
    }
}

/// Effect of rounding abscissae as large as `largest`, seen from `places`.
fn of_product(
    fit: &Fitted,
    (u, v): (&Axis, &Axis),
    (largest_u, largest_v): (f64, f64),
    places: impl Iterator<Item = (f64, f64)>,
) -> (f64, f64) {
    let (slope_u, slope_v) = largest_slopes(fit, (u, v), places);
    let moved = (slope_u * largest_u).hypot(slope_v * largest_v);
    // a rational function bends with its denominator too
    let bent = fit.design.rational.as_ref().map_or(1.0, |net| 1.0 + net.spread());
    let bend = bent * (markov(u) * largest_u).hypot(markov(v) * largest_v);
    (ROUNDING * moved, ROUNDING * bend * fit.max_residual)
}

/// The same where the nodes are gone: slopes on a lattice over their box, columns by their largest
/// entries.
fn abscissae_of_sums(fit: &Fitted, summary: &SummaryStatistics) -> (f64, f64) {
    match &fit.design.basis {
        Basis::Columns { .. } => {
            let square: f64 = summary.rounded_columns.iter().zip(fit.coefficients).map(|(x, a)| (x * a).powi(2)).sum();
            (ROUNDING * square.sqrt(), if square > 0.0 { ROUNDING * fit.max_residual } else { 0.0 })
        }
        Basis::Product { u, v } => {
            let [largest_u, largest_v] = summary.rounded_places;
            if largest_u == 0.0 && largest_v == 0.0 {
                return (0.0, 0.0);
            }
            let at = |[low, high]: [f64; 2], i: usize| low + (high - low) * (i as f64 / LATTICE as f64);
            let places = (0..=LATTICE).flat_map(|i| (0..=LATTICE).map(move |j| (i, j)));
            let places = places.map(|(i, j)| (at(summary.bounds[0], i), at(summary.bounds[1], j)));
            of_product(fit, (u, v), (largest_u, largest_v), places)
        }
    }
}

/// Greatest ratio of slope to height of a function on this axis (Markov's inequality).
fn markov(axis: &Axis) -> f64 {
    match axis {
        Axis::Polynomial { mapping, size, .. } => ((size - 1) * (size - 1)) as f64 * mapping.scale,
        Axis::Spline(basis) => {
            let (low, high) = basis.domain();
            let spans = (basis.size() - basis.degree()) as f64;
            (basis.degree() * basis.degree()) as f64 * 2.0 * spans / (high - low)
        }
    }
}

fn largest_slopes(fit: &Fitted, (u, v): (&Axis, &Axis), places: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    let (p, q) = (u.size(), v.size());
    let mut table = DMatrix::zeros(p, q);
    for (&(i, j), c) in fit.design.terms.iter().zip(fit.working) {
        table[(i, j)] = c.to_f64();
    }
    let (mut fu, mut du, mut fv, mut dv) = (vec![0.0; p], vec![0.0; p], vec![0.0; q], vec![0.0; q]);
    let (mut slope_u, mut slope_v) = (0.0f64, 0.0f64);
    for (x, y) in places.asking(100 + 4 * p * q) {
        working_row(u, x, &mut fu, &mut du);
        working_row(v, y, &mut fv, &mut dv);
        let (mut along_u, mut along_v) = (0.0, 0.0);
        if let Some(net) = &fit.design.rational {
            net.slopes([&fu, &du], [&fv, &dv], |column, slope_u, slope_v| {
                along_u += fit.working[column].to_f64() * slope_u;
                along_v += fit.working[column].to_f64() * slope_v;
            });
            slope_u = slope_u.max(f64::abs(along_u));
            slope_v = slope_v.max(f64::abs(along_v));
            continue;
        }
        for j in 0..q {
            for i in 0..p {
                along_u += table[(i, j)] * du[i] * fv[j];
                along_v += table[(i, j)] * fu[i] * dv[j];
            }
        }
        slope_u = slope_u.max(along_u.abs());
        slope_v = slope_v.max(along_v.abs());
    }
    (slope_u, slope_v)
}

/// Values and slopes of the working functions.
fn working_row(axis: &Axis, x: f64, values: &mut [f64], slopes: &mut [f64]) {
    match axis {
        Axis::Polynomial { mapping, .. } => {
            let family = Family::Chebyshev { low: -1.0, high: 1.0 };
            polynomial::values_and_derivatives(family, mapping.map(x), values, slopes);
            slopes.iter_mut().for_each(|slope| *slope *= mapping.scale);
        }
        Axis::Spline(_) => axis.caller_row(x, values, slopes),
    }
}
