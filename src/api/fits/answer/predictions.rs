//! Covariances and predictions of a fit's answer.

use super::declare::{FieldsAs, ListAs, WriteAs, answer, names};
use crate::api::json::writer::Object;
use flankfit_engine::estimation::{
    inference::SimultaneousMethod,
    result::{Covariance, Predictions, Slopes},
    spec::Include,
};

answer! {
    /// Covariance matrices of the coefficients, in their order: the lower triangle by rows, row j
    /// having j + 1 numbers.
    #[schema(as = Covariance)]
    pub struct CovarianceBody from Covariance { coefficients, least_squares } {
        /// Covariance of the estimate for the λ* used.
        coefficients: Vec<Vec<f64>> = coefficients,
        /// Covariance of the unregularised estimate: least squares, or the robust estimate.
        least_squares: Vec<Vec<f64>> = least_squares,
    }
}

answer! {
    /// Heights, slopes and bands at the places of `predict.at`, in their order (of a grid v running
    /// fastest).
    #[schema(as = Predictions)]
    pub struct PredictionsBody from Predictions {
        place_indices, level, value, std_error, bias_bound, confidence, prediction, simultaneous, slopes,
    } {
        /// Index (from 0, in the requested order) of the place of each entry; present when some
        /// were left out because their figures exceed double precision (warning `beyond_double`).
        place_indices?: Vec<usize> = place_indices,
        /// Level of the bands.
        level: f64 = level,
        /// Heights of the estimate.
        value: Vec<f64> = value,
        /// Standard errors, those of least squares where λ* was chosen from the nodes; absent
        /// without an estimate of the noise.
        std_error?: Vec<f64> = std_error,
        /// Sharp bounds on the bias of each height, given r; with a `prior` as those of
        /// `coefficients[].bias_bound`.
        bias_bound: Vec<f64> = bias_bound,
        /// `[low, high]` of the true height at each place by itself. Like
        /// `coefficients[].interval`: about least squares where no norm limit was given.
        confidence?: Vec<[f64; 2]> = confidence,
        /// `[low, high]` of a further measurement of weight 1 at each single place. For robust fits
        /// by their own residuals, outliers included; absent for a quantile.
        prediction?: Vec<[f64; 2]> = prediction,
        /// `[low, high]` of the true heights of the whole domain at once, at each place; with a
        /// linear model of all requested rows at once. About least squares; with a norm limit, and
        /// a λ* that does not depend on the heights, about the estimate if that band is narrower on
        /// average.
        simultaneous?: Vec<[f64; 2]> = simultaneous.as_ref().map(|all| &all.band),
        simultaneous_method?: SimultaneousMethodName = simultaneous.as_ref().map(|all| &all.method),
        /// Half the width of `simultaneous` in standard errors, the largest of all places.
        simultaneous_factor?: f64 = simultaneous.as_ref().map(|all| all.factor),
        /// Scheffé's factor √(nF), of which no other is larger where it is used.
        scheffe?: f64 = simultaneous.as_ref().map(|all| all.scheffe),
        /// Slopes by u (by x for a curve); there with `predict.slopes`.
        slope_u?: SlopesBody = slopes.first(),
        /// Slopes by v.
        slope_v?: SlopesBody = slopes.get(1),
    }
}

answer! {
    /// Slopes along one axis, in the unit of the heights over that of the axis.
    #[schema(as = Slopes)]
    pub struct SlopesBody from Slopes { value, std_error, confidence } {
        /// Slopes of the estimate.
        value: Vec<f64> = value,
        /// Standard errors of the slopes.
        std_error?: Vec<f64> = std_error,
        /// `[low, high]` of the true slope at each place by itself.
        confidence?: Vec<[f64; 2]> = confidence,
    }
}

names! {
    /// Method for the factor of a simultaneous band: Scheffé's, or, where that is narrower, the
    /// volume of a tube (Naiman; Sun and Loader; curves and surfaces) or Student's t at the level
    /// divided by the number of rows (Bonferroni; rows of a measurement matrix).
    #[schema(as = SimultaneousMethod)]
    pub enum SimultaneousMethodName from SimultaneousMethod {
        Scheffe = "scheffe",
        Tube = "tube",
        Bonferroni = "bonferroni",
    }
}
