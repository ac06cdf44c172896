//! Test of residuals for correlation with their neighbours on scan lines.
//!
//! The statistic is `c = Σ rᵢrᵢ₊₁ / Σ r²` over neighbours on a line, in which Durbin and Watson's d
//! is about 2(1 − c). Residuals of white noise are correlated by the projection that makes them:
//! with M = I − QQᵀ and A holding ½ for each pair, c is `eᵀMAMe / eᵀMe`. Its first four moments
//! follow from traces of powers of MA exactly, and a beta distribution with these moments gives the
//! tail (Durbin and Watson, Biometrika 38, 1951, with two; Henshaw, Econometrica 34, 1966, with
//! four).

mod basis;
mod strength;

pub(crate) use basis::LineBasis;
pub(crate) use strength::Strength;
