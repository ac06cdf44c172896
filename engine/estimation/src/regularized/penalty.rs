//! The roughness penalty `P(A) = ‖L c‖²` as a factor L in the working basis, where it is neither
//! large nor small.
//!
//! On one axis `∫ φᵢ⁽ᵏ⁾ φⱼ⁽ᵏ⁾ dx` is `DᵀD`, the rows of D being the derivatives at Gauss points
//! times the roots of the weights: exact for polynomials and, span by span, for B-splines, and
//! never squared. On a surface the two terms are `D_u ⊗ M_v` and `M_u ⊗ D_v`, M being the factor of
//! order 0. Integrals run over the domain of the fit; those of B-splines over the span of their
//! knots, all of which the functions live on.

use nalgebra::{DMatrix, DVector};

use super::{context::Context, rational_penalty};
use crate::{
    design::{Axis, Basis, Design},
    error::FitError,
    spec::{HIGHEST_ORDER, Scaling, Tikhonov},
};
use flankfit_geometry::{WeightNet, polynomial};
use flankfit_numerics::{
    Dd, Real,
    check::Faults,
    qr,
    quadrature::gauss_legendre,
    words::{Shown, counted},
};

/// Entries of L are squared.
const RANGE: std::ops::Range<f64> = 1e-140..1e140;

/// Refuses a penalty that the model has no roughness for; of `size` scaled columns.
pub(super) fn check(asked: &Tikhonov, design: &Design, scaling: Scaling, size: usize) -> Result<(), Faults> {
    let order = asked.order;
    if order > HIGHEST_ORDER {
        return Err(Faults::one("regularization.order", format_args!("{order} is not one of 0 to {HIGHEST_ORDER}")));
    }
    let weights = weights(asked, design);
    check_weights(&weights, is_surface(design))?;
    match &design.basis {
        Basis::Columns { .. } if order >= size => Err(Faults::one(
            "regularization.order",
            format_args!(
                "differences of order {order} need at least {} coefficients; there {}",
                order + 1,
                if size == 1 { "is 1".to_owned() } else { format!("are {size}") }
            ),
        )),
        Basis::Columns { .. } => Ok(()),
        Basis::Product { .. } if order == 0 && scaling == Scaling::Standardized => Err(Faults::one(
            "regularization.order",
            "order 0 penalises the constant, which `standardized` leaves unpenalised: use another scaling or order",
        )),
        Basis::Product { u, v } => {
            let varies = design.rational.as_ref().map_or([false; 2], WeightNet::varies);
            let rough = |(axis, rational): (&Axis, bool)| match degree(axis) {
                0 => order == 0,
                // quotients have derivatives of every order
                degree => degree >= order || rational,
            };
            if [u, v].into_iter().zip(varies).zip(&weights).any(|(axis, weight)| *weight > 0.0 && rough(axis)) {
                return Ok(());
            }
            Err(Faults::one(
                "regularization.order",
                format_args!(
                    "derivatives of order {order} vanish for every function of this model: nothing would be penalised"
                ),
            ))
        }
    }
}

fn degree(axis: &Axis) -> usize {
    match axis {
        Axis::Polynomial { size, .. } => size.saturating_sub(1),
        Axis::Spline(basis) => basis.degree(),
    }
}

/// L: as many columns as working coefficients.
pub(super) enum Penalty {
    Whole(DMatrix<Dd>),
    /// `√w D_u ⊗ D_v` of every block, below each other, in the products of all functions.
    Product(Vec<(f64, DMatrix<Dd>, DMatrix<Dd>)>),
}

impl Penalty {
    /// L as a matrix, its columns being `terms`.
    pub(super) fn stacked(&self, terms: &[(usize, usize)]) -> DMatrix<Dd> {
        match self {
            Penalty::Whole(l) => l.clone(),
            Penalty::Product(blocks) => stack(blocks, terms),
        }
    }

