//! Positions that are off, against ODRPACK by scipy:
//! `odr.ODR(odr.RealData(x, y, sx=0.3, sy=0.4), odr.Model(cubic), beta0=polyfit, sstol=1e-15,
//! partol=1e-15, maxit=2000).run()`, of which `beta`, `res_var` and `max |delta|` are compared, and
//! the standard errors of Fuller (1987) at the places that it finds with twice what the bend
//! shifts. In Python, with `rows`, `slopes` and `bends` of 1, x, x², x³ at `x + delta`,
//! `g = slopes @ beta`, `ratio = (0.3/0.4)²`, `w = 1/(1 + ratio g²)`, `s2 = 0.16 res_var` and
//! `C = w s2 ratio`: `G = rowsᵀ w rows`, `V = slopesᵀ (w C) slopes`,
//! `b = G⁻¹ rowsᵀ (w C bends @ beta / 2)` without the places that lie within √C of an end,
//! `sqrt(diag(s2 (G − V)⁻¹ G (G − V)⁻¹) + 4 b²)`.

use flankfit_engine::estimation::{
    FitSpec, Nodes, fit,
    spec::{Degree, Model, NodeUncertainty, PolynomialBasis, PositionKind, Regularization, Terms},
};

#[test]
fn a_cubic_is_that_of_odrpack() {
    let x = vec![0.2, 0.9, 2.3, 2.6, 4.1, 5.2, 5.7, 7.4, 7.9, 8.8, 10.3, 10.9];
    let y = vec![1.1, 1.9, 3.8, 3.1, 5.2, 4.9, 5.8, 4.1, 4.6, 2.7, 1.2, -0.9];
    let model = Model::Polynomial { degree: Degree::Both(3), basis: PolynomialBasis::Monomial, terms: Terms::Tensor };
    let kind = Some(PositionKind::Measured);
    let spec = FitSpec {
        regularization: Regularization::None,
        node_uncertainty: Some(NodeUncertainty { position: 0.3, height: 0.4, kind }),
        ..FitSpec::new(model)
    };
    let found = fit(&Nodes::curve(x, y, None).unwrap(), &spec).unwrap();
    let beta = [0.6181663267819842, 1.489398678534183, -0.08367658417937701, -0.005952900220680128];
    let errors = [0.6180636098488456, 0.49592360015199655, 0.1067197003039611, 0.0064625076948468686];
    for ((c, beta), error) in found.coefficients.iter().zip(beta).zip(errors) {
        assert!((c.value - beta).abs() < 1e-5 * error, "{c:?} {beta}");
        assert!((c.std_error.unwrap() / error - 1.0).abs() < 1e-6, "{c:?} {error}");
    }
    let report = found.positions.unwrap();
    assert!((report.sigma_ratio.unwrap() - 1.108391180297616f64.sqrt()).abs() < 1e-5, "{report:?}");
    assert!((report.largest_shift - 0.2625124764831217).abs() < 1e-5, "{report:?}");
}
