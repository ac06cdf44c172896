//! Nodes that are left out together in blocked cross-validation.

#[cfg(feature = "contract")]
use super::form;

/// Nodes that form a block. Errors of neighbours are alike (one scan line, one setting of the
/// probe), so single nodes are predicted too well by their neighbours; adjacent rows are left out
/// as one block.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{Criterion, Folds, FoldsBy, Model, Parameter, Regularization},
/// };
///
/// // Twelve rows of a measurement matrix with two columns nearly one; blocks of three rows.
/// let t = |k: i32| f64::from(k) / 6.0 - 1.0;
/// let rows = (0..12).flat_map(|k| [1.0, t(k), t(k) + 0.1 * t(k).powi(3)]).collect();
/// let heights = (0..12).map(|k| 3.0 + 4.0 * t(k) + 0.2 * (37.0 * t(k)).sin()).collect();
/// let nodes = Nodes::matrix(rows, 3, heights, None, None)?;
/// let parameter = Parameter::Criterion(Criterion::BlockedCv);
/// let spec = FitSpec {
///     regularization: Regularization::Ridge { parameter },
///     folds: Some(Folds { by: FoldsBy::Rows, count: Some(4) }),
///     ..FitSpec::new(Model::Linear)
/// };
/// assert!(fit(&nodes, &spec)?.regularization.lambda_star.is_some_and(|k| k > 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Default)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "form::Folds", into = "form::Folds")
)]
pub struct Folds {
    /// Unit of nodes that stays together.
    pub by: FoldsBy,
    /// Number of blocks, each of neighbouring rows; by default ten, or one for each row where there
    /// are fewer.
    pub count: Option<usize>,
}

/// Unit of nodes that stays together.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub enum FoldsBy {
    /// Nodes of one u (of one x on a curve), or single rows of a measurement matrix.
    #[default]
    Rows,
    /// Nodes of one v of a surface.
    Columns,
    /// Nodes of one scan line: its number for each node, in the order posted.
    Lines(Vec<i64>),
}

impl FoldsBy {
    /// Stable name.
    pub fn name(&self) -> &'static str {
        match self {
            FoldsBy::Rows => "rows",
            FoldsBy::Columns => "columns",
            FoldsBy::Lines(_) => "lines",
        }
    }
}
