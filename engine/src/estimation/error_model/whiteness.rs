//! How white residuals along lines are: Durbin and Watson's d, and Ljung and Box's Q.

use super::lines::Lines;
use crate::{estimation::result::Whiteness, numerics::distribution::chi_squared};

impl Whiteness {
    /// Of residuals by counted node; `None` where all are 0.
    pub(crate) fn of(residuals: &[f64], lines: &Lines, lags: usize) -> Option<Self> {
        let along: Vec<f64> = lines.nodes.iter().map(|&k| residuals[k]).collect();
        let rss: f64 = along.iter().map(|r| r * r).sum();
        // how many nodes stand before each on its line
        let mut before = Vec::with_capacity(along.len());
        for step in &lines.steps {
            let number = before.last().map_or(0, |last: &usize| last + 1);
            before.push(if step.is_finite() { number } else { 0 });
        }
        let count = along.len() as f64;
        let (mut differences, mut sum) = (0.0, 0.0);
        for lag in 1..=lags {
            let (mut product, mut pairs) = (0.0, 0.0);
            for i in (lag..along.len()).filter(|&i| before[i] >= lag) {
                product += along[i] * along[i - lag];
                pairs += 1.0;
                if lag == 1 {
                    differences += (along[i] - along[i - 1]).powi(2);
                }
            }
            if pairs > 0.0 {
                sum += (product / rss).powi(2) / pairs;
            }
        }
        let q = count * (count + 2.0) * sum;
        (rss > 0.0).then(|| Whiteness {
            durbin_watson: differences / rss,
            ljung_box: q,
            ljung_box_p: chi_squared::upper_tail(q, lags as f64),
        })
    }

    /// Lags that so many nodes are looked at over: ten, or a fifth of the nodes.
    pub(crate) fn lags(count: usize) -> usize {
        (count / 5).clamp(1, 10)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// statsmodels: stattools.durbin_watson and acorr_ljungbox(lags=2), of residuals with mean 0.
    #[test]
    fn figures_are_those_of_statsmodels() {
        let r = [0.3, 0.5, -0.2, -0.6, -0.1, 0.4, 0.2, -0.5, -0.3, 0.3];
        let lines = Lines { nodes: (0..10).collect(), steps: [&[f64::INFINITY][..], &[1.0; 9]].concat() };
        let found = Whiteness::of(&r, &lines, 2).unwrap();
        assert!((found.durbin_watson - 1.53623188405797).abs() < 1e-12, "{found:?}");
        assert!(
            (found.ljung_box - 8.405184485052155).abs() < 1e-12
                && (found.ljung_box_p - 0.01495675498808236).abs() < 1e-12,
            "{found:?}"
        );
        assert_eq!(Whiteness::of(&[0.0; 10], &lines, 2), None);
    }
}
