//! The answer to a fit.
//!
//! A value that does not exist is left out: there is no `null` and no invented number.

use std::sync::Arc;

use super::{
    constraints::ConstraintsResultBody,
    declare::{FieldsAs, ListAs, Raw, Serialized, WriteAs, answer},
    errors::{ErrorsResult, PositionsResult, VarianceResult},
    estimable::{EstimableSumBody, MatrixBFactorsBody},
    filters::{FilterCollinearity, FilterResult},
    influence::InfluenceBody,
    parts::*,
    predictions::{CovarianceBody, PredictionsBody},
    prior::PriorResultBody,
    regularization::{RegularizationResult, RidgeTracePointBody},
    robust::RobustBody,
    selection::SelectionBody,
    shared_text,
};
use crate::api::{
    fits::spec::request::FitSpecBody,
    json::writer::Object,
    shapes::{curve_shape::CurveBody, surface_shape::SurfaceBody},
    warning::WarningBody,
};
use flankfit_engine::estimation::{
    FitResult,
    near::Shape,
    result::{CollinearityReport, Warning},
    spec::{Domain, Include, Piece},
};

/// What an answer is written from.
pub struct FitAnswer<'a> {
    pub result: &'a FitResult,
    /// The curve or surface that was fitted, where there is one.
    pub shape: Option<&'a Shape>,
    /// The digest of [`crate::api::fits::canonical`].
    pub input_sha256: &'a str,
    /// The text of the spec, where it stands in the answer.
    pub spec: Option<&'a str>,
}

answer! {
    /// The answer to a fit.
    #[schema(as = FitResult)]
    pub struct FitResultBody from FitAnswer<'a> {
        result: FitResult {
            coefficients, domain, spectrum, regularization, bias, collinearity, perturbation, residuals, robust,
            lambda_curve, ridge_trace, matrix_b, matrix_b_factors, representative, estimable, filtering, prior,
            constraints, covariance, predictions, sums: _, influence, selection, shape: _, errors,
            variance, positions, without_suspected: _, numerics, warnings,
        },
        shape, input_sha256, spec,
    } {
        /// In the order of `powers`, `index` or `column`.
        coefficients: Vec<CoefficientBody> = coefficients,
        /// The box on which mapped bases live; absent for a measurement matrix.
        domain?: Domain = domain,
        /// The fitted curve, where the nodes are of type `curve`: of the model `b_spline`, its
        /// control points being the coefficients; of `polynomial` where `shape` was included, in
        /// Bernstein pieces over `domain`, more than one where a high degree swings much. It has
        /// the fitted heights to about 1e-14 of the largest.
        curve?: CurveBody = curve(*shape),
        /// The fitted surface, where the nodes have u and v: of the model `b_spline`, its control
        /// points being the coefficients; of `polynomial` where `shape` was included, as `curve`.
        surface?: SurfaceBody = surface(*shape),
        spectrum: SpectrumBody = spectrum,
        regularization: RegularizationResult = regularization,
        bias: BiasBody = bias,
        collinearity: CollinearityBody = Shared(collinearity),
        /// Present when `node_uncertainty` was given.
        perturbation?: PerturbationBody = perturbation,
        residuals: ResidualsBody = residuals,
        /// Present for every estimator but `least_squares`.
        robust?: RobustBody = robust,
        /// Condition, bias and error along λ*; present when `lambda_curve` was included.
        lambda_curve?: Vec<LambdaCurvePointBody> = lambda_curve,
        /// The coefficients along k, ascending from 0; present with `include` of `ridge_trace` and
        /// ridge.
        ridge_trace?: Vec<RidgeTracePointBody> = ridge_trace,
        /// The rows of B in the caller's columns; present when `matrix_b` was included.
        matrix_b?: Vec<Vec<f64>> = matrix_b,
        /// Changes by each filter, in the order applied; present with filters.
        filters?: Vec<FilterResult> = filtering.as_ref().map(|report| &report.filters),
        /// B as a product; present with `matrix_b`.
        matrix_b_factors?: MatrixBFactorsBody = matrix_b_factors,
        /// The data that other fits need: V, λ* and L, as `regularization` of type `representative`
        /// takes them. Present with `include` of `representative`, if `spectral` raised an
        /// eigenvalue.
        representative?: Piece = representative,
        /// Sums of the coefficients of nearly dependent terms that are well determined; present
        /// when `collinearity` was included and some terms are nearly dependent.
        estimable?: Vec<EstimableSumBody> = estimable,
        /// Present when there were filters.
        filter_collinearity?: FilterCollinearity = filtering,
        /// Present when something was known before (`prior`).
        prior?: PriorResultBody = prior,
        /// Present when the function was constrained.
        constraints?: ConstraintsResultBody = constraints,
        /// Present when `covariance` was included.
        covariance?: CovarianceBody = covariance,
        /// Present with `predict`.
        predictions?: PredictionsBody = predictions,
        /// Present when `influence` was included and the nodes determine the coefficients.
        influence?: InfluenceBody = influence,
        /// Present when the model was chosen out of several (`select`).
        selection?: SelectionBody = selection,
        /// Present when `errors` were correlated.
        errors?: ErrorsResult = errors.as_ref().map(|found| Serialized(ErrorsResult::from(found))),
        /// Present when variances were estimated.
        variance?: VarianceResult = variance.as_ref().map(|found| Serialized(VarianceResult::from(found))),
        /// Present when the positions of the nodes were taken as off.
        positions?: PositionsResult = positions.as_ref().map(|found| Serialized(PositionsResult::from(found))),
        numerics: NumericsBody = numerics,
        /// What to know about the answer; empty where there is nothing to say.
        warnings: Vec<WarningBody> = warnings,
        provenance: ProvenanceBody = Provenance { input_sha256 },
        /// The fit request without nodes, with every default filled in. For `POST /v1/fits`; a
        /// stored fit has it next to its result.
        #[schema(value_type = Option<FitSpecBody>)]
        spec?: serde_json::Value = spec.map(Raw),
    }
}

