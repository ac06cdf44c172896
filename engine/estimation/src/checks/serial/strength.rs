//! Strength of a correlation along lines, and its effect on standard errors.

use super::basis::LineBasis;
use flankfit_numerics::root::root;

/// A correlation of neighbouring errors, as an autoregression of first order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Strength {
    /// The correlation of neighbours.
    pub rho: f64,
    /// Factor by which standard errors that take errors for independent are too small, over all
    /// linear forms.
    pub factor: f64,
}

/// Greatest correlation that is reported: a random walk has none.
const MOST: f64 = 0.98;

impl Strength {
    /// With ρ for which c is what it is expected to be: `Tr MAMV = c Tr MV`.
    pub(crate) fn of(c: f64, basis: &LineBasis) -> Self {
        let q = basis.q();
        let once = basis.neighbours(q);
        let b = q * once.transpose();
        let beyond = |rho: f64| {
            let v = basis.correlated(q, rho);
            let inner = q * v.transpose();
            let whole = basis.count() - basis.trace(q, &v);
            basis.pairs() * rho - 2.0 * basis.trace(&v, &once) + basis.trace(&b, &inner) - c * whole
        };
        let ends = [(0.0, beyond(0.0)), (MOST, beyond(MOST))];
        let rho = root(ends, |_| 1e-3, beyond).unwrap_or(if ends[1].1 < 0.0 { MOST } else { 0.0 });
        let (count, freedom) = (basis.count(), basis.freedom());
        let within = basis.trace(q, &basis.correlated(q, rho));
        let (estimates, residuals) = (within / (count - freedom), (count - within) / freedom);
        Strength { rho, factor: (estimates / residuals).sqrt() }
    }

    /// Strength of correlation `c` for nodes so many that the columns change little from one to the
    /// next.
    pub(crate) fn of_many(c: f64) -> Self {
        let rho = c.clamp(0.0, MOST);
        Strength { rho, factor: ((1.0 + rho) / (1.0 - rho)).sqrt() }
    }
}
