//! Effect of filters on the columns of X: condition, correlation and variance inflation before and
//! after.
//!
//! A linear filter S turns `Y = X A + R` into `S Y = (S X) A + S R`. The fit is that of the model
//! to the filtered heights at the nodes, hence with X. Whether the smoothed nodes still separate
//! the coefficients is seen in `S X`; the paper warns of this. So the results after filtering are
//! those of S X, S being all steps in order with their decisions (peaks, robustness weights) as
//! taken on the heights; a removed node is a row less. X holds the functions over the box of the
//! posted nodes.
//!
//! S is applied to the well-conditioned working basis W, and the caller's columns follow from `S X
//! = (S W) T`: an error of S W's triangular factor then is a *relative* one of every singular
//! value, also of the smallest.

use nalgebra::{DMatrix, DVector};

use super::steps::Step;
use crate::{
    data::{Nodes, Sample},
    design::{Axis, Basis, Design, Row},
    diagnostics::collinearity,
    error::FitError,
    factor::Factor,
    result::{Arithmetic, ColumnResults, Warning},
    spec::{FilterAxis, FitSpec, Scaling},
    spectrum::{Directions, ScaledColumns, caller_columns},
};
use flankfit_numerics::{Dd, cancel::Asking, jacobi, qr};

/// Products of a weight and a number that filtering columns may take, and numbers that columns may
/// hold.
const MOST_PRODUCTS: usize = 2_000_000_000;
const MOST_NUMBERS: usize = 20_000_000;
/// Condition of the filtered working basis from which on double precision cannot vouch for what is
/// left of it.
const DEGENERATE: f64 = 1e11;

/// Figures before and after; what cannot be given is left out, with a warning.
pub(super) fn compare(
    nodes: &Nodes,
    filtered: &Nodes,
    steps: &[Step],
    spec: &FitSpec,
    warnings: &mut Vec<Warning>,
) -> Result<[ColumnResults; 2], FitError> {
    let sample = Sample::new(nodes);
    let design = Design::new(nodes, &sample, spec)?;
    let weight = |sample: &Sample| (0..sample.count()).map(|k| sample.w(k)).sum::<f64>();
    let before = figures(&design, &Factor::new(&design, &sample)?, sample.count(), weight(&sample))?;
    let kept = Sample::new(filtered);
    let counted = ColumnResults { nodes: kept.count(), ..ColumnResults::default() };
    let r = if steps.iter().all(|step| matches!(step, Step::Removed)) {
        Factored::Plain(Box::new(Factor::new(&design, &kept)?))
    } else {
        match along_axes(nodes, &sample, &design, steps) {
            Some(factored) => factored,
            None => everywhere(nodes, &sample, &kept, &design, steps),
        }
    };
    let after = match r {
        Factored::Plain(factor) => figures(&design, &factor, kept.count(), weight(&kept))?,
        Factored::Degenerate => {
            warnings.push(Warning::FilteredColumnsDependent);
            counted
        }
        Factored::TooMuch => {
            warnings.push(Warning::FilteredColumnsNotExamined);
            counted
        }
    };
    if let (Some(low), Some(high)) = (before.condition, after.condition)
        && high > 2.0 * low
    {
        warnings.push(Warning::FilteringRaisesCollinearity { condition_before: low, condition_after: high });
    }
    Ok([before, after])
}

/// R of the filtered working basis, where there is one.
enum Factored {
    Plain(Box<Factor>),
    Degenerate,
    TooMuch,
}

fn factored(design: &Design, r: DMatrix<Dd>, ones: Vec<f64>) -> Factored {
    let n = r.ncols();
    let lengths: Vec<f64> = r.column_iter().map(|c| c.iter().map(|x| x.to_f64().powi(2)).sum::<f64>().sqrt()).collect();
    let unit = DMatrix::from_fn(n, n, |i, j| r[(i, j)].to_f64() / if lengths[j] > 0.0 { lengths[j] } else { 1.0 });
    let sound = lengths.iter().all(|length| length.is_finite())
        && jacobi::svd(unit).is_some_and(|svd| svd.sigma[0] * DEGENERATE > svd.sigma[n - 1]);
    if !sound {
        return Factored::Degenerate;
    }
    Factored::Plain(Box::new(factor_of(design, r, ones)))
}

/// A full grid without weights whose filters are the same on every line: `S W = S_u W_u ⊗ S_v W_v`.
fn along_axes(nodes: &Nodes, sample: &Sample, design: &Design, steps: &[Step]) -> Option<Factored> {
    let (Nodes::Grid(grid), Basis::Product { u, v }, true) = (nodes, &design.basis, sample.separates()) else {
        return None;
    };
    if design.rational.is_some() {
        return None;
    }
    let single: Vec<(FilterAxis, Step)> = steps.iter().map(Step::along_axis).collect::<Option<_>>()?;
    let factor = |axis: &Axis, x: &[f64], which: FilterAxis| {
        let mut columns = vec![vec![0.0; x.len()]; axis.size()];
        let mut row = vec![0.0; axis.size()];
        for (i, &x) in x.iter().enumerate() {
            axis.row(x, &mut row);
            columns.iter_mut().zip(&row).for_each(|(column, value)| column[i] = *value);
        }
        single.iter().filter(|(axis, _)| *axis == which).for_each(|(_, step)| step.apply(&mut columns));
        let sums: Vec<f64> = columns.iter().map(|column| column.iter().sum()).collect();
        (triangularised(x.len(), &columns), sums)
    };
    let ((ru, ones_u), (rv, ones_v)) = (factor(u, &grid.u, FilterAxis::U), factor(v, &grid.v, FilterAxis::V));
    let n = design.size();
    let (p, q) = (u.size(), v.size());
    let entry = |row: usize, column: usize| {
        let (i, j) = design.terms[column];
        ru[(row / q, i)] * rv[(row % q, j)]
    };
    let r = if design.is_full_product() {
        DMatrix::from_fn(n, n, entry)
    } else {
        qr::qr_with_rhs(DMatrix::from_fn(p * q, n, entry), DVector::zeros(p * q)).r
    };
    let ones = design.terms.iter().map(|&(i, j)| ones_u[i] * ones_v[j]).collect();
    Some(factored(design, r.map(Dd::from), ones))
}