    fn largest(&self) -> f64 {
        let of = |matrix: &DMatrix<Dd>| {
            let larger = |a: f64, x: f64| if x > a || x.is_nan() { x } else { a };
            matrix.iter().map(|x| x.to_f64().abs()).fold(0.0, larger)
        };
        match self {
            Penalty::Whole(l) => of(l),
            Penalty::Product(blocks) => {
                let each = blocks.iter().map(|(w, u, v)| w.sqrt() * of(u) * of(v));
                each.fold(0.0, |a: f64, x| if x > a || x.is_nan() { x } else { a })
            }
        }
    }
}

/// The penalty of `asked`, which has been checked.
pub(super) fn factor(context: &Context, asked: &Tikhonov) -> Result<Penalty, FitError> {
    let design = context.linear.design;
    let order = asked.order;
    let weights = weights(asked, design);
    let penalty = match &design.basis {
        Basis::Columns { scale } => {
            Penalty::Whole(differences(&context.columns.kept, scale, order, weights.iter().sum()))
        }
        Basis::Product { u, v } if let Some(net) = &design.rational => {
            Penalty::Whole(rational_penalty::factor([u, v], net, &weights, order))
        }
        Basis::Product { u, v } => {
            let domain = design.domain.unwrap_or_default();
            let (on_u, on_v) = (domain.u.unwrap_or([0.0; 2]), domain.v);
            let (mass_u, mass_v) = (axis(u, Some(on_u), 0), axis(v, on_v, 0));
            let mut blocks = Vec::new();
            if order == 0 {
                blocks.push((weights.iter().sum::<f64>(), mass_u, mass_v));
            } else {
                if weights[0] > 0.0 {
                    blocks.push((weights[0], axis(u, Some(on_u), order), mass_v));
                }
                if let Some(&weight) = weights.get(1).filter(|w| **w > 0.0) {
                    blocks.push((weight, mass_u, axis(v, on_v, order)));
                }
            }
            if design.is_full_product() {
                Penalty::Product(blocks)
            } else {
                Penalty::Whole(stack(&blocks, &design.terms))
            }
        }
    };
    if !RANGE.contains(&penalty.largest()) {
        let message =
            "the square of this penalty exceeds the range of double precision: choose other weights or another unit";
        return Err(FitError::ExceedsDouble(Faults::one("regularization.weights", message)));
    }
    Ok(penalty)
}

fn is_surface(design: &Design) -> bool {
    design.domain.is_some_and(|domain| domain.v.is_some())
}

/// The weights, by default 1 for each axis.
fn weights(asked: &Tikhonov, design: &Design) -> Vec<f64> {
    asked.weights.clone().unwrap_or_else(|| vec![1.0; if is_surface(design) { 2 } else { 1 }])
}

/// One for each axis, none negative, one positive.
fn check_weights(weights: &[f64], surface: bool) -> Result<(), Faults> {
    if weights.len() != if surface { 2 } else { 1 } {
        return Err(Faults::one(
            "regularization.weights",
            format_args!(
                "{}; {}",
                counted(weights.len(), "weight", "weights"),
                if surface { "a surface takes two, [w_u, w_v]" } else { "a curve or a linear model takes one" }
            ),
        ));
    }
    let mut faults = Faults::default();
    for (i, weight) in weights.iter().enumerate().filter(|(_, w)| **w < 0.0 || !w.is_finite()) {
        faults.push(
            format_args!("regularization.weights[{i}]"),
            format_args!("{} is negative or not finite", Shown(*weight)),
        );
    }
    if weights.iter().all(|w| *w == 0.0) {
        faults.push("regularization.weights", "at least one weight must be greater than 0");
    }
    faults.into_result(())
}

/// `√w Δᵏ` on the caller's coefficients of the kept columns, in working coefficients (which are
/// `scale` times those).
fn differences(kept: &[usize], scale: &[f64], order: usize, weight: f64) -> DMatrix<Dd> {
    let mut signs = vec![1.0];
    for _ in 0..order {
        let next = |i: usize| if i == 0 { 0.0 } else { signs[i - 1] } - signs.get(i).copied().unwrap_or(0.0);
        signs = (0..=signs.len()).map(next).collect();
    }
    let root = Dd::from(weight).sqrt();
    let mut l = DMatrix::from_element(kept.len().saturating_sub(order), scale.len(), Dd::ZERO);
    for row in 0..l.nrows() {
        for (i, sign) in signs.iter().enumerate() {
            let j = kept[row + i];
            l[(row, j)] = root.mul_f64(*sign) / scale[j];
        }
    }
    l
}

