//! Numbers that leave the range of double precision.

/// Which numbers do.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RangeReason {
    /// Figures of the answer.
    #[error("figures of this fit leave the range of double precision: choose another unit or basis")]
    Figures,
    /// Regularised eigenvalues.
    #[error("λ* lifts an eigenvalue beyond the range of double precision")]
    Eigenvalue,
    /// Figures of a robust estimator.
    #[error("scale or sum of this estimator leave the range of double precision: choose another scale or unit")]
    Estimator,
    /// The length of a column.
    #[error(
        "the column of {label} (weights included) is about {largest:.0e} long, whose square leaves the range of \
         double precision: choose another unit or basis; weights are relative and may be divided by their largest"
    )]
    Column {
        /// Its label.
        label: String,
        /// Its largest entry.
        largest: f64,
    },
    /// Heights that are too great.
    #[error("squares of these heights leave the range of double precision: choose a larger unit")]
    GreatHeights,
    /// Heights that are too small.
    #[error("squares of these heights vanish in double precision: choose a smaller unit")]
    SmallHeights,
    /// Entries of the triangular factor.
    #[error("powers or squares of these numbers leave the range of double precision: choose another unit or basis")]
    Squares,
    /// The change to the caller's basis.
    #[error("powers of these numbers leave the range of double precision")]
    Powers,
    /// The box of the working basis.
    #[error("these abscissae leave the range of double precision")]
    Abscissae,
    /// Control values.
    #[error("these numbers leave the range of double precision: choose another unit")]
    Numbers,
    /// Heights after a filter.
    #[error("the filtered heights leave the range of double precision: choose another unit")]
    FilteredHeights,
    /// The roughness penalty.
    #[error("the square of this penalty leaves the range of double precision: choose other weights or another unit")]
    Penalty,
    /// λ times the roughness penalty.
    #[error("λ times this penalty leaves the range of double precision")]
    WeightedPenalty,
}
