//! How much each node has a say in a fit, as it is answered.

use super::declare::{FieldsAs, ListAs, WriteAs, answer};
use crate::api::json::writer::Object;
use flankfit_engine::estimation::{result::Influence, spec::Include};

answer! {
    /// Influence of each counted node on the fit, in the order of `residuals.values`; null where a
    /// figure does not exist: without a node of leverage 1 the other nodes do not determine the fit
    /// (warning `full_leverage`), and figures that are divided by σ̂ need noise (warning
    /// `no_noise_without`). For a regularised fit the penalty of all nodes is held fixed: λ* is not
    /// chosen again without a node. Residuals include √weight where nodes have weights.
    #[schema(as = Influence)]
    pub struct InfluenceBody from Influence {
        leverage, internally_studentized, externally_studentized, cooks_distance, dffits, press_residual, press,
        node_indices,
    } {
        /// hᵢ, from 0 to 1: derivative of the fitted height with respect to the node's own height.
        /// The sum over the nodes is the effective number of coefficients.
        leverage: Vec<f64> = leverage,
        /// √wᵢ rᵢ / (σ̂ √(1 − hᵢ)), σ̂ being `residuals.sigma`; null where σ̂ is 0. Absent without
        /// degrees of freedom.
        internally_studentized?: Vec<Option<f64>> = internally_studentized,
        /// The same with the σ̂ of least squares without the node: for normal errors and no
        /// regularisation, Student's t with m − n − 1 degrees of freedom; null where the other
        /// nodes are fitted exactly. Absent without these degrees of freedom.
        externally_studentized?: Vec<Option<f64>> = externally_studentized,
        /// Cook's distance: Σ w (change of the fitted heights without the node)² / (σ̂² Σh); null
        /// where σ̂ is 0.
        cooks_distance?: Vec<Option<f64>> = cooks_distance,
        /// Change of the node's own fitted height without it, in standard errors of that height
        /// with the σ̂ of the other nodes; null where those are fitted exactly.
        dffits?: Vec<Option<f64>> = dffits,
        /// rᵢ/(1 − hᵢ), in the unit of the heights: the height minus the prediction by a fit to the
        /// other nodes.
        press_residual: Vec<Option<f64>> = press_residual,
        /// Σ w r²/(1 − h)²: the sum of squares of leave-one-out cross-validation. Absent where a
        /// node has leverage 1.
        press?: f64 = press,
        /// The posted node (from 0, grids row by row) of each entry; present when some node was
        /// left out.
        node_indices?: Vec<usize> = node_indices,
    }
}