/// A square factor of `∫ φ⁽ᵏ⁾ φ⁽ᵏ⁾ᵀ dx` on one axis; without a domain the axis is the single
/// function 1 of a curve.
fn axis(axis: &Axis, domain: Option<[f64; 2]>, order: usize) -> DMatrix<Dd> {
    let n = axis.size();
    let Some([low, high]) = domain else { return DMatrix::from_element(1, 1, Dd::ONE) };
    let rows = match axis {
        Axis::Polynomial { mapping, .. } => {
            let (half, middle) = halves(low, high);
            let rule = gauss_legendre(n);
            let mut rows = DMatrix::from_element(n, n, Dd::ZERO);
            let mut values = vec![Dd::ZERO; n];
            let chain = Dd::from(mapping.scale).powi(order as i32);
            for (q, &(node, weight)) in rule.iter().enumerate() {
                let x = middle + half * node;
                polynomial::chebyshev_derivatives(order, (x - Dd::from(mapping.center)) * mapping.scale, &mut values);
                let root = (weight * half).sqrt() * chain;
                values.iter().enumerate().for_each(|(j, &value)| rows[(q, j)] = value * root);
            }
            rows
        }
        Axis::Spline(basis) => {
            let p = basis.degree();
            let knots = &basis.knots()[p..=basis.size()];
            let spans: Vec<[f64; 2]> =
                knots.windows(2).filter(|pair| pair[0] < pair[1]).map(|pair| [pair[0], pair[1]]).collect();
            let rule = gauss_legendre(p + 1);
            let mut rows = DMatrix::from_element(spans.len() * (p + 1), n, Dd::ZERO);
            let mut values = vec![Dd::ZERO; p + 1];
            for (s, &[low, high]) in spans.iter().enumerate() {
                let (half, middle) = halves(low, high);
                for (q, &(node, weight)) in rule.iter().enumerate() {
                    // the place rounded to a double, inside the span: the rule moves by less than a
                    // part in 10¹⁵
                    let x = (middle + half * node).to_f64().clamp(low, high);
                    let first = basis.derivatives_of(order, x, &mut values);
                    let root = (weight * half).sqrt();
                    values.iter().enumerate().for_each(|(i, &v)| rows[(s * (p + 1) + q, first + i)] = v * root);
                }
            }
            rows
        }
    };
    if rows.nrows() <= n { rows } else { triangular(rows) }
}

fn halves(low: f64, high: f64) -> (Dd, Dd) {
    let half = Dd::diff(high, low).mul_f64(0.5);
    (half, Dd::sum(low, high).mul_f64(0.5))
}

/// The triangular factor of a tall matrix.
pub(super) fn triangular(rows: DMatrix<Dd>) -> DMatrix<Dd> {
    let height = rows.nrows();
    qr::qr_with_rhs(rows, DVector::from_element(height, Dd::ZERO)).r
}

/// `√w D_u ⊗ D_v` of every block, below each other, in the columns of `terms`.
fn stack(blocks: &[(f64, DMatrix<Dd>, DMatrix<Dd>)], terms: &[(usize, usize)]) -> DMatrix<Dd> {
    let heights: usize = blocks.iter().map(|(_, u, v)| u.nrows() * v.nrows()).sum();
    let mut l = DMatrix::from_element(heights, terms.len(), Dd::ZERO);
    let mut row = 0;
    for (weight, u, v) in blocks {
        let root = Dd::from(*weight).sqrt();
        for a in 0..u.nrows() {
            for b in 0..v.nrows() {
                for (column, &(i, j)) in terms.iter().enumerate() {
                    l[(row, column)] = root * u[(a, i)] * v[(b, j)];
                }
                row += 1;
            }
        }
    }
    l
}
