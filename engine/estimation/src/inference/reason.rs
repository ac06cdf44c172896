//! Errors in requested intervals and predictions.

use flankfit_numerics::fault::words::{Shown, counted};

/// Why a level or places of predictions are refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InferenceReason {
    /// A level that no interval has.
    #[error("{} is not a level: above 0.5 and below 1", Shown(*.0))]
    Level(f64),
    /// No place at all.
    #[error("there are no places")]
    NoPlaces,
    /// More work than a request may ask for.
    #[error("{places} places, more than the {most} that a fit of this size may be asked for")]
    ManyPlaces {
        /// Places asked for.
        places: usize,
        /// Places at most.
        most: usize,
    },
    /// Points without a partner.
    #[error("{u} abscissae along u and {v} along v make no points: give as many of each")]
    Unequal {
        /// Abscissae along u.
        u: usize,
        /// Abscissae along v.
        v: usize,
    },
    /// Points of a surface asked of a curve.
    #[error("a curve is asked for at abscissae, not at points of a surface")]
    OfCurve,
    /// Abscissae asked of a surface.
    #[error("a surface is asked for at points or on a grid, not at abscissae of a curve")]
    OfSurface,
    /// Points or abscissae asked of a measurement matrix.
    #[error("a measurement matrix has no places: it is asked for at rows of its columns")]
    OfMatrix,
    /// Rows asked of a curve or a surface.
    #[error("rows of columns are those of a measurement matrix: a curve or a surface is asked for at places")]
    OfFunction,
    /// A row without a number for each column, or with more.
    #[error("{} in a row, where the matrix has {columns}", counted(*.given, "number", "numbers"))]
    RowLength {
        /// Numbers of the row.
        given: usize,
        /// Columns of the matrix.
        columns: usize,
    },
    /// Slopes of columns that are no functions.
    #[error("columns have no slopes")]
    NoSlopes,
}
