//! The orthogonal factor of the working matrix: `√Ω W = Q R`, `b = Qᵀ√Ω z`, so that `R c = b` gives
//! the least-squares coefficients in the working basis.
//!
//! Three ways lead here, chosen by what the nodes allow and by an error estimate, never by a
//! caller:
//! * a full grid separates, `W = W_u ⊗ W_v`: each axis has a small QR of its own, in double-double,
//!   and the heights are read once ([`super::separable`]);
//! * else normal equations in the well-conditioned working basis, then corrections `c += (RᵀR)⁻¹
//!   Wᵀ(z − Wc)` whose residuals are formed in double-double, which converge to the exact
//!   least-squares solution as long as ε κ(W)² ≪ 1;
//! * else (near-dependent columns, rank deficiency) a Householder QR in double-double, block by
//!   block.

use nalgebra::{DMatrix, DVector};

use super::{
    normal_equations::normal_equations,
    residual_pass::{Precision, Wanted, projection_error, residual_pass},
    separable::Separable,
};
use crate::{
    data::Sample,
    design::{Design, Row},
    error::FitError,
    result::Arithmetic,
};
use flankfit_numerics::{
    Dd, Real,
    cancel::{self, Asking},
    check::Faults,
    qr, triangular,
};

/// Relative error of R that the fast path may have: it is the relative error of every singular
/// value.
const TOLERANCE: f64 = 1e-11;
/// Nodes taken into the double-double QR at a time.
const BLOCK: usize = 512;
/// Products `nodes × coefficients` up to which double-double residuals cost next to nothing.
const CHEAP: usize = 2_000;

/// R, b and what is known of them.
pub(crate) struct Factor {
    /// n×n upper triangular, of the working matrix.
    pub r: DMatrix<Dd>,
    /// T, the change of basis to the caller's columns.
    pub change: DMatrix<Dd>,
    /// Qᵀ√Ωz.
    pub qty: Vec<Dd>,
    /// Least-squares coefficients in the working basis; `None` when R is singular.
    pub working: Option<Vec<Dd>>,
    /// `Σ w W`, by column; where known.
    pub ones: Option<Vec<f64>>,
    pub arithmetic: Arithmetic,
    /// Relative error left in `working` (norm-wise, columns of unit length).
    pub relative_error: f64,
    /// `Σ w r²` and `max |r|` of the least-squares residuals, where R is not singular.
    pub rss: f64,
    /// `None` where the nodes are gone.
    pub max_abs: Option<f64>,
    /// The two axes, where they separate.
    pub separable: Option<Separable>,
    /// Rounding that R may carry, in units of one factorisation's: 1 for nodes taken at once.
    pub rounded: f64,
}

/// Error for squares above the range of double.
pub(crate) fn squares_exceed_double() -> Faults {
    let message =
        "powers or squares of these numbers exceed the range of double precision: choose another unit or basis";
    Faults::one("nodes", message)
}

impl Factor {
    /// Factors the working matrix of `design` on the counted nodes.
    pub(crate) fn new(design: &Design, sample: &Sample) -> Result<Self, FitError> {
        let change = design.change_of_basis();
        let factor = by_normal_equations(design, sample, &change).unwrap_or_else(|| by_qr(design, sample, change));
        factor.finite()
    }

    /// Itself, unless numbers in it left the range of double precision.
    pub(crate) fn finite(self) -> Result<Self, FitError> {
        if self.r.as_slice().iter().chain(&self.qty).chain(self.change.as_slice()).all(|x| x.is_finite()) {
            Ok(self)
        } else {
            Err(FitError::ExceedsDouble(squares_exceed_double()))
        }
    }

    /// The factor of a full grid from the product `r` of its axes' factors.
    pub(crate) fn of_axes(r: DMatrix<Dd>, change: DMatrix<Dd>, separable: Separable) -> Self {
        let qty = separable.qty.clone();
        let mut working = qty.clone();
        triangular::solve_upper(&r, &mut working);
        Factor {
            r,
            change,
            qty,
            working: Some(working),
            ones: None,
            arithmetic: Arithmetic::DoubleDouble,
            relative_error: separable.relative_error,
            rss: separable.rss,
            max_abs: Some(separable.max_abs),
            separable: Some(separable),
            rounded: 1.0,
        }
    }

    /// The same with other coefficients.
    pub(crate) fn with_working(&self, working: Vec<Dd>) -> Self {
        let mut qty = working.clone();
        multiply_upper_vector(&self.r, &mut qty);
        Factor {
            r: self.r.clone(),
            change: self.change.clone(),
            qty,
            working: Some(working),
            ones: self.ones.clone(),
            arithmetic: self.arithmetic,
            relative_error: self.relative_error,
            rss: self.rss,
            max_abs: self.max_abs,
            separable: None,
            rounded: self.rounded,
        }
    }

    /// n.
    pub(crate) fn size(&self) -> usize {
        self.qty.len()
    }
}

