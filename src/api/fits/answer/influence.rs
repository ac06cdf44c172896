//! How much each node has a say in a fit, as it is answered.

use super::declare::{FieldsAs, ListAs, WriteAs, answer};
use crate::api::json::writer::Object;
use flankfit_engine::estimation::{result::Influence, spec::Include};

answer! {
    /// How much each counted node has a say in the fit, in the order of `residuals.values`; null
    /// where a figure does not exist: without a node of leverage 1 the others do not determine the
    /// fit there (warning `full_leverage`), and figures that divide by a σ̂ need some noise
    /// (warning `no_noise_without`). A regularised fit is looked at with its penalty held as all
    /// nodes made it: λ* is not chosen anew without a node. Sizes count √weight where nodes carry
    /// weights.
    #[schema(as = Influence)]
    pub struct InfluenceBody from Influence {
        leverage, internally_studentized, externally_studentized, cooks_distance, dffits, press_residual, press,
        node_indices,
    } {
        /// hᵢ, from 0 to 1: the share of the node's own height in what is fitted there. Their sum
        /// is the number of coefficients, or what regularisation leaves of it.
        leverage: Vec<f64> = leverage,
        /// √wᵢ rᵢ / (σ̂ √(1 − hᵢ)), σ̂ being `residuals.sigma`; null where σ̂ is 0. Absent without
        /// degrees of freedom.
        internally_studentized?: Vec<Option<f64>> = internally_studentized,
        /// The same with the σ̂ of least squares on the other nodes: where errors are normal and
        /// nothing is regularised, Student's t of m − n − 1 degrees of freedom; null where the
        /// other nodes are fitted exactly: this one stands out of nothing. Absent without these.
        externally_studentized?: Vec<Option<f64>> = externally_studentized,
        /// Cook's distance: Σ w (change of the fitted heights without the node)² / (σ̂² Σh); null
        /// where σ̂ is 0.
        cooks_distance?: Vec<Option<f64>> = cooks_distance,
        /// Change of the node's own fitted height without it, in standard errors of that height
        /// with the σ̂ of the other nodes; null where those are fitted exactly.
        dffits?: Vec<Option<f64>> = dffits,
        /// rᵢ/(1 − hᵢ), in the unit of the heights: the height less what the fit to the other nodes
        /// says there.
        press_residual: Vec<Option<f64>> = press_residual,
        /// Σ w r²/(1 − h)²: the sum of squares of leave-one-out cross-validation. Absent where a
        /// node has leverage 1.
        press?: f64 = press,
        /// The posted node (from 0, grids row by row) of each entry; present when some node was
        /// left out.
        node_indices?: Vec<usize> = node_indices,
    }
}
