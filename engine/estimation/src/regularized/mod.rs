//! The regularised estimate in the form that the answer reports.
//!
//! Every kind is an estimate `T + H(Â − T)` in the scaled columns:
//!
//! | kind | H | where |
//! |---|---|---|
//! | none, spectral, ridge | `V diag(f) Vᵀ`, eigenvectors V of the Fisher information matrix | [`spectral`] |
//! | B of a representative piece | `1 − V diag(1 − f) Vᵀ`, directions V of the piece | [`representative`] |
//! | truncated SVD | the same with f 0 or 1 | [`truncated`] |
//! | James–Stein, attraction | `c I` toward the target T, or `c I` on all but the constant | [`shrink`] |
//! | posterior of a prior | its gain, toward a mixture of means | [`prior`] |
//! | constrained | the projection orthogonal to the active places, those held | [`constrained`] |
//! | Tikhonov | `Z diag(f) Z⁻¹`, directions Z of the pair (X, penalty), oblique in the scaled columns | [`tikhonov`] |

mod admissible;
mod apply;
mod bias;
mod chosen_rank;
mod constrained;
mod context;
mod corrected;
mod double_pair;
mod error_interval;
mod extreme;
mod linear_map;
mod node_shares;
mod normal_system;
mod oblique;
mod oblique_choice;
mod pair;
mod parity;
mod penalty;
mod prior;
mod prior_applied;
mod rational_penalty;
mod removal;
mod report;
mod representative;
mod shrink;
mod spectral;
mod target;
mod tikhonov;
mod trace;
mod truncated;

pub(crate) use admissible::check_admissible;
pub(crate) use apply::apply;
pub(crate) use context::{Applied, Context};
pub(crate) use linear_map::{Form, LinearMap};
pub(crate) use node_shares::{criterion_path, nodes_not_kept};
pub(crate) use report::regularized_spectrum;
