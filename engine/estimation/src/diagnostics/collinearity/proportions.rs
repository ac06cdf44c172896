//! Variance-decomposition proportions (Belsley).

use crate::spectrum::Directions;

/// So does a column that owes this share of its coefficient's variance to it, however small its
/// weight (Belsley, Kuh and Welsch): without that column the others would be separated far better.
const SHARE: f64 = 0.5;
/// Squared weight of a column that takes part in an exact dependency.
pub(super) const NUMERICALLY_ZERO: f64 = 1e-12;

/// Shares of the directions in the variance of each unit-length column's coefficient.
pub(super) struct Shares {
    /// `Σᵢ V_ji²/λᵢ` over numerically nonzero directions.
    pub total: Vec<f64>,
    /// True for each coefficient that takes part in an exact dependency.
    pub undetermined: Vec<bool>,
    /// `Σᵢ V_ji²` over the numerically zero directions.
    lost: Vec<f64>,
}

impl Shares {
    pub(super) fn new(unit: &Directions) -> Self {
        let n = unit.v.nrows();
        let (mut total, mut lost, mut undetermined) = (vec![0.0; n], vec![0.0; n], vec![false; n]);
        for (i, &lambda) in unit.lambda.iter().enumerate() {
            for j in 0..n {
                let square = unit.v[(j, i)] * unit.v[(j, i)];
                if lambda > 0.0 {
                    total[j] += square / lambda;
                } else {
                    undetermined[j] |= square > NUMERICALLY_ZERO;
                    lost[j] += square;
                }
            }
        }
        Shares { total, undetermined, lost }
    }

    /// True if term j owes most of its variance to a direction of eigenvalue `lambda` in which it
    /// has the weight `weight`.
    pub(super) fn owes(&self, j: usize, weight: f64, lambda: f64) -> bool {
        let square = weight * weight;
        match (self.undetermined[j], lambda > 0.0) {
            (true, false) => square >= SHARE * self.lost[j],
            (false, true) => square / lambda >= SHARE * self.total[j],
            _ => false,
        }
    }

    /// Per term, one share for each eigenvalue; an exact dependency takes all of it.
    pub(super) fn proportions(&self, unit: &Directions) -> Vec<Vec<f64>> {
        let n = unit.v.nrows();
        let inverse: Vec<f64> = unit.lambda.iter().map(|&l| if l > 0.0 { 1.0 / l } else { 0.0 }).collect();
        let exact: Vec<f64> = unit.lambda.iter().map(|&l| if l > 0.0 { 0.0 } else { 1.0 }).collect();
        (0..n)
            .map(|j| {
                let by = if self.undetermined[j] { &exact } else { &inverse };
                let mut row: Vec<f64> = (0..n).map(|i| unit.v[(j, i)] * unit.v[(j, i)] * by[i]).collect();
                let sum: f64 = row.iter().sum();
                if sum > 0.0 {
                    row.iter_mut().for_each(|share| *share /= sum);
                }
                row
            })
            .collect()
    }
}