fn curve(shape: Option<&Shape>) -> Option<Serialized<CurveBody>> {
    if let Some(Shape::Curve(curve)) = shape { Some(Serialized(CurveBody::from(curve))) } else { None }
}

fn surface(shape: Option<&Shape>) -> Option<Serialized<SurfaceBody>> {
    if let Some(Shape::Surface(surface)) = shape { Some(Serialized(SurfaceBody::of(surface, None))) } else { None }
}

/// A report that a plan may keep for the next flank; its text is then kept too.
struct Shared<'a>(&'a Arc<CollinearityReport>);

impl WriteAs<CollinearityBody> for Shared<'_> {
    fn write_as(&self, object: &mut Object<'_>, name: &'static str, include: &Include) {
        let Shared(report) = self;
        if Arc::strong_count(report) == 1 {
            return CollinearityReport::write_as(report, object, name, include);
        }
        let known = shared_text::find(report, include.collinearity);
        let written = object.known_object(name, known.as_deref(), |object| report.fields_as(object, include));
        if let Some(text) = written {
            shared_text::keep(report, include.collinearity, text);
        }
    }
}

impl WriteAs<Domain> for Domain {
    fn write_as(&self, object: &mut Object<'_>, name: &'static str, _: &Include) {
        let Domain { u, v } = self;
        object.object(name, |object| {
            for (axis, interval) in [("u", u), ("v", v)] {
                if let Some(interval) = interval {
                    object.numbers(axis, interval);
                }
            }
        });
    }
}

impl ListAs<WarningBody> for Warning {
    fn list_as(items: &[Self], object: &mut Object<'_>, name: &'static str, _: &Include) {
        object.list(name, items, |object, warning| {
            WarningBody::from(warning).write(object);
        });
    }
}
