//! Profiles whose nodes lie elsewhere than they are said to.

use flankfit_engine::estimation::{
    FitSpec,
    spec::{Degree, Domain, Model, NodeUncertainty, PolynomialBasis, PositionKind, Regularization, Terms},
};

/// Cubics in µm over 0 to 10 mm by their coefficients of Legendre polynomials.
pub const CUBICS: [[f64; 4]; 4] =
    [[0.0, 10.0, -5.0, 2.0], [0.0, 3.0, -3.0, 0.0], [0.0, 10.0, -15.0, 8.0], [0.0, 20.0, -30.0, 20.0]];
/// Nodes of a profile.
pub const PLACES: usize = 60;

/// The height at x.
pub fn height(cubic: [f64; 4], x: f64) -> f64 {
    let t = 0.2 * x - 1.0;
    let legendre = [1.0, t, 1.5 * t * t - 0.5, 2.5 * t.powi(3) - 1.5 * t];
    cubic.iter().zip(legendre).map(|(a, p)| a * p).sum()
}

/// The coefficients of the same cubic over the domain of [`uncertain`], twice as wide.
pub fn coefficients([a, b, c, d]: [f64; 4]) -> [f64; 4] {
    [a + 1.5 * c, 2.0 * b + 9.0 * d, 4.0 * c, 8.0 * d]
}

/// A cubic over −5 to 15 mm, so that no node falls out of it.
pub fn uncertain(position: f64, height: f64, kind: Option<PositionKind>) -> FitSpec {
    let model = Model::Polynomial { degree: Degree::Both(3), basis: PolynomialBasis::Legendre, terms: Terms::Total };
    FitSpec {
        regularization: Regularization::None,
        domain: Some(Domain { u: Some([-5.0, 15.0]), v: None }),
        node_uncertainty: Some(NodeUncertainty { position, height, kind }),
        ..FitSpec::new(model)
    }
}
