//! The covariance of least squares with unknown variances of the errors.
//!
//! HC3 (MacKinnon and White, Journal of Econometrics 29, 1985): in the coordinates of the
//! orthonormal rows qₖ the covariance is `Σ qₖqₖᵀ (rₖ/(1 − hₖ))²`, hₖ = ‖qₖ‖² the leverage. The
//! division makes each residual that of a fit without its node.
//!
//! The variance of a form q is a sum `Σ vₖ`, `vₖ = (qᵀqₖ)² (rₖ/(1 − hₖ))²`, of which a few nodes
//! may be nearly all: the noisiest, or those that the form rests on. Then it is itself as uncertain
//! as that of few nodes. It has the degrees of freedom of Satterthwaite's approximation, the fewer
//! of
//!
//! ```text
//! 3 (Σ vₖ)² / Σ vₖ²,   (Σ eₖ)² / Σ eₖ²,   eₖ = (qᵀqₖ)² / (1 − hₖ)
//! ```
//!
//! which are those by the residuals (`E r⁴ = 3 σ⁴` of normal errors), and those that errors of one
//! variance would leave, their correlations left out (Bell and McCaffrey, Survey Methodology 28,
//! 2002). With m − n for every form, 95 % intervals of a cubic would hold in 0.82 to 0.92 where two
//! to five nodes at an end are ten times as noisy as the others (docs/explanation/errors.md).

use nalgebra::DMatrix;

use flankfit_numerics::{cancel::Asking, distribution::Student};

/// 1 − h below which a node determines its own fitted height.
const ALONE: f64 = 1e-10;
/// `E r⁴ / σ⁴` of normal errors.
const KURTOSIS: f64 = 3.0;
/// Degrees of freedom that Student's distribution begins with.
const LEAST_FREEDOM: f64 = 1.0;

/// Parts of the covariance of HC3.
pub(crate) struct Sandwich {
    n: usize,
    /// qₖ, one after another.
    q: Vec<f64>,
    nodes: Vec<Deleted>,
}

/// A node as the others see it.
struct Deleted {
    /// 1 − hₖ.
    rest: f64,
    /// `(rₖ/(1 − hₖ))²`.
    square: f64,
}

impl Sandwich {
    /// Makes it from orthonormal rows of `n` numbers; `None` if a node alone determines a
    /// direction, so that its residual says nothing.
    pub(crate) fn new(n: usize, q: Vec<f64>, residuals: &[f64]) -> Option<Self> {
        let node = |(row, r): (&[f64], &f64)| {
            let rest = 1.0 - row.iter().map(|x| x * x).sum::<f64>();
            (rest >= ALONE).then(|| Deleted { rest, square: (r / rest).powi(2) })
        };
        let nodes = q.chunks_exact(n).zip(residuals).asking(n).map(node).collect::<Option<Vec<_>>>()?;
        Some(Sandwich { n, q, nodes })
    }

    /// The covariance by HC3.
    pub(crate) fn covariance(&self) -> DMatrix<f64> {
        let mut covariance = DMatrix::<f64>::zeros(self.n, self.n);
        for (row, node) in self.q.chunks_exact(self.n).zip(&self.nodes).asking(self.n * self.n) {
            for (j, &x) in row.iter().enumerate() {
                let share = node.square * x;
                covariance.column_mut(j).iter_mut().zip(row).for_each(|(to, y)| *to += share * y);
            }
        }
        covariance
    }

    /// The distribution of a form's error over its standard error.
    pub(crate) fn student(&self, form: &[f64]) -> Student {
        let whole = (self.nodes.len() - self.n) as f64;
        // fourth powers of a form or of residuals need not be doubles
        let size = form.iter().fold(0.0f64, |size, x| size.max(x.abs()));
        let noise = self.nodes.iter().fold(0.0f64, |noise, node| noise.max(node.square));
        let (mut found, mut even) = (Shares::default(), Shares::default());
        for (row, node) in self.q.chunks_exact(self.n).zip(&self.nodes).asking(self.n) {
            let along = row.iter().zip(form).map(|(x, p)| x * (p / size)).sum::<f64>().powi(2);
            found.add(along * (node.square / noise));
            even.add(along / node.rest);
        }
        let freedom = (KURTOSIS * found.count()).min(even.count());
        Student::new(if freedom.is_finite() { freedom.clamp(LEAST_FREEDOM, whole) } else { whole })
    }
}

/// Shares of nodes in a sum.
#[derive(Default)]
struct Shares {
    sum: f64,
    squares: f64,
}

impl Shares {
    fn add(&mut self, share: f64) {
        self.sum += share;
        self.squares += share * share;
    }

    /// So many equal shares would vary as much.
    fn count(&self) -> f64 {
        self.sum * self.sum / self.squares
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values by hand: the mean of eight heights, h = 1/8.
    #[test]
    fn degrees_of_freedom_are_those_of_the_nodes_that_count() {
        let freedom = |residuals: [f64; 8], form: f64| {
            Sandwich::new(1, vec![0.125f64.sqrt(); 8], &residuals).unwrap().student(&[form]).freedom()
        };
        // even shares: 24 by the residuals, 8 by the leverages, 7 are left
        assert!((freedom([1.0; 8], 1.0) - 7.0).abs() < 1e-12);
        // two of eight: 3 · 2
        let two = [5.0, -5.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        for form in [1.0, -1e-200, 1e200] {
            assert!((freedom(two, form) - 6.0).abs() < 1e-12);
            assert!((freedom(two.map(|r| 1e100 * r), form) - 6.0).abs() < 1e-12);
        }
        // 3 (1 + 4)² / (1 + 16)
        assert!((freedom([1.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 1.0) - 75.0 / 17.0).abs() < 1e-12);
        // without residuals, and for no form, the default applies
        assert_eq!([freedom([0.0; 8], 1.0), freedom(two, 0.0)], [7.0; 2]);
    }

    /// A form that rests on one node knows its variance by that node alone.
    #[test]
    fn a_form_of_few_nodes_has_few_degrees_of_freedom() {
        // the columns (0, 0, 1, 1, 1, 1)/2 and (1, 1, 0, 0, 0, 0)/√2
        let root = 0.5f64.sqrt();
        let mut q = vec![0.0, root, 0.0, root];
        (0..4).for_each(|_| q.extend([0.5, 0.0]));
        let found = Sandwich::new(2, q, &[1.0; 6]).unwrap();
        assert!((found.student(&[0.0, 1.0]).freedom() - 2.0).abs() < 1e-12);
        assert!((found.student(&[1.0, 0.0]).freedom() - 4.0).abs() < 1e-12);
        assert!(Sandwich::new(1, vec![1.0, 0.0], &[0.0, 1.0]).is_none());
    }
}
