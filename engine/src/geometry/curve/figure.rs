//! What the figures of stability share: why one does not exist, and the order of the nodes.

/// Why a figure does not exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Absence {
    #[error("the rule of the tangents is not linear in the values, so that no constant bounds the amplification")]
    NotLinear,
    #[error("the curve is made piece by piece; no equations are solved")]
    NoEquations,
    #[error("{nodes} conditions are more than the {most} for which the figure is computed")]
    TooMany { nodes: usize, most: usize },
    #[error("the figure is beyond the range of a double")]
    NotFinite,
}

/// Indices of the parameters in ascending order.
pub(super) fn ascending(parameters: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..parameters.len()).collect();
    order.sort_by(|a, b| parameters[*a].total_cmp(&parameters[*b]));
    order
}
