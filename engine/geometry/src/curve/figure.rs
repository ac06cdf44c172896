//! Common parts of the figures of stability: the reason for a missing one, and the order of the
//! nodes.

/// Why a figure does not exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Absence {
    /// The tangents depend on the values in a nonlinear way, so that there is no constant.
    #[error("the rule of the tangents is not linear in the values, so no constant bounds the amplification")]
    NotLinear,
    /// The curve is made piece by piece, without equations to be conditioned.
    #[error("the curve is built piece by piece; no equations are solved")]
    NoEquations,
    /// More conditions than the figure is computed for.
    #[error("{nodes} conditions are more than the {most} for which the result is computed")]
    TooMany {
        /// Conditions of the curve.
        nodes: usize,
        /// Conditions up to which the figure is computed.
        most: usize,
    },
    /// The figure is outside the range of a double.
    #[error("the result exceeds the range of double precision")]
    NotFinite,
}

/// Indices of the parameters in ascending order.
pub(super) fn ascending(parameters: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..parameters.len()).collect();
    order.sort_by(|a, b| parameters[*a].total_cmp(&parameters[*b]));
    order
}
