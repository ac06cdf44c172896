//! The roughness penalty of a tensor B-spline as a banded matrix: `P = w_u D_u ⊗ M_v + w_v M_u ⊗
//! D_v`, the integrals of squared derivatives and values over the knots, as for Tikhonov's estimate
//! of other fits.

use flankfit_geometry::BSplineBasis;
use flankfit_numerics::{Dd, Real, band_cholesky::SymmetricBand, cancel, quadrature::gauss_legendre};

/// P for coefficients `i · (functions of v) + j`; for order 0 `(w_u + w_v) M_u ⊗ M_v`.
pub(crate) fn penalty([u, v]: [&BSplineBasis; 2], order: usize, weights: [f64; 2]) -> SymmetricBand<f64> {
    let (p, q) = (u.degree(), v.degree());
    let mut band = SymmetricBand::zeros(u.size() * v.size(), p * v.size() + q);
    let (mass_u, mass_v) = (gram(u, 0), gram(v, 0));
    let terms = if order == 0 {
        vec![(weights[0] + weights[1], mass_u, mass_v)]
    } else {
        vec![(weights[0], gram(u, order), mass_v), (weights[1], mass_u, gram(v, order))]
    };
    for (weight, along, across) in terms.iter().filter(|term| term.0 > 0.0) {
        for i in 0..u.size() {
            cancel::checkpoint();
            for k in i.saturating_sub(p)..=i {
                let factor = along.get(i, k) * *weight;
                for j in 0..v.size() {
                    // below the diagonal, and on it once
                    for l in j.saturating_sub(q)..=(j + q).min(v.size() - 1) {
                        let (row, column) = (i * v.size() + j, k * v.size() + l);
                        if column <= row {
                            band.add(row, column, (factor * across.get(j, l)).to_f64());
                        }
                    }
                }
            }
        }
    }
    band
}

/// `∫ N⁽ᵏ⁾ N⁽ᵏ⁾ᵀ`, span by span by Gauss' rule, which is exact here.
fn gram(basis: &BSplineBasis, order: usize) -> SymmetricBand<Dd> {
    let p = basis.degree();
    let mut band = SymmetricBand::zeros(basis.size(), p);
    let rule = gauss_legendre(p + 1);
    let mut values = vec![Dd::ZERO; p + 1];
    for ends in basis.distinct_knots().windows(2) {
        let half = Dd::diff(ends[1], ends[0]).mul_f64(0.5);
        let middle = Dd::sum(ends[0], ends[1]).mul_f64(0.5);
        for &(node, weight) in &rule {
            let x = (middle + half * node).to_f64().clamp(ends[0], ends[1]);
            let first = basis.derivatives_of(order, x, &mut values);
            for a in 0..=p {
                for b in 0..=a {
                    band.add(first + a, first + b, values[a] * values[b] * weight * half);
                }
            }
        }
    }
    band
}
