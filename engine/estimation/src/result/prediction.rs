//! Heights, slopes and bands at places of the domain.

use crate::inference::SimultaneousMethod;

/// What a fit says at the places asked for, in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct Predictions {
    /// The place of each entry, from 0; there where some were left out, whose figures are beyond
    /// the range of double.
    pub place_indices: Option<Vec<usize>>,
    /// Level of the bands.
    pub level: f64,
    /// Heights of the estimate.
    pub value: Vec<f64>,
    /// Their standard errors, as those of coefficients; `None` without an estimate of the noise.
    pub std_error: Option<Vec<f64>>,
    /// Sharp bounds on their bias, given r.
    pub bias_bound: Vec<f64>,
    /// Intervals of the true height at each place by itself.
    pub confidence: Option<Vec<[f64; 2]>>,
    /// Intervals of a further measurement of weight 1 at each place by itself.
    pub prediction: Option<Vec<[f64; 2]>>,
    /// A band of the true heights of the whole domain at once.
    pub simultaneous: Option<Simultaneous>,
    /// Slopes by u (by x for a curve) and v.
    pub slopes: Vec<Slopes>,
}

/// A band that holds everywhere at once.
#[derive(Clone, Debug, PartialEq)]
pub struct Simultaneous {
    /// The band at each place.
    pub band: Vec<[f64; 2]>,
    /// Half its width in standard errors.
    pub factor: f64,
    /// Where the factor comes from.
    pub method: SimultaneousMethod,
    /// Scheffé's factor, of which the others are never larger.
    pub scheffe: f64,
}

/// Slopes along one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Slopes {
    /// Slopes of the estimate.
    pub value: Vec<f64>,
    /// Their standard errors, as those of coefficients; `None` without an estimate of the noise.
    pub std_error: Option<Vec<f64>>,
    /// Intervals of the true slope at each place by itself.
    pub confidence: Option<Vec<[f64; 2]>>,
}

/// Covariance matrices of the coefficients, the lower triangle by rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Covariance {
    /// Covariance of the estimate.
    pub coefficients: Vec<Vec<f64>>,
    /// Covariance of unregularised least squares.
    pub least_squares: Vec<Vec<f64>>,
}

fn finite<'a>(mut values: impl Iterator<Item = &'a f64>) -> bool {
    values.all(|x| x.is_finite())
}

impl Predictions {
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
        for slopes in &mut self.slopes {
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
                && self.slopes.iter().all(|slopes| {
                    number(&slopes.value) && slopes.std_error.iter().all(number) && slopes.confidence.iter().all(pair)
                })
        };
        let kept: Vec<bool> = (0..self.value.len()).map(sound).collect();
        if kept.contains(&false) {
            self.retain(&kept);
        }
    }

    /// Whether every number is one.
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
            && self.slopes.iter().all(|s| finite(s.value.iter()) && errors(&s.std_error) && bands(&s.confidence))
    }
}

impl Covariance {
    /// Whether every number is one.
    pub(crate) fn is_finite(&self) -> bool {
        finite(self.coefficients.iter().chain(&self.least_squares).flatten())
    }
}