/// Any nodes: every working column is filtered as the heights were.
fn everywhere(nodes: &Nodes, sample: &Sample, kept: &Sample, design: &Design, steps: &[Step]) -> Factored {
    let (n, posted) = (design.size(), nodes.posted());
    let products = steps.iter().fold(0usize, |sum, step| sum.saturating_add(step.products()));
    if n.saturating_mul(posted) > MOST_NUMBERS || n.saturating_mul(products) > MOST_PRODUCTS {
        return Factored::TooMuch;
    }
    let mut columns = vec![vec![0.0; posted]; n];
    let mut row = Row::<f64>::new(design);
    for k in (0..sample.count()).asking(20 * n) {
        row.at(design, sample, k);
        row.index.iter().zip(&row.values).for_each(|(&j, &x)| columns[j][sample.posted(k)] = x);
    }
    steps.iter().for_each(|step| step.apply(&mut columns));
    let mut ones = vec![0.0; n];
    let rows: Vec<Vec<f64>> = columns
        .iter()
        .zip(&mut ones)
        .asking(10 * kept.count())
        .map(|(column, sum)| {
            (0..kept.count())
                .map(|k| {
                    let (value, weight) = (column[kept.posted(k)], kept.w(k));
                    *sum += weight * value;
                    weight.sqrt() * value
                })
                .collect()
        })
        .collect();
    let r = match design.basis {
        Basis::Product { .. } => triangularised(kept.count(), &rows).map(Dd::from),
        // posted columns may be nearly parallel themselves
        Basis::Columns { .. } => {
            let m = kept.count();
            qr::qr_with_rhs(DMatrix::from_fn(m, n, |i, j| Dd::from(rows[j][i])), DVector::from_element(m, Dd::ZERO)).r
        }
    };
    match design.basis {
        Basis::Product { .. } => factored(design, r, ones),
        Basis::Columns { .. } => Factored::Plain(Box::new(factor_of(design, r, ones))),
    }
}

/// A factor without heights.
fn factor_of(design: &Design, r: DMatrix<Dd>, ones: Vec<f64>) -> Factor {
    let n = r.ncols();
    let regular = (0..n).all(|i| r[(i, i)] != Dd::ZERO);
    Factor {
        change: design.change_of_basis(),
        qty: vec![Dd::ZERO; n],
        working: regular.then(|| vec![Dd::ZERO; n]),
        ones: Some(ones),
        arithmetic: Arithmetic::DoubleDouble,
        relative_error: f64::EPSILON,
        rss: 0.0,
        max_abs: Some(0.0),
        separable: None,
        rounded: 1.0,
        r,
    }
}

fn triangularised(m: usize, columns: &[Vec<f64>]) -> DMatrix<f64> {
    let matrix = DMatrix::from_fn(m, columns.len(), |i, j| columns[j][i]);
    qr::qr_with_rhs(matrix, DVector::zeros(m)).r
}

/// Condition on columns of unit length, largest correlation and largest variance inflation.
fn figures(design: &Design, factor: &Factor, nodes: usize, weight: f64) -> Result<ColumnResults, FitError> {
    let caller = caller_columns(factor);
    let columns = ScaledColumns::new(design, &caller, Scaling::UnitLength, weight)?;
    let spectrum = Directions::new(factor, &columns, Scaling::UnitLength, None)?;
    let report = collinearity::report(design, factor, &caller, &spectrum, weight, true, &mut Vec::new());
    let finite = |value: f64| Some(value).filter(|value| value.is_finite());
    // a constant has no correlation with any other column
    let varying: Vec<usize> = (0..design.size()).filter(|j| Some(*j) != design.constant).collect();
    let largest = report.correlation.as_ref().and_then(|rows| {
        let pairs = varying.iter().flat_map(|&i| varying.iter().filter(move |&&j| j < i).map(move |&j| (i, j)));
        pairs.map(|(i, j)| rows[i][j].abs()).reduce(f64::max)
    });
    Ok(ColumnResults {
        nodes,
        condition: spectrum.full_rank().then(|| spectrum.largest() / spectrum.lambda[0]).and_then(finite),
        largest_correlation: largest.and_then(finite),
        largest_vif: report.columns.iter().filter_map(|column| column.vif).reduce(f64::max).and_then(finite),
    })
}
