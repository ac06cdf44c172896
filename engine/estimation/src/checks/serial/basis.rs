//! An orthonormal basis of the columns, seen along scan lines, and the distribution of c for white
//! noise.

use nalgebra::DMatrix;

use flankfit_numerics::{cancel::Asking, distribution::pearson::Moments};

/// Rows of an orthonormal basis of the columns, line after line.
///
/// On a full grid the basis is a product of those of its axes and every line is like the others:
/// then the basis of the axis along which lines run serves for all, `lines` times among the nodes
/// and `columns` times among the columns.
pub(crate) struct LineBasis {
    /// Row by row, a column of this for each node.
    q: DMatrix<f64>,
    /// True for each node that has the one before as neighbour.
    linked: Vec<bool>,
    lines: f64,
    columns: f64,
}

impl LineBasis {
    /// Nodes (columns of `q`) in the order of lines.
    pub(crate) fn new(q: DMatrix<f64>, linked: Vec<bool>) -> Self {
        LineBasis { q, linked, lines: 1.0, columns: 1.0 }
    }

    /// Makes the basis of one line, which is repeated for `lines` lines and `columns` products of
    /// its columns.
    pub(crate) fn of_axis(q: DMatrix<f64>, lines: usize, columns: usize) -> Self {
        let linked = (0..q.ncols()).map(|i| i > 0).collect();
        LineBasis { q, linked, lines: lines as f64, columns: columns as f64 }
    }

    /// m − n.
    pub(super) fn freedom(&self) -> f64 {
        self.lines * self.q.ncols() as f64 - self.columns * self.q.nrows() as f64
    }

    /// m.
    pub(super) fn count(&self) -> f64 {
        self.lines * self.q.ncols() as f64
    }

    /// Tr XᵀY of the whole problem, X and Y having the shape of the basis.
    pub(super) fn trace(&self, x: &DMatrix<f64>, y: &DMatrix<f64>) -> f64 {
        self.columns * x.dot(y)
    }

    pub(super) fn q(&self) -> &DMatrix<f64> {
        &self.q
    }

    /// Pairs of neighbours.
    pub(super) fn pairs(&self) -> f64 {
        self.lines * self.linked.iter().filter(|linked| **linked).count() as f64
    }

    /// `AX`: half the sum of both neighbours.
    pub(super) fn neighbours(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(x.nrows(), x.ncols());
        for i in (1..x.ncols()).asking(4 * x.nrows()).filter(|i| self.linked[*i]) {
            out.column_mut(i).axpy(0.5, &x.column(i - 1), 1.0);
            out.column_mut(i - 1).axpy(0.5, &x.column(i), 1.0);
        }
        out
    }

    /// `VX` with V the correlations ρ^|i − j| of nodes on one line.
    pub(super) fn correlated(&self, x: &DMatrix<f64>, rho: f64) -> DMatrix<f64> {
        let count = x.ncols();
        let mut out = x.clone();
        let mut carried = nalgebra::DVector::zeros(x.nrows());
        for i in (0..count).asking(4 * x.nrows()) {
            carried *= if self.linked[i] { rho } else { 0.0 };
            out.column_mut(i).axpy(1.0, &carried, 1.0);
            carried += x.column(i);
        }
        carried.fill(0.0);
        for i in (0..count).rev().asking(4 * x.nrows()) {
            out.column_mut(i).axpy(1.0, &carried, 1.0);
            carried += x.column(i);
            carried *= if self.linked[i] { rho } else { 0.0 };
        }
        out
    }

    /// Mean and variance of c for white noise; `None` without degrees of freedom to vary in.
    pub(crate) fn mean_and_variance(&self) -> Option<(f64, f64)> {
        let once = self.neighbours(&self.q);
        let b = &self.q * once.transpose();
        let square = 0.5 * self.pairs() - self.columns * (2.0 * once.norm_squared() - b.norm_squared());
        self.variance_of(-self.columns * b.trace(), square)
    }

    fn variance_of(&self, first: f64, second: f64) -> Option<(f64, f64)> {
        let freedom = self.freedom();
        let mean = first / freedom;
        let variance = 2.0 * (second - first * mean) / (freedom * (freedom + 2.0));
        (freedom >= 1.0 && variance > 1e-8).then_some((mean, variance))
    }

    /// The first four moments of c for white noise: with `tⱼ = Tr (MA)ʲ` its moments about 0 are
    /// those of `eᵀMAMe` over those of χ².
    pub(crate) fn moments(&self) -> Option<Moments> {
        let once = self.neighbours(&self.q);
        let twice = self.neighbours(&once);
        let product = |x: &DMatrix<f64>, y: &DMatrix<f64>| x * y.transpose();
        let (b, c, d) = (product(&self.q, &once), product(&once, &once), product(&once, &twice));
        let squared = &b * &b;
        let t1 = -self.columns * b.trace();
        let t2 = 0.5 * self.pairs() - self.columns * (2.0 * c.trace() - squared.trace());
        let t3 = -self.columns * (3.0 * (d.trace() - b.dot(&c)) + squared.dot(&b));
        let t4 = self.fourth()
            + self.columns
                * (4.0 * (b.dot(&d) - twice.norm_squared() - squared.dot(&c))
                    + 2.0 * c.norm_squared()
                    + squared.norm_squared());
        self.variance_of(t1, t2)?;
        Moments::of_ratio([t1, t2, t3, t4], self.freedom())
    }

