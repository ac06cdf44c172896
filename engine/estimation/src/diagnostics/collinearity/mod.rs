//! Multicollinearity (Eqs. 24–26): which columns of X almost depend on each other, in words that
//! can be acted on.
//!
//! On unit-length columns: eigenvectors of small eigenvalues as weights, condition indices
//! `√(λₙ/λᵢ)` and variance decomposition proportions (Belsley, Kuh and Welsch); on centred columns:
//! correlations and variance inflation.

mod basis;
mod centred;
mod explained;
mod near_dependency;
mod proportions;
mod sentence;

pub(crate) use near_dependency::dependent_terms;

use nalgebra::DMatrix;

use crate::{
    design::Design,
    factor::Factor,
    result::{CollinearityReport, ColumnCollinearity, Warning},
    spectrum::Directions,
};
use basis::Legendre;
use centred::{centred, correlations, lengths};
use flankfit_numerics::Dd;
use near_dependency::near_dependencies;
use proportions::Shares;

/// Up to how many coefficients columns are centred one by one, which is exact to rounding.
const FEW: usize = 64;

/// The report for `caller` (the caller's columns in Q's coordinates) with the spectrum of its
/// unit-length columns.
pub(crate) fn report(
    design: &Design,
    factor: &Factor,
    caller: &DMatrix<Dd>,
    unit: &Directions,
    weight: f64,
    matrices: bool,
    warnings: &mut Vec<Warning>,
) -> CollinearityReport {
    let n = design.size();
    let plain = caller.map(|x| x.to_f64());
    let length = lengths(&plain);
    let centred = centred(design, factor, caller, weight, n > FEW && !matrices);
    let deviation = lengths(&centred.matrix);
    // a column whose spread is lost in rounding is a constant
    let varies = |j: usize| deviation[j] > 1e-13 * length[j];
    let correlation = matrices.then(|| correlations(&centred.matrix, &deviation, varies));
    let shares = Shares::new(unit);
    let mut infinite = Vec::new();
    let columns = (0..n)
        .map(|j| {
            let vif = if Some(j) == design.constant || !varies(j) {
                None
            } else if shares.undetermined[j] {
                infinite.push(design.labels[j].clone());
                None
            } else {
                let own = shares.total[j] / (length[j] * length[j]);
                let joint = centred.beyond.as_ref().map_or(0.0, |(along, rest)| along[j] * along[j] / rest);
                Some((deviation[j] * deviation[j] * (own + joint)).max(1.0))
            };
            ColumnCollinearity { term: design.labels[j].clone(), vif }
        })
        .collect();
    if !infinite.is_empty() {
        warnings.push(Warning::InfiniteInflation { terms: infinite });
    }
    let legendre = Legendre::new(design, factor);
    CollinearityReport {
        basis: legendre.as_ref().map(Legendre::to_result),
        columns,
        correlation,
        variance_proportions: matrices.then(|| shares.proportions(unit)),
        near_dependencies: near_dependencies(design, &plain, &length, unit, &shares, legendre.as_ref(), matrices),
    }
}