/// Amplification of errors of the working coefficients in the caller's: `max_j (|T⁻¹|
/// |c|)_j / |(T⁻¹c)_j|`.
pub(super) fn amplification(change: &DMatrix<Dd>, working: &[Dd]) -> f64 {
    let inverse = triangular::inverse_upper(change);
    let n = working.len();
    let mut worst: f64 = 1.0;
    let largest = working.iter().map(|c| c.to_f64().abs()).fold(0.0, f64::max);
    for j in (0..n).asking(20 * n) {
        let (mut sum, mut spread) = (Dd::ZERO, 0.0);
        for i in j..n {
            sum += inverse[(j, i)] * working[i];
            // an error of one coefficient is relative to the largest of them
            spread += inverse[(j, i)].to_f64().abs() * largest;
        }
        if spread > 0.0 {
            worst = worst.max(spread / sum.to_f64().abs().max(spread * 1e-30));
        }
    }
    worst
}

fn by_normal_equations(design: &Design, sample: &Sample, change: &DMatrix<Dd>) -> Option<Factor> {
    let normal = normal_equations(design, sample);
    let n = design.size();
    let length: Vec<f64> = (0..n).map(|j| normal.gram[(j, j)].sqrt()).collect();
    if length.iter().any(|d| !(*d > 0.0 && d.is_finite())) {
        return None;
    }
    let scaled = DMatrix::from_fn(n, n, |i, j| normal.gram[(i, j)] / (length[i] * length[j]));
    let unit = triangular::cholesky(&scaled)?;
    let condition = unit.norm() * triangular::inverse_upper(&unit).norm();
    let contraction = 8.0 * f64::EPSILON * condition * condition / n as f64;
    if contraction.is_nan() || contraction > TOLERANCE {
        return None;
    }
    let solve = |projected: &mut [f64]| {
        projected.iter_mut().zip(&length).for_each(|(x, d)| *x /= d);
        triangular::solve_upper_transposed(&unit, projected);
        triangular::solve_upper(&unit, projected);
        projected.iter_mut().zip(&length).for_each(|(x, d)| *x /= d);
    };
    let norm =
        |values: &mut dyn Iterator<Item = f64>| values.zip(&length).map(|(x, d)| (x * d) * (x * d)).sum::<f64>().sqrt();
    let mut step = normal.rhs.clone();
    solve(&mut step);
    let mut working: Vec<Dd> = step.iter().map(|&c| Dd::from(c)).collect();
    let amplified = amplification(change, &working);
    let precision = if amplified > 10.0 || sample.count() * n <= CHEAP || n < 4 {
        Precision::DoubleDouble
    } else {
        Precision::Double
    };
    let r = DMatrix::from_fn(n, n, |i, j| Dd::from(unit[(i, j)]) * length[j]);
    let (mut rss, mut max_abs, mut relative_error) = (0.0, 0.0, f64::EPSILON);
    for round in 0..6 {
        cancel::checkpoint();
        let pass = residual_pass(design, sample, &working, precision, Wanted::Projection);
        step = pass.projected.iter().map(|x| x.to_f64()).collect();
        solve(&mut step);
        working.iter_mut().zip(&step).for_each(|(c, d)| *c += *d);
        // ‖z − W(c + d)‖² = ‖z − Wc‖² − ‖Rd‖² at the least-squares solution
        let gain: f64 =
            (0..n).map(|i| (i..n).map(|j| unit[(i, j)] * length[j] * step[j]).sum::<f64>()).map(|x| x * x).sum();
        rss = (pass.rss - Dd::from(gain)).to_f64().max(0.0);
        max_abs = pass.max_abs;
        let size = norm(&mut working.iter().map(|c| c.to_f64()));
        let moved = norm(&mut step.iter().copied());
        if size == 0.0 || moved == 0.0 {
            relative_error = f64::EPSILON * f64::EPSILON;
            break;
        }
        let left = moved / size * contraction.max(1e-15);
        let floor = match precision {
            Precision::Double => f64::EPSILON * condition / (n as f64).sqrt(),
            Precision::DoubleDouble => {
                projection_error(sample.count(), rss.sqrt(), size) + 1e-30 * condition * condition
            }
        };
        relative_error = left.max(floor);
        if precision == Precision::Double || left <= floor || left * amplified <= 1e-18 || round == 5 {
            break;
        }
    }
    let mut qty = working.clone();
    multiply_upper_vector(&r, &mut qty);
    Some(Factor {
        r,
        change: change.clone(),
        qty,
        working: Some(working),
        ones: Some(normal.ones),
        arithmetic: if precision == Precision::Double { Arithmetic::Double } else { Arithmetic::DoubleDouble },
        relative_error,
        rss,
        max_abs: Some(max_abs),
        separable: None,
        rounded: 1.0,
    })
}

