//! Requested places of predictions, and their bands.

#[cfg(feature = "contract")]
use super::form;

/// Heights, slopes and bands of the fitted curve or surface at places of its domain.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "form::Predict", into = "form::Predict")
)]
pub struct Predict {
    /// The places.
    pub at: Places,
    /// Level of the bands; that of the fit's intervals where `None`.
    pub level: Option<f64>,
    /// Kinds of bands.
    pub kinds: Kinds,
    /// Slopes with their confidence intervals in addition to the heights.
    pub slopes: bool,
}

/// Places, in the caller's unit.
#[derive(Clone, Debug, PartialEq)]
pub enum Places {
    /// Abscissae of a curve.
    Curve(Vec<f64>),
    /// Points of a surface: u and v of each.
    Points {
        /// u of each point.
        u: Vec<f64>,
        /// v of each point, as many.
        v: Vec<f64>,
    },
    /// Every combination of the axes, v running fastest.
    Grid {
        /// Abscissae along u.
        u: Vec<f64>,
        /// Abscissae along v.
        v: Vec<f64>,
    },
    /// Rows of a measurement matrix, with its columns.
    Rows(Vec<Vec<f64>>),
}

impl Places {
    /// Number of places.
    pub fn count(&self) -> usize {
        match self {
            Places::Curve(x) => x.len(),
            Places::Points { u, .. } => u.len(),
            Places::Grid { u, v } => u.len().saturating_mul(v.len()),
            Places::Rows(rows) => rows.len(),
        }
    }

    /// u and v of place k, v being 0 for a curve; `None` of rows, which have no place.
    pub fn at(&self, k: usize) -> Option<[f64; 2]> {
        match self {
            Places::Curve(x) => Some([x[k], 0.0]),
            Places::Points { u, v } => Some([u[k], v[k]]),
            Places::Grid { u, v } => Some([u[k / v.len()], v[k % v.len()]]),
            Places::Rows(_) => None,
        }
    }
}

/// Bands about the heights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kinds {
    /// For the true height at each place by itself.
    pub confidence: bool,
    /// For a further measurement of weight 1 at each place by itself.
    pub prediction: bool,
    /// For the true heights of the whole domain at once; for rows those of all requested rows.
    pub simultaneous: bool,
}

impl Default for Kinds {
    fn default() -> Self {
        Kinds { confidence: true, prediction: false, simultaneous: false }
    }
}
