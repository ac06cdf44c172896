//! The teeth that a correction of the gear was made for.

use serde::{Deserialize, Serialize};
use serde_json::json;
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::{
    blocks::{Block, Blocks},
    figures::SidedBody,
};
use crate::{api::warning::WarningBody, jobs::side_name};
use flankfit_engine::gear::Side;

/// Teeth whose mean was used to correct a flank.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = CorrectedTeeth)]
pub struct TeethBody {
    /// The iteration of each tooth. The mean is taken at the nodes of the first one, which has the
    /// most nodes (if several do, the newest).
    pub iterations: Vec<u32>,
    /// Names of the teeth in the same order; iterations without one are omitted.
    pub teeth: Vec<String>,
    /// s, the standard deviation between teeth at a node (root mean square over the nodes), about
    /// the teeth's means where the deviations have no datum. It includes the noise of the
    /// measurement. Absent for one tooth.
    pub spread_um: Option<f64>,
    /// Standard error of the mean at a node: the root of max(s², v)/t, with v the mean variance of
    /// the residuals of the teeth's surfaces of second order and t the number of teeth. Absent
    /// where neither is known.
    pub std_error_um: Option<f64>,
}

/// Returns the teeth of each flank that was measured.
pub(super) fn of(nodes: &Blocks) -> SidedBody<TeethBody> {
    SidedBody::new(|side| {
        let block = nodes.blocks.iter().find(|block| block.side == Some(side))?;
        Some(TeethBody {
            iterations: block.numbers.clone(),
            teeth: block.teeth.clone(),
            spread_um: block.mean.spread,
            std_error_um: block.mean.std_error(),
        })
    })
}

/// Warns of a single tooth and of a flank that was not measured.
pub(super) fn warnings(nodes: &Blocks) -> Vec<WarningBody> {
    let mut warnings = Vec::new();
    let named = |block: &Block| block.side.map(side_name);
    let single: Vec<&str> = nodes.blocks.iter().filter(|block| block.mean.count == 1).filter_map(named).collect();
    if !single.is_empty() {
        let message = format!("{} flank: one tooth only; the spread between teeth is not known", single.join(" and "));
        warnings.push(WarningBody::new("one_tooth", message).with_values(&json!({"flanks": single})));
    }
    let measured = |side: Side| nodes.blocks.iter().any(|block| block.side == Some(side));
    for side in [Side::Left, Side::Right].into_iter().filter(|side| !measured(*side)) {
        let message = format!(
            "the {} flank was not measured since the last correction: the effect of settings for both flanks on it is \
             not known",
            side_name(side)
        );
        let flanks = json!({"flanks": [side_name(side)]});
        warnings.push(WarningBody::new("flank_not_measured", message).with_values(&flanks));
    }
    warnings
}