/// `x := R x` for upper triangular R.
pub(crate) fn multiply_upper_vector<T: Real>(r: &DMatrix<T>, x: &mut [T]) {
    for i in 0..x.len() {
        let mut sum = T::of(0.0);
        for j in i..x.len() {
            sum += r[(i, j)] * x[j];
        }
        x[i] = sum;
    }
}

fn by_qr(design: &Design, sample: &Sample, change: DMatrix<Dd>) -> Factor {
    let n = design.size();
    let mut r = DMatrix::from_element(n, n, Dd::ZERO);
    let mut qty = vec![Dd::ZERO; n];
    let mut rss = Dd::ZERO;
    let mut row = Row::<Dd>::new(design);
    let mut start = 0;
    let mut ones = vec![0.0; n];
    while start < sample.count() {
        cancel::checkpoint();
        let block = (sample.count() - start).min(BLOCK.max(n));
        let above = if start == 0 { 0 } else { n };
        let mut a = DMatrix::from_element(above + block, n, Dd::ZERO);
        let mut y = DVector::from_element(above + block, Dd::ZERO);
        for i in 0..above {
            for j in i..n {
                a[(i, j)] = r[(i, j)];
            }
            y[i] = qty[i];
        }
        for i in (0..block).asking(100 * n) {
            let k = start + i;
            row.at(design, sample, k);
            let weight = sample.w(k);
            let root = if weight == 1.0 { Dd::ONE } else { Dd::from(weight).sqrt() };
            for (&j, &x) in row.index.iter().zip(&row.values) {
                a[(above + i, j)] = x * root;
                ones[j] += weight * sample.one(k) * x.to_f64();
            }
            y[above + i] = root * sample.height::<Dd>(k);
        }
        let step = qr::qr_with_rhs(a, y);
        r = step.r;
        qty = step.qty.iter().copied().collect();
        rss += step.rss;
        start += block;
    }
    let mut factor = Factor {
        r,
        change,
        qty,
        working: None,
        ones: Some(ones),
        arithmetic: Arithmetic::DoubleDouble,
        relative_error: f64::EPSILON,
        rss: rss.to_f64(),
        max_abs: Some(0.0),
        separable: None,
        rounded: 1.0,
    };
    polish(&mut factor, design, sample);
    factor
}

/// Lengths of the columns of R and a bound on its condition once they are divided by them; `None`
/// if R is singular within double-double.
pub(crate) fn scaled_condition(r: &DMatrix<Dd>) -> Option<(Vec<f64>, f64)> {
    let n = r.ncols();
    let length: Vec<f64> = (0..n).map(|j| r.column(j).iter().map(|x| x.to_f64().powi(2)).sum::<f64>().sqrt()).collect();
    if !(0..n).all(|i| r[(i, i)].to_f64().abs() > 1e-27 * length[i]) {
        return None;
    }
    let inverse = triangular::inverse_upper(r);
    let condition = (0..n)
        .flat_map(|i| (i..n).map(move |j| (i, j)))
        .map(|(i, j)| (inverse[(i, j)].to_f64() * length[i]).powi(2))
        .sum::<f64>()
        .sqrt()
        * (n as f64).sqrt();
    (condition < 1e27).then_some((length, condition))
}

/// Solves `R c = b` where R is not singular and corrects `c` by residuals formed in double-double.
fn polish(factor: &mut Factor, design: &Design, sample: &Sample) {
    let Some((length, condition)) = scaled_condition(&factor.r) else { return };
    let mut working = factor.qty.clone();
    triangular::solve_upper(&factor.r, &mut working);
    let norm = |values: &[Dd]| values.iter().zip(&length).map(|(x, d)| (x.to_f64() * d).powi(2)).sum::<f64>().sqrt();
    let mut last = f64::INFINITY;
    factor.relative_error = (1e-31 * condition * condition).min(1.0);
    for _ in 0..4 {
        cancel::checkpoint();
        let pass = residual_pass(design, sample, &working, Precision::DoubleDouble, Wanted::Projection);
        factor.rss = pass.rss.to_f64();
        factor.max_abs = Some(pass.max_abs);
        let mut step = pass.projected;
        triangular::solve_upper_transposed(&factor.r, &mut step);
        triangular::solve_upper(&factor.r, &mut step);
        let (moved, size) = (norm(&step), norm(&working));
        // stop where corrections are as large as what rounding puts into them
        if moved.is_nan() || moved >= 0.1 * last || moved <= 1e-28 * size {
            factor.relative_error = (if size > 0.0 { moved / size } else { 0.0 }).clamp(1e-30, 1.0);
            break;
        }
        last = moved;
        working.iter_mut().zip(&step).for_each(|(c, d)| *c += *d);
        factor.relative_error = (moved / size * 1e-10).max(1e-30);
    }
    factor.qty = working.clone();
    multiply_upper_vector(&factor.r, &mut factor.qty);
    factor.working = Some(working);
}
