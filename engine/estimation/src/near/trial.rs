//! The fit of all coordinates with one knot vector.

use super::{
    points::{CurvePoints, translated},
    settings::CurveSettings,
};
use crate::{
    data::Nodes,
    design::{MOST_COEFFICIENTS, no_span},
    error::FitError,
    fit::fit_together,
    result::FitResult,
    spec::{Degree, FitSpec, Include, Knots, Model},
};
use flankfit_geometry::{
    BSplineBasis,
    curve::BSplineCurve,
    space::{Dimension, Vector},
};
use flankfit_numerics::check::{Fault, Faults};

/// The points with everything but the knots.
pub(super) struct Trial<'a> {
    pub points: &'a CurvePoints<'a>,
    pub asked: &'a CurveSettings,
    pub dimension: Dimension,
    pub parameters: &'a [f64],
}

/// All coordinates with one knot vector.
pub(super) struct Fitted {
    pub basis: BSplineBasis,
    pub results: Vec<FitResult>,
    /// Posted number and distance of every counted point.
    pub errors: Vec<(usize, f64)>,
    pub spec: FitSpec,
}

impl Trial<'_> {
    /// The curve that the coefficients of all coordinates are the control points of.
    pub(super) fn shape(&self, fitted: &Fitted) -> Result<BSplineCurve, FitError> {
        let coordinate =
            |i: usize, c: usize| fitted.results.get(c).map_or(0.0, |result: &FitResult| result.coefficients[i].value);
        let controls = (0..fitted.basis.size()).map(|i| Vector::from_fn(|c, _| coordinate(i, c))).collect();
        BSplineCurve::new(fitted.basis.clone(), self.dimension, controls, self.asked.weights.clone())
            .map_err(|faults| FitError::from(faults.map(|fault| Fault { path: "method".to_owned(), ..fault })))
    }

    /// Fits with these knots.
    pub(super) fn fit(&self, knots: Knots) -> Result<Fitted, FitError> {
        let Knots::Curve(full) = &knots else {
            return Err(Faults::one("model.knots", "one knot vector").into());
        };
        let basis =
            BSplineBasis::new(self.asked.degree, full.clone()).map_err(|faults| faults.within("model.knots"))?;
        let degree = Degree::Both(self.asked.degree);
        let include = Include { residuals: true, ..self.asked.spec.include };
        let model = Model::BSpline { degree, knots, weights: self.asked.weights.clone() };
        let spec = FitSpec { model, include, ..self.asked.spec.clone() };
        let weight = self.points.weight.map(<[f64]>::to_vec);
        let nodes = self
            .points
            .coordinates
            .iter()
            .map(|y| Nodes::curve(self.parameters.to_vec(), y.clone(), weight.clone()))
            .collect::<Result<Vec<Nodes>, Faults>>()
            .map_err(|faults| translated(self.points, faults.within("nodes")))?;
        let results = fit_together(&nodes, &spec).map_err(|error| match error {
            FitError::Invalid(faults) | FitError::ExceedsDouble(faults) => translated(self.points, faults).into(),
            other => other,
        })?;
        let mut squares = Vec::new();
        for result in &results {
            let values = result.residuals.values.as_deref().unwrap_or_default();
            squares.resize(values.len(), 0.0);
            squares.iter_mut().zip(values).for_each(|(sum, r)| *sum += r * r);
        }
        let counted = results.first().and_then(|result| result.residuals.node_indices.clone());
        let errors = squares
            .iter()
            .enumerate()
            .map(|(k, square)| (counted.as_ref().map_or(k, |counted| counted[k]), square.sqrt()))
            .collect();
        Ok(Fitted { basis, results, errors, spec })
    }
}

/// Largest and root mean square.
pub(super) fn summary(errors: &[(usize, f64)]) -> (f64, f64) {
    let squares: f64 = errors.iter().map(|(_, e)| e * e).sum();
    (errors.iter().map(|(_, e)| *e).fold(0.0, f64::max), (squares / errors.len().max(1) as f64).sqrt())
}

/// Equal spans.
pub(super) fn uniform(degree: usize, spans: usize, [low, high]: [f64; 2]) -> Result<BSplineBasis, Faults> {
    if spans == 0 {
        return Err(no_span("model.spans"));
    }
    if spans.saturating_add(degree) > MOST_COEFFICIENTS {
        return Err(Faults::one("model.spans", format_args!("{spans} spans are too many for a fit")));
    }
    BSplineBasis::uniform(degree, spans, low, high)
        .map_err(|faults| faults.map(|fault| Fault { path: "model.spans".to_owned(), ..fault }))
}
