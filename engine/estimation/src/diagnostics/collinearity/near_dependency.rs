//! Near dependencies: small eigenvalues and the terms that share in them.

use std::cmp::Reverse;

use nalgebra::DMatrix;

use super::{
    basis::{Legendre, NEAR},
    explained::{explained, pair_index, unit_columns},
    proportions::{NUMERICALLY_ZERO, Shares},
    sentence::sentence,
};
use crate::{
    design::Design,
    result::{Cause, NearDependency},
    spectrum::Directions,
};

/// A weight this large against the largest one takes part in a dependency.
const LARGE: f64 = 0.3;
/// Greatest number of near dependencies in a report.
const MOST_TOLD: usize = 100;

/// Terms that take part in a direction, the leading one first: those with large weights, and those
/// of which `owes` says so.
fn partners(weights: &[f64], owes: impl Fn(usize) -> bool) -> Vec<usize> {
    let largest = weights.iter().map(|w| w.abs()).fold(0.0, f64::max);
    // moduli have the order of their bits
    let mut terms: Vec<(Reverse<u64>, usize)> = weights
        .iter()
        .map(|w| w.abs())
        .enumerate()
        .filter(|(j, w)| *w >= LARGE * largest || owes(*j))
        .map(|(j, w)| (Reverse(w.to_bits()), j))
        .collect();
    terms.sort_unstable();
    terms.into_iter().map(|(_, j)| j).collect()
}

/// Terms that take part in an exact dependency, the leading one first.
pub(crate) fn dependent_terms(weights: &[f64]) -> Vec<usize> {
    partners(weights, |j| weights[j] * weights[j] > NUMERICALLY_ZERO)
}

pub(super) fn near_dependencies(
    design: &Design,
    plain: &DMatrix<f64>,
    length: &[f64],
    unit: &Directions,
    shares: &Shares,
    legendre: Option<&Legendre>,
    with_weights: bool,
) -> Vec<NearDependency> {
    let largest = unit.largest();
    let (mut found, mut room) = (Vec::new(), Vec::new());
    let (columns, stride) = unit_columns(plain, length);
    for (i, &lambda) in unit.lambda.iter().enumerate().take(MOST_TOLD) {
        let index = (lambda > 0.0).then(|| (largest / lambda).sqrt());
        if index.is_some_and(|index| index <= NEAR) {
            break;
        }
        let rows = unit.v.nrows();
        let weights = unit.v.as_slice()[i * rows..(i + 1) * rows].to_vec();
        let terms = partners(&weights, |j| shares.owes(j, weights[j], lambda));
        let names: Vec<String> = terms.iter().map(|&j| design.labels[j].clone()).collect();
        let (mut cosine, mut weight_ratio, mut r_squared, mut pair) = (None, None, None, None);
        let between =
            |a: usize, b: usize| (plain.column(a).dot(&plain.column(b)) / (length[a] * length[b])).clamp(-1.0, 1.0);
        if let [a, b] = terms[..] {
            cosine = Some(between(a, b));
            weight_ratio = Some(-weights[a].min_by_modulus(weights[b]));
        } else if let [a, b, _, ..] = terms[..] {
            pair = Some(between(a, b)).filter(|cosine| pair_index(*cosine) > NEAR);
            r_squared = Some(explained(&columns, stride, &terms, &mut room));
        }
        let cause = legendre.map_or(Cause::Nodes, |legendre| legendre.cause(unit.image.column(i).as_slice()));
        let consolation = legendre.filter(|_| cause == Cause::Basis).map(Legendre::consolation);
        found.push(NearDependency {
            sentence: sentence(&names, cosine, r_squared, index, pair, consolation),
            cause,
            eigenvalue: lambda,
            condition_index: index,
            weights: with_weights.then_some(weights),
            terms: names,
            cosine,
            weight_ratio,
            r_squared,
        });
    }
    found
}

trait Ratio {
    fn min_by_modulus(self, other: f64) -> f64;
}

impl Ratio for f64 {
    /// The ratio of two weights, the smaller over the larger (Eq. 26).
    fn min_by_modulus(self, other: f64) -> f64 {
        if self.abs() <= other.abs() { self / other } else { other / self }
    }
}
