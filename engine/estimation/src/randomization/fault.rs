//! Which part of a request for a study is at fault, and why.

use std::fmt;

use flankfit_numerics::fault::{
    Faults,
    words::{Shown, counted, entries},
};

/// A part of what is asked for; indices count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StudyField {
    /// X.
    Matrix,
    /// A row of X.
    Row(usize),
    /// A.
    Coefficients,
    /// One of them.
    Coefficient(usize),
    /// σ of a height.
    NoiseSigma,
    /// All k.
    Levels,
    /// One of them.
    Level(usize),
    /// How often each k is drawn.
    Repetitions,
}

/// Why it is at fault.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StudyReason {
    /// A matrix without rows or columns.
    #[error("the matrix is empty")]
    EmptyMatrix,
    /// A row of another length than the first one.
    #[error("{}, but the first row has {first}", entries(*.given))]
    Row {
        /// Entries.
        given: usize,
        /// Entries of the first row.
        first: usize,
    },
    /// A matrix of zeros.
    #[error("every entry is 0: there is nothing to randomise")]
    ZeroMatrix,
    /// Fewer rows than columns.
    #[error("{columns} coefficients cannot be determined from {}", counted(*.rows, "row", "rows"))]
    FewRows {
        /// Rows.
        rows: usize,
        /// Columns.
        columns: usize,
    },
    /// Another number of coefficients than columns.
    #[error("{}, but the matrix has {}", entries(*.given), counted(*.columns, "column", "columns"))]
    Coefficients {
        /// Coefficients.
        given: usize,
        /// Columns.
        columns: usize,
    },
    /// A standard deviation that is none.
    #[error("{} is not a deviation: 0 or more", Shown(*.0))]
    NoiseSigma(f64),
    /// No level, or too many.
    #[error("{given} levels; 1 to {most} can be asked for")]
    Levels {
        /// Levels.
        given: usize,
        /// At most.
        most: usize,
    },
    /// A level that is no ratio.
    #[error("{} is not a ratio of deviations: 0 or more", Shown(*.0))]
    Level(f64),
    /// No repetition, or too many.
    #[error("{given} repetitions; 1 to {most} can be asked for")]
    Repetitions {
        /// Repetitions.
        given: usize,
        /// At most.
        most: usize,
    },
    /// More work than a study may take.
    #[error(
        "{levels} levels × {repetitions} repetitions × {rows} rows × {columns}² columns are {work}, more than the \
         {most} that a study may take"
    )]
    Work {
        /// Levels.
        levels: usize,
        /// Repetitions of each.
        repetitions: usize,
        /// Rows of the matrix.
        rows: usize,
        /// Columns of the matrix.
        columns: usize,
        /// The product.
        work: usize,
        /// At most.
        most: usize,
    },
    /// Columns whose squares overflow or vanish.
    #[error("squares in {} leave the range of double precision: choose another unit", Columns(.0))]
    Columns(Vec<usize>),
    /// A coefficient whose square overflows.
    #[error("the square of this coefficient leaves the range of double precision: choose another unit")]
    Coefficient,
}

/// Columns by their numbers.
struct Columns<'a>(&'a [usize]);

impl fmt::Display for Columns<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.len() == 1 { "column " } else { "the columns " })?;
        for (k, column) in self.0.iter().enumerate() {
            let between = if k == 0 { "" } else { ", " };
            write!(f, "{between}{column}")?;
        }
        Ok(())
    }
}

/// Faults of a study.
pub type StudyFaults = Faults<StudyField, StudyReason>;
