//! The criteria that choose a parameter of regularisation.

/// λ* of the spectral schemes, k of ridge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Parameter {
    /// Chosen from the data.
    Criterion(Criterion),
    /// The caller's own, not negative.
    Fixed(f64),
}

/// A rule that chooses λ* or k from the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Criterion {
    /// Least mean squared error of the coefficients, predicted from an estimate less its noise.
    MinMse,
    /// Least condition of the regularised Fisher information matrix (Eq. 49); of spectral schemes
    /// only.
    MinCondition,
    /// Least generalised cross-validation function `RSS/(m − Σfᵢ)²` (Golub, Heath and Wahba).
    Gcv,
    /// RSS = m σ² (Morozov's discrepancy principle).
    Discrepancy,
    /// Greatest curvature of the L-curve, log ‖residuals‖ against log ‖Â_B‖ (Hansen).
    LCurve,
    /// Ridge: (p−2)σ²/‖Â‖², the modified form of Hoerl, Kennard and Baldwin.
    Hkb,
    /// Ridge: pσ²/‖Â‖², as Hoerl, Kennard and Baldwin (1975) gave it.
    Hkb1975,
    /// Ridge: (p−2)σ² λ̄/ΣλᵢÂᵢ², after Lawless and Wang.
    LawlessWang,
    /// Attraction: the explicit minimiser of the predicted mean squared error.
    Optimal,
}

impl Criterion {
    /// Those that every regularisation with a parameter may be asked for; the others belong to one
    /// kind.
    pub const ALL: [Criterion; 5] =
        [Criterion::MinMse, Criterion::MinCondition, Criterion::Gcv, Criterion::Discrepancy, Criterion::LCurve];

    /// The contract's name.
    pub fn name(self) -> &'static str {
        match self {
            Criterion::MinMse => "min_mse",
            Criterion::MinCondition => "min_condition",
            Criterion::Gcv => "gcv",
            Criterion::Discrepancy => "discrepancy",
            Criterion::LCurve => "l_curve",
            Criterion::Hkb => "hkb",
            Criterion::Hkb1975 => "hkb_1975",
            Criterion::LawlessWang => "lawless_wang",
            Criterion::Optimal => "optimal",
        }
    }

    /// The closed forms for ridge.
    pub const RIDGE: [Criterion; 3] = [Criterion::Hkb, Criterion::Hkb1975, Criterion::LawlessWang];

    /// Every criterion there is.
    pub fn every() -> impl Iterator<Item = Criterion> {
        Self::ALL.into_iter().chain(Self::RIDGE).chain([Criterion::Optimal])
    }
}
