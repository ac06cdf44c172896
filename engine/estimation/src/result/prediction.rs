//! Heights, slopes and bands at places of the domain.

use crate::inference::SimultaneousMethod;

/// Heights, slopes and bands at the places of `predict.at`, in their order (of a grid v running
/// fastest).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct Predictions {
    /// Index (from 0, in the requested order) of the place of each entry; present if some were
    /// omitted because their results exceed double precision (warning `exceeds_double`).
    pub place_indices: Option<Vec<usize>>,
    /// Level of the bands.
    pub level: f64,
    /// Heights of the estimate.
    pub value: Vec<f64>,
    /// Standard errors, those of least squares where λ* was chosen from the nodes; absent
    /// without an estimate of the noise.
    pub std_error: Option<Vec<f64>>,
    /// Sharp bounds on the bias of each height, given r; with a `prior` like
    /// `coefficients[].bias_bound`.
    pub bias_bound: Vec<f64>,
    /// `[low, high]` of the true height at each place by itself. Like
    /// `coefficients[].interval`: about least squares where no norm limit was given.
    pub confidence: Option<Vec<[f64; 2]>>,
    /// `[low, high]` of a further measurement of weight 1 at each single place. For robust fits
    /// by their own residuals, outliers included; absent for a quantile.
    pub prediction: Option<Vec<[f64; 2]>>,
    /// Band of the true heights of the whole domain at once.
    #[cfg_attr(feature = "contract", serde(flatten))]
    pub simultaneous: Option<Simultaneous>,
    /// Slopes by u (by x for a curve); there with `predict.slopes`.
    pub slope_u: Option<Slopes>,
    /// Slopes by v.
    pub slope_v: Option<Slopes>,
}

/// A band that holds everywhere at once.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema))]
pub struct Simultaneous {
    /// `[low, high]` of the true heights of the whole domain at once, at each place; with a
    /// linear model of all requested rows at once. About least squares; with a norm limit, and
    /// a λ* that does not depend on the heights, about the estimate if that band is narrower on
    /// average.
    #[cfg_attr(feature = "contract", serde(rename = "simultaneous"))]
    pub band: Vec<[f64; 2]>,
    /// Half the width of `simultaneous` in standard errors, the largest of all places.
    #[cfg_attr(feature = "contract", serde(rename = "simultaneous_factor"))]
    pub factor: f64,
    /// Method for the factor.
    #[cfg_attr(feature = "contract", serde(rename = "simultaneous_method"))]
    pub method: SimultaneousMethod,
    /// Scheffé's factor √(nF), which is never smaller than the factor used.
    pub scheffe: f64,
}

/// Slopes along one axis, in the unit of the heights over that of the axis.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct Slopes {
    /// Slopes of the estimate.
    pub value: Vec<f64>,
    /// Standard errors of the slopes.
    pub std_error: Option<Vec<f64>>,
    /// `[low, high]` of the true slope at each place by itself.
    pub confidence: Option<Vec<[f64; 2]>>,
}

/// Covariance matrices of the coefficients, in their order: the lower triangle by rows, row j
/// having j + 1 numbers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema))]
pub struct Covariance {
    /// Covariance of the estimate for the λ* used.
    pub coefficients: Vec<Vec<f64>>,
    /// Covariance of the unregularised estimate: least squares, or the robust estimate.
    pub least_squares: Vec<Vec<f64>>,
}

fn finite<'a>(mut values: impl Iterator<Item = &'a f64>) -> bool {
    values.all(|x| x.is_finite())
}

impl Predictions {
    fn slopes(&self) -> impl Iterator<Item = &Slopes> {
        self.slope_u.iter().chain(&self.slope_v)
    }

    /// Leaves out the entries for which `kept` says no.
    fn retain(&mut self, kept: &[bool]) {
        fn entries<T: Clone>(list: &mut Vec<T>, kept: &[bool]) {
            *list = list.iter().zip(kept).filter(|(_, kept)| **kept).map(|(entry, _)| entry.clone()).collect();
        }
        let all = || (0..self.value.len()).collect();
        let mut indices = self.place_indices.take().unwrap_or_else(all);
        entries(&mut indices, kept);
        self.place_indices = Some(indices);
        let values = [Some(&mut self.value), Some(&mut self.bias_bound), self.std_error.as_mut()];
        values.into_iter().flatten().for_each(|list| entries(list, kept));
        let bands = [&mut self.confidence, &mut self.prediction].into_iter().flatten();
        bands.chain(self.simultaneous.as_mut().map(|found| &mut found.band)).for_each(|list| entries(list, kept));
        for slopes in [&mut self.slope_u, &mut self.slope_v].into_iter().flatten() {
            [Some(&mut slopes.value), slopes.std_error.as_mut()]
                .into_iter()
                .flatten()
                .for_each(|list| entries(list, kept));
            slopes.confidence.iter_mut().for_each(|list| entries(list, kept));
        }
    }

    /// Leaves out places whose figures are not all numbers.
    pub(crate) fn retain_finite(&mut self) {
        let sound = |k: usize| {
            let number = |list: &Vec<f64>| list[k].is_finite();
            let pair = |list: &Vec<[f64; 2]>| list[k].iter().all(|x| x.is_finite());
            number(&self.value)
                && number(&self.bias_bound)
                && self.std_error.iter().all(number)
                && self.confidence.iter().chain(&self.prediction).all(pair)
                && self.simultaneous.iter().all(|found| pair(&found.band))
                && self.slopes().all(|slopes| {
                    number(&slopes.value) && slopes.std_error.iter().all(number) && slopes.confidence.iter().all(pair)
                })
        };
        let kept: Vec<bool> = (0..self.value.len()).map(sound).collect();
        if kept.contains(&false) {
            self.retain(&kept);
        }
    }

    /// True if every number is finite.
    pub(crate) fn is_finite(&self) -> bool {
        let errors = |errors: &Option<Vec<f64>>| finite(errors.iter().flatten());
        let bands = |bands: &Option<Vec<[f64; 2]>>| finite(bands.iter().flatten().flatten());
        finite(self.value.iter().chain(&self.bias_bound))
            && errors(&self.std_error)
            && bands(&self.confidence)
            && bands(&self.prediction)
            && self
                .simultaneous
                .iter()
                .all(|band| finite(band.band.iter().flatten().chain([&band.factor, &band.scheffe])))
            && self.slopes().all(|s| finite(s.value.iter()) && errors(&s.std_error) && bands(&s.confidence))
    }
}

impl Covariance {
    /// True if every number is finite.
    pub(crate) fn is_finite(&self) -> bool {
        finite(self.coefficients.iter().chain(&self.least_squares).flatten())
    }
}