    /// Tr A⁴: closed walks of four steps, each worth 1/16. A pair has two of its own, two pairs
    /// with a node in common have four.
    fn fourth(&self) -> f64 {
        let triples = self.linked.windows(2).filter(|pair| pair[0] && pair[1]).count() as f64;
        (2.0 * self.pairs() + 4.0 * self.lines * triples) / 16.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::serial::Strength;
    use flankfit_numerics::distribution::pearson;

    /// Orthonormal powers at equal steps, a column for each node.
    fn powers(count: usize, degree: usize) -> DMatrix<f64> {
        let at = |i: usize| 2.0 * i as f64 / (count - 1) as f64 - 1.0;
        DMatrix::from_fn(count, degree + 1, |i, j| at(i).powi(j as i32)).qr().q().transpose()
    }

    fn curve(count: usize, degree: usize) -> LineBasis {
        LineBasis::new(powers(count, degree), (0..count).map(|i| i > 0).collect())
    }

    /// The nodes of a grid row by row, lines along v.
    fn grid(u: (usize, usize), v: (usize, usize)) -> (LineBasis, LineBasis) {
        let (qu, qv) = (powers(u.0, u.1), powers(v.0, v.1));
        let whole = LineBasis::new(qu.kronecker(&qv), (0..u.0 * v.0).map(|k| k % v.0 > 0).collect());
        (whole, LineBasis::of_axis(qv, u.0, u.1 + 1))
    }

    /// Traces of powers of MA, formed as they are written.
    fn direct(basis: &LineBasis) -> [f64; 4] {
        let m = basis.q.ncols();
        let a = DMatrix::from_fn(m, m, |i, j| if i.abs_diff(j) == 1 && basis.linked[i.max(j)] { 0.5 } else { 0.0 });
        let ma = (DMatrix::identity(m, m) - basis.q.transpose() * &basis.q) * a;
        let square = &ma * &ma;
        [ma.trace(), square.trace(), (&square * &ma).trace(), (&square * &square).trace()]
    }

    #[test]
    fn moments_are_those_of_the_matrices() {
        for basis in [curve(8, 2), curve(20, 12), grid((5, 3), (9, 3)).0] {
            let [t1, t2, t3, t4] = direct(&basis);
            let f = basis.freedom();
            // cumulants over f, the ratio being independent of its denominator
            let mean = t1 / f;
            let second = (2.0 * t2 + t1 * t1) / (f * (f + 2.0));
            let third = (8.0 * t3 + 6.0 * t2 * t1 + t1.powi(3)) / (f * (f + 2.0) * (f + 4.0));
            let fourth = (48.0 * t4 + 32.0 * t3 * t1 + 12.0 * t2 * t2 + 12.0 * t2 * t1 * t1 + t1.powi(4))
                / (f * (f + 2.0) * (f + 4.0) * (f + 6.0));
            let variance = second - mean * mean;
            let skewness = (third - 3.0 * mean * second + 2.0 * mean.powi(3)) / variance.powf(1.5);
            let kurtosis =
                (fourth - 4.0 * mean * third + 6.0 * mean * mean * second - 3.0 * mean.powi(4)) / (variance * variance);
            let found = basis.moments().unwrap();
            for (got, expected) in
                [(found.mean, mean), (found.variance, variance), (found.skewness, skewness), (found.kurtosis, kurtosis)]
            {
                assert!((got - expected).abs() < 1e-9 * expected.abs().max(1e-3), "{found:?} {got} {expected}");
            }
        }
    }

    #[test]
    fn an_axis_represents_all_lines() {
        let (whole, axis) = grid((5, 2), (9, 3));
        let (a, b) = (whole.moments().unwrap(), axis.moments().unwrap());
        for (a, b) in [(a.mean, b.mean), (a.variance, b.variance), (a.skewness, b.skewness), (a.kurtosis, b.kurtosis)] {
            assert!((a - b).abs() < 1e-10, "{a} {b}");
        }
        let (a, b) = (Strength::of(0.4, &whole), Strength::of(0.4, &axis));
        assert!((a.rho - b.rho).abs() < 1e-9 && (a.factor - b.factor).abs() < 1e-9, "{a:?} {b:?}");
    }

    /// P(c > …) by Imhof's integral over the eigenvalues of MAM (numpy, scipy.integrate.quad).
    #[test]
    fn tails_are_those_of_imhof() {
        let cases = [
            (curve(12, 3), 0.2, 0.009_117_128),
            (curve(12, 3), 0.35, 0.000_401_342),
            (curve(20, 3), 0.3, 0.006_432_698),
            (curve(20, 3), 0.45, 0.000_389_128),
            (curve(45, 3), 0.25, 0.009_027_749),
            (curve(45, 3), 0.36, 0.000_726_400),
            (grid((5, 3), (9, 3)).1, 0.05, 0.008_922_044),
            (grid((5, 3), (9, 3)).1, 0.15, 0.001_653_849),
            (grid((5, 3), (9, 3)).1, 0.2, 0.000_649_033),
        ];
        for (basis, c, exact) in cases {
            let p = pearson::upper_tail(c, &basis.moments().unwrap());
            assert!(p < 1.6 * exact && p > 0.85 * exact, "{c}: {p} {exact}");
        }
    }
}
