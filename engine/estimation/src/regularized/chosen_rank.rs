//! The rank of a truncated singular value decomposition, chosen from the data.
//!
//! With `bᵢ² = λᵢ aᵢ²`, `RSS_r` that of the r largest singular values and m nodes:
//! * `gcv`: least `RSS_r/(m − r)²`;
//! * `discrepancy`: the smallest r with `RSS_r ≤ m σ²`;
//! * `reml`: greatest marginal likelihood, the kept coefficients having Zellner's prior
//!   ([`g_prior`]); with flat ones likelihoods of different data would be compared.

use crate::{
    selection::{Spectral, Unavailable, g_prior},
    spec::Criterion,
};

/// Directions kept, of the numerically nonzero ones.
pub(super) fn choose(criterion: Criterion, problem: &Spectral, a: &[f64]) -> Result<usize, Unavailable> {
    let ranks = Ranks::new(problem, a);
    match criterion {
        Criterion::Gcv if ranks.freedom(ranks.rank()) <= 0.0 && problem.variance.is_none() => Err(Unavailable::NoSigma),
        Criterion::Gcv => Ok(ranks.least(|r| match ranks.freedom(r) {
            left if left > 0.0 => ranks.rss[r] / (left * left),
            _ => f64::INFINITY,
        })),
        Criterion::Discrepancy => {
            let target = problem.count as f64 * problem.variance.ok_or(Unavailable::NoSigma)?;
            Ok((1..=ranks.rank()).find(|&r| ranks.rss[r] <= target).unwrap_or(ranks.rank()))
        }
        Criterion::Reml => Ok(ranks.least(|r| ranks.unlikelihood(r, problem.given_variance))),
        _ => Err(Unavailable::NoMinimiser),
    }
}

struct Ranks {
    /// RSS by rank, from 0 on.
    rss: Vec<f64>,
    /// m less the unpenalised constant.
    count: f64,
}

impl Ranks {
    fn new(problem: &Spectral, a: &[f64]) -> Self {
        let squares = problem.lambda.iter().zip(a).filter(|(l, _)| **l > 0.0).map(|(l, a)| l * a * a);
        let mut rss = vec![problem.rss];
        for square in squares {
            rss.push(rss[rss.len() - 1] + square);
        }
        rss.reverse();
        Ranks { rss, count: (problem.count - problem.unpenalised) as f64 }
    }

    fn rank(&self) -> usize {
        self.rss.len() - 1
    }

    fn freedom(&self, r: usize) -> f64 {
        self.count - r as f64
    }

    /// The rank of least value; of equal ones the smallest.
    fn least(&self, value: impl Fn(usize) -> f64) -> usize {
        (1..=self.rank())
            .map(|r| (r, value(r)))
            .filter(|(_, value)| !value.is_nan())
            .min_by(|x, y| x.1.total_cmp(&y.1))
            .map_or(1, |(r, _)| r)
    }

    /// −2 ln of the marginal likelihood, less constants.
    fn unlikelihood(&self, r: usize, given: Option<f64>) -> f64 {
        g_prior(self.rss[0], self.rss[r], r as f64, self.count, given)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAMBDA: [f64; 5] = [1e-6, 1e-3, 0.1, 0.9, 4.0];
    // noise of σ = 0.01 alone along the three small ones
    const A: [f64; 5] = [8.0, 0.4, -0.02, 3.0, -5.0];

    #[test]
    fn directions_of_noise_are_left_out() {
        let problem = Spectral::new(&LAMBDA, &A, Some(1e-4), 20.0 * 1e-4, 25, 0);
        for criterion in Criterion::OF_RANK {
            assert_eq!(choose(criterion, &problem, &A), Ok(2), "{criterion:?}");
        }
        assert_eq!(choose(Criterion::LCurve, &problem, &A), Err(Unavailable::NoMinimiser));
    }

    #[test]
    fn signal_keeps_its_directions() {
        let a = [9000.0, 50.0, -7.0, 3.0, -5.0];
        let problem = Spectral::new(&LAMBDA, &a, Some(1e-4), 20.0 * 1e-4, 25, 0);
        for criterion in Criterion::OF_RANK {
            assert_eq!(choose(criterion, &problem, &a), Ok(5), "{criterion:?}");
        }
    }
}
