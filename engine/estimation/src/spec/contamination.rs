//! The share of gross errors against which Huber's estimator is the minimax one (Eq. 10).

#[cfg(feature = "contract")]
use flankfit_numerics::contract::{name, number};
use flankfit_numerics::{distribution::normal, root::root};

/// ε of the class (1 − ε)Φ + εH of distributions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize), serde(untagged))]
pub enum Contamination {
    /// ε, between 0 and 1.
    Share(f64),
    #[cfg_attr(feature = "contract", serde(with = "estimate"))]
    /// The ε in whose least favourable distribution the residuals are likeliest.
    Estimated,
}

impl Contamination {
    /// ε that can be given.
    pub const SHARE: [f64; 2] = [1e-6, 0.9];
}

/// Huber's k that is best against a share ε of gross errors: the root of `2φ(k)/k − 2Φ(−k) = ε/(1 −
/// ε)` (Huber 1964).
///
/// ```
/// use flankfit_estimation::spec::minimax_k;
///
/// // One gross error in twenty.
/// assert!((minimax_k(0.05) - 1.398_377_124_675_959_2).abs() < 1e-14);
/// ```
pub fn minimax_k(share: f64) -> f64 {
    let odds = share / (1.0 - share);
    let excess = |k: f64| 2.0 * normal::density(k) / k - 2.0 * normal::upper_tail(k) - odds;
    let [low, high] = [1e-3, 8.0];
    root([(low, excess(low)), (high, excess(high))], |k| f64::EPSILON * k, excess).unwrap_or(high)
}

#[cfg(feature = "contract")]
flankfit_numerics::constant!(estimate = "estimate");

#[cfg(feature = "contract")]
flankfit_numerics::alternatives!(
    Contamination,
    "Share of gross errors, 1e-6 to 0.9, or `estimate`.",
    name("estimate"),
    number().minimum(Some(Contamination::SHARE[0])).maximum(Some(Contamination::SHARE[1])),
);
