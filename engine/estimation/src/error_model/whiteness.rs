//! Whiteness of residuals along lines: Durbin and Watson's d, and Ljung and Box's Q, of any number
//! of lines.
//!
//! With Sₕ the sum of `rᵢ rᵢ₊ₕ` over the mₕ pairs that lie h nodes apart on one line and
//! `s² = Σ r²/m`, d is `Σ (rᵢ − rᵢ₊₁)²/m₁` over s². Of white normal residuals r/‖r‖ is uniform on
//! the sphere, where `Sₕ/Σ r²` has the variance `mₕ/(m(m + 2))`. So
//! `Q = (m + 2)/m Σ Sₕ²/(mₕ s⁴)` has as many for its mean as there are lags; of one line it is that
//! of Ljung and Box (Biometrika 65, 1978).

use super::lines::Lines;
use crate::result::Whiteness;
use flankfit_numerics::distribution::chi_squared;

impl Whiteness {
    /// Computes the statistics of residuals by counted node over so many lags, each of which occurs
    /// on some line; `None` if all residuals are 0, or no line has two nodes.
    pub(crate) fn of(residuals: &[f64], lines: &Lines, lags: usize) -> Option<Self> {
        let along: Vec<f64> = lines.nodes.iter().map(|&k| residuals[k]).collect();
        let rss: f64 = along.iter().map(|r| r * r).sum();
        let (before, count) = (before(lines), along.len() as f64);
        let (mut difference, mut sum) = (0.0, 0.0);
        for lag in 1..=lags {
            let (mut product, mut differences, mut pairs) = (0.0, 0.0, 0.0);
            for i in (lag..along.len()).filter(|&i| before[i] >= lag) {
                product += along[i] * along[i - lag];
                differences += (along[i] - along[i - lag]).powi(2);
                pairs += 1.0;
            }
            sum += (product / rss).powi(2) / pairs;
            if lag == 1 {
                difference = differences / pairs;
            }
        }
        let q = count * (count + 2.0) * sum;
        (rss > 0.0 && lags > 0).then(|| Whiteness {
            durbin_watson: difference / (rss / count),
            ljung_box: q,
            ljung_box_p: chi_squared::upper_tail(q, lags as f64),
        })
    }

    /// Lags that nodes are looked at over: up to ten, or a fifth of the nodes, of which each has
    /// pairs for a fifth of the nodes; one at least where there are any neighbours.
    pub(crate) fn lags(lines: &Lines) -> usize {
        let (before, count) = (before(lines), lines.nodes.len());
        let pairs = |lag: usize| before.iter().filter(|&&before| before >= lag).count();
        let most = (count / 5).clamp(1, 10);
        let enough = (1..=most).take_while(|&lag| pairs(lag) > 0 && 5 * pairs(lag) >= count).count();
        if pairs(1) > 0 { enough.max(1) } else { 0 }
    }
}

/// Number of nodes before each on its line.
fn before(lines: &Lines) -> Vec<usize> {
    let mut before: Vec<usize> = Vec::with_capacity(lines.steps.len());
    for step in &lines.steps {
        let number = before.last().map_or(0, |last| last + 1);
        before.push(if step.is_finite() { number } else { 0 });
    }
    before
}

#[cfg(test)]
mod tests {
    use super::*;

    /// statsmodels: stattools.durbin_watson and acorr_ljungbox(lags=2), of residuals with mean 0.
    #[test]
    fn figures_are_those_of_statsmodels() {
        let r = [0.3, 0.5, -0.2, -0.6, -0.1, 0.4, 0.2, -0.5, -0.3, 0.3];
        let lines = Lines { nodes: (0..10).collect(), steps: [&[f64::INFINITY][..], &[1.0; 9]].concat(), across: None };
        let found = Whiteness::of(&r, &lines, 2).unwrap();
        // over the nine pairs instead of the ten nodes
        assert!((found.durbin_watson - 1.53623188405797 * 10.0 / 9.0).abs() < 1e-12, "{found:?}");
        assert!(
            (found.ljung_box - 8.405184485052155).abs() < 1e-12
                && (found.ljung_box_p - 0.01495675498808236).abs() < 1e-12,
            "{found:?}"
        );
        assert_eq!(Whiteness::of(&[0.0; 10], &lines, 2), None);
    }

    fn even(lines: usize, nodes: usize) -> Lines {
        let steps = (0..lines * nodes).map(|k| if k % nodes == 0 { f64::INFINITY } else { 1.0 }).collect();
        Lines { nodes: (0..lines * nodes).collect(), steps, across: None }
    }

    #[test]
    fn lags_are_those_that_lines_have() {
        let lags = |lines, nodes| Whiteness::lags(&even(lines, nodes));
        assert_eq!([lags(1, 60), lags(1, 10), lags(1, 4), lags(1, 2)], [10, 2, 1, 1]);
        assert_eq!([lags(40, 2), lags(20, 5), lags(30, 1)], [1, 4, 0]);
        // one pair among thirty nodes
        let few = Lines { nodes: (0..30).collect(), steps: [&[1.0][..], &[f64::INFINITY; 29]].concat(), across: None };
        let few = Lines { steps: few.steps.iter().rev().copied().collect(), ..few };
        assert_eq!((few.pairs(), Whiteness::lags(&few)), (1, 1));
        assert_eq!(Whiteness::of(&[1.0; 30], &even(30, 1), 0), None);
    }

    /// Values by hand: two lines of two.
    #[test]
    fn pairs_across_lines_are_not_counted() {
        let found = Whiteness::of(&[1.0, 2.0, -1.0, 3.0], &even(2, 2), 1).unwrap();
        // differences 1 and 4 over two pairs, squares 15 over four nodes; products 2 and -3
        assert!((found.durbin_watson - (17.0 / 2.0) / (15.0 / 4.0)).abs() < 1e-15, "{found:?}");
        assert!((found.ljung_box - 24.0 / 225.0 / 2.0).abs() < 1e-15, "{found:?}");
    }
}
