//! What a caller asks for of estimates drawn to a target.

use super::criterion::Parameter;

/// `Â_JS = T + c (Â − T)` with a factor c that the data give.
///
/// With `Q = ‖X(Â − T)‖²`, p directions, RSS on ν degrees of freedom; where σ is given
/// (`noise_sigma`) its square takes the place of the estimate of the variance.
#[derive(Clone, Debug, PartialEq)]
pub struct JamesStein {
    /// Formula of the factor c.
    pub factor: ShrinkageFactor,
    /// c is not let below 0.
    pub positive_part: bool,
    /// T in the caller's terms; 0 where none is given (but see [`ShrinkageFactor::EfronMorris`]).
    pub target: Option<Vec<f64>>,
}

/// The factor c.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShrinkageFactor {
    /// `1 − (p−2) RSS/((ν+2) Q)`: James and Stein with unknown variance, the least risk of this
    /// form.
    JamesStein,
    /// `1 − (p−2) s²/Q`, `s² = RSS/ν`.
    HoerlKennard,
    /// As [`ShrinkageFactor::JamesStein`], but without a target T is the grand mean: the constant
    /// function of the (weighted) mean height, which costs one direction (p−3 in place of p−2), as
    /// Efron and Morris did.
    EfronMorris,
}

/// `Â = (Â + kT)/(1 + k)`, which minimises `‖Y − XA‖² + k ‖X(A − T)‖²`.
#[derive(Clone, Debug, PartialEq)]
pub struct Attraction {
    /// T in the caller's terms.
    pub target: Vec<f64>,
    /// k.
    pub parameter: Parameter,
}
