//! The elastic net by coordinate descent (Friedman, Hastie and Tibshirani, Journal of Statistical
//! Software 33, 2010): `min ½ mean(w r²) + λ(α Σ|a| + ½(1 − α) Σa²)` in columns of unit variance,
//! the constant free. Only sums over the nodes are needed.

use nalgebra::{DMatrix, DVector};

/// Values of λ, and how far below the largest they go.
pub(super) const STEPS: usize = 100;
const RATIO: f64 = 1e-4;
/// A round that moves no coefficient by more than the root of this against the largest correlation
/// is the last.
const STILL: f64 = 1e-20;
/// Rounds for one λ at most: correlated columns take many, and the remainder is then too small to
/// decide on a term.
const MOST_ROUNDS: usize = 2_000;

/// Sums over nodes: `XᵀΩX`, `XᵀΩz` and `Σw`.
#[derive(Clone)]
pub(super) struct Sums {
    pub gram: DMatrix<f64>,
    pub cross: DVector<f64>,
    pub weight: f64,
}

/// The sums in columns of unit variance.
pub(super) struct Standardized<'a> {
    sums: &'a Sums,
    constant: Option<usize>,
    /// Columns that vary, and their standard deviations.
    columns: Vec<usize>,
    deviations: Vec<f64>,
    /// Correlations of the columns, and covariances with the heights.
    gram: DMatrix<f64>,
    cross: DVector<f64>,
}

impl<'a> Standardized<'a> {
    pub(super) fn new(sums: &'a Sums, constant: Option<usize>) -> Self {
        let Sums { gram, cross, weight } = sums;
        let centred = |i: usize, j: usize| {
            let mean = constant.map_or(0.0, |c| gram[(i, c)] * gram[(c, j)] / gram[(c, c)]);
            (gram[(i, j)] - mean) / weight
        };
        let varies = |j: &usize| Some(*j) != constant && centred(*j, *j) > 1e-12 * gram[(*j, *j)] / weight;
        let columns: Vec<usize> = (0..gram.ncols()).filter(varies).collect();
        let deviations: Vec<f64> = columns.iter().map(|&j| centred(j, j).sqrt()).collect();
        let size = columns.len();
        let of_heights = |i: usize| {
            let mean = constant.map_or(0.0, |c| gram[(i, c)] * cross[c] / gram[(c, c)]);
            (cross[i] - mean) / weight
        };
        Standardized {
            sums,
            constant,
            gram: DMatrix::from_fn(size, size, |i, j| {
                centred(columns[i], columns[j]) / (deviations[i] * deviations[j])
            }),
            cross: DVector::from_fn(size, |i, _| of_heights(columns[i]) / deviations[i]),
            columns,
            deviations,
        }
    }

    /// λ from the least that keeps nothing downwards.
    pub(super) fn lambdas(&self, alpha: f64) -> Vec<f64> {
        let largest = self.cross.amax() / alpha;
        (0..STEPS).map(|k| largest * RATIO.powf(k as f64 / (STEPS - 1) as f64)).collect()
    }

    /// Before any column has come in.
    pub(super) fn start(&self) -> Estimate {
        Estimate { values: vec![0.0; self.columns.len()], gradient: self.cross.clone() }
    }

    /// The estimate at `lambda`, from that at a λ near by.
    pub(super) fn descend(&self, lambda: f64, alpha: f64, estimate: &mut Estimate) {
        let still = STILL * self.cross.amax().powi(2);
        let all: Vec<usize> = (0..self.columns.len()).collect();
        let mut rounds = 0;
        while rounds < MOST_ROUNDS && self.round(&all, lambda, alpha, estimate) > still {
            rounds += 1;
            // those that are in settle before the others are asked again
            let within: Vec<usize> = all.iter().copied().filter(|&j| estimate.values[j] != 0.0).collect();
            while rounds < MOST_ROUNDS && self.round(&within, lambda, alpha, estimate) > still {
                rounds += 1;
            }
        }
    }

    /// One round over `among`; the largest squared change.
    fn round(&self, among: &[usize], lambda: f64, alpha: f64, estimate: &mut Estimate) -> f64 {
        let Estimate { values, gradient } = estimate;
        let mut largest = 0.0f64;
        for &j in among {
            // columns have unit variance
            let reached = gradient[j] + values[j];
            let value = reached.signum() * (reached.abs() - lambda * alpha).max(0.0) / (1.0 + lambda * (1.0 - alpha));
            let change = value - values[j];
            if change != 0.0 {
                gradient.axpy(-change, &self.gram.column(j), 1.0);
                values[j] = value;
                largest = largest.max(change * change);
            }
        }
        largest
    }

    /// True for each column with a coefficient other than 0.
    pub(super) fn kept(&self, estimate: &Estimate) -> Vec<bool> {
        let mut kept = vec![false; self.sums.cross.len()];
        for (&j, value) in self.columns.iter().zip(&estimate.values) {
            kept[j] = *value != 0.0;
        }
        kept
    }

    /// The coefficients of the columns as they are.
    pub(super) fn coefficients(&self, estimate: &Estimate) -> DVector<f64> {
        let Sums { gram, cross, .. } = self.sums;
        let mut found = DVector::zeros(cross.len());
        for ((&j, value), deviation) in self.columns.iter().zip(&estimate.values).zip(&self.deviations) {
            found[j] = value / deviation;
        }
        if let Some(c) = self.constant {
            found[c] = (cross[c] - gram.column(c).dot(&found)) / gram[(c, c)];
        }
        found
    }
}

/// Coefficients in columns of unit variance, and the covariances of what is left with the columns.
pub(super) struct Estimate {
    values: Vec<f64>,
    gradient: DVector<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sum of squares and a penalty have no slope at their minimum, or the penalty's edge holds
    /// it (Karush, Kuhn and Tucker).
    #[test]
    fn the_estimate_is_the_minimum() {
        let gram = DMatrix::from_row_slice(3, 3, &[8.0, 2.0, 4.0, 2.0, 9.0, 6.0, 4.0, 6.0, 16.0]);
        let sums = Sums { gram, cross: DVector::from_vec(vec![4.0, 7.0, -3.0]), weight: 8.0 };
        let alpha = 0.6;
        let problem = Standardized::new(&sums, Some(0));
        let mut estimate = problem.start();
        let lambdas = problem.lambdas(alpha);
        problem.descend(lambdas[0], alpha, &mut estimate);
        assert_eq!(problem.kept(&estimate), [false; 3]);
        for &lambda in &lambdas[1..] {
            problem.descend(lambda, alpha, &mut estimate);
            for (j, &value) in estimate.values.iter().enumerate() {
                let slope =
                    problem.cross[j] - problem.gram.row(j).transpose().dot(&DVector::from_vec(estimate.values.clone()));
                let penalised = slope - lambda * (1.0 - alpha) * value;
                let expected = if value == 0.0 {
                    penalised.clamp(-lambda * alpha, lambda * alpha)
                } else {
                    lambda * alpha * value.signum()
                };
                assert!((penalised - expected).abs() < 1e-9, "{lambda}: {penalised} {expected}");
            }
        }
        assert_eq!(problem.kept(&estimate), [false, true, true]);
    }
}
