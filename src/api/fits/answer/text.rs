//! A fit's answer as JSON text, written from the domain's result at once.
//!
//! What is written is what [`FitResultBody`](super::result::FitResultBody) documents, field for
//! field and in its order; the tests read every text into it and write it again to the same bytes.
//! Each record is taken apart completely, so a field that is added to the domain's result and not
//! written here does not compile.
//!
//! That numbers are finite has been looked at by the fit (`estimation::diagnostics::finite`); the
//! writer only refuses to write one that is not.

use std::sync::Arc;

use super::{robust, shared_text};
use crate::{
    api::{
        fits::spec::filters,
        json::writer::{Json, NotFinite, Object},
        shapes::{curve_shape::CurveBody, surface_shape::SurfaceBody},
    },
    jobs::scheme_name,
};
use flankfit_engine::estimation::{
    FitResult,
    near::Shape,
    result::{
        Arithmetic, BiasReport, Choice, Coefficient, CollinearityReport, ColumnCollinearity, LambdaCurvePoint,
        NearDependency, Numerics, PerturbationBounds, PerturbationReport, RegularizationKind, RegularizationReport,
        RegularizedSpectrum, ResidualReport, RidgeTracePoint, SpectrumReport, TermKey, Warning,
    },
    spec::{Criterion, Domain, Include},
};

/// The text of an answer. `shape` is the curve or surface that was fitted, where there is one;
/// `input_sha256` is the digest of [`crate::api::fits::canonical`]. What grows with the nodes or with the
/// square of the coefficients is written only where it is included.
pub fn write(
    result: &FitResult,
    shape: Option<&Shape>,
    input_sha256: &str,
    include: Include,
) -> Result<Vec<u8>, NotFinite> {
    let FitResult {
        coefficients,
        domain,
        spectrum,
        regularization,
        bias,
        collinearity,
        perturbation,
        residuals,
        robust,
        lambda_curve,
        ridge_trace,
        matrix_b,
        filtering,
        numerics,
        warnings,
    } = result;
    let n = coefficients.len();
    let values = residuals.values.as_ref().map_or(0, Vec::len)
        + robust.as_ref().filter(|_| include.robust_weights).map_or(0, |report| report.weights.len())
        + matrix_b.as_ref().map_or(0, |rows| rows.len() * n);
    // About what the text takes, so that it is laid once: some 20 bytes a number.
    let squares = if include.collinearity { 3 * n * n } else { 0 };
    let mut json = Json::with_capacity(4096 + 22 * (squares + 24 * n + values));
    let mut object = json.object();
    object.list("coefficients", coefficients, write_coefficient);
    if let Some(Domain { u, v }) = domain {
        object.object("domain", |object| {
            for (axis, interval) in [("u", u), ("v", v)] {
                if let Some(interval) = interval {
                    object.numbers(axis, interval);
                }
            }
        });
    }
    match shape {
        Some(Shape::Curve(curve)) => object.field("curve", &CurveBody::from(curve)),
        Some(Shape::Surface(surface)) => object.field("surface", &SurfaceBody::of(surface, None)),
        None => &mut object,
    };
    object
        .object("spectrum", |object| write_spectrum(object, spectrum))
        .object("regularization", |object| write_regularization(object, regularization))
        .object("bias", |object| write_bias(object, bias));
    if Arc::strong_count(collinearity) > 1 {
        // A plan keeps the report for the next flank.
        let known = shared_text::find(collinearity, include.collinearity);
        let written = object.known_object("collinearity", known.as_deref(), |object| {
            write_collinearity(object, collinearity, include.collinearity);
        });
        if let Some(text) = written {
            shared_text::keep(collinearity, include.collinearity, text);
        }
    } else {
        object.object("collinearity", |object| write_collinearity(object, collinearity, include.collinearity));
    }
    if let Some(PerturbationReport { least_squares, regularized }) = perturbation {
        object.object("perturbation", |object| {
            object
                .object("least_squares", |object| write_bounds(object, least_squares))
                .object("regularized", |object| write_bounds(object, regularized));
        });
    }
    object.object("residuals", |object| write_residuals(object, residuals));
    if let Some(report) = robust {
        object.object("robust", |object| robust::write(object, report, include.robust_weights));
    }
    if let Some(points) = lambda_curve {
        object.list("lambda_curve", points, write_lambda_curve_point);
    }
    if let Some(points) = ridge_trace {
        object.list("ridge_trace", points, |object, RidgeTracePoint { k, coefficients }| {
            object.number("k", *k).numbers("coefficients", coefficients);
        });
    }
    if let Some(rows) = matrix_b {
        object.rows("matrix_b", rows);
    }
    if let Some(report) = filtering {
        filters::write(&mut object, report, include.peaks);
    }
    let Numerics { arithmetic, correct_digits } = numerics;
    let arithmetic = match arithmetic {
        Arithmetic::Double => "double",
        Arithmetic::DoubleDouble => "double_double",
    };
    object
        .object("numerics", |object| {
            object.string("arithmetic", arithmetic).number("correct_digits", *correct_digits);
        })
        .list("warnings", warnings, |object, Warning { code, message }| {
            object.string("code", code).string("message", message);
        })
        .object("provenance", |object| {
            object.string("engine", crate::api::ENGINE).string("input_sha256", input_sha256);
        })
        .end();
    json.finish()
}

fn write_coefficient(object: &mut Object<'_>, coefficient: &Coefficient) {
    let Coefficient { term, key, value, std_error, least_squares, least_squares_std_error, bias_bound } = coefficient;
    object.string("term", term);
    match key {
        TermKey::Powers(powers) => object.counts("powers", powers),
        TermKey::Index(index) => object.counts("index", index),
        TermKey::Column(column) => object.count("column", *column),
    };
    object
        .number("value", *value)
        .maybe_number("std_error", *std_error)
        .number("least_squares", *least_squares)
        .maybe_number("least_squares_std_error", *least_squares_std_error)
        .number("bias_bound", *bias_bound);
}

fn write_spectrum(object: &mut Object<'_>, spectrum: &SpectrumReport) {
    let SpectrumReport { eigenvalues, condition, log10_condition, log10_determinant, rank, regularized } = spectrum;
    object
        .numbers("eigenvalues", eigenvalues)
        .maybe_number("condition", *condition)
        .maybe_number("log10_condition", *log10_condition)
        .maybe_number("log10_determinant", *log10_determinant)
        .count("rank", *rank)
        .object("regularized", |object| {
            let RegularizedSpectrum { eigenvalues, condition, log10_determinant } = regularized;
            object
                .numbers("eigenvalues", eigenvalues)
                .maybe_number("condition", *condition)
                .maybe_number("log10_determinant", *log10_determinant);
        });
}

fn write_regularization(object: &mut Object<'_>, regularization: &RegularizationReport) {
    let RegularizationReport {
        kind,
        scheme,
        count,
        lambda_star,
        rank,
        shrinkage_factor,
        lambda_star_interval,
        gamma,
        criterion,
        fixed,
        filter_factors,
        matrix_norm_squared,
        largest_eigenvalue_bound,
        choices,
    } = regularization;
    object.string(
        "type",
        match kind {
            RegularizationKind::None => "none",
            RegularizationKind::Spectral => "spectral",
            RegularizationKind::Ridge => "ridge",
            RegularizationKind::Tikhonov => "tikhonov",
            RegularizationKind::TruncatedSvd => "truncated_svd",
            RegularizationKind::JamesStein => "james_stein",
            RegularizationKind::Attraction => "attraction",
        },
    );
    if let Some(scheme) = scheme {
        object.string("scheme", scheme_name(*scheme));
    }
    if let Some(count) = count {
        object.count("count", *count);
    }
    object.maybe_number("lambda_star", *lambda_star);
    if let Some(rank) = rank {
        object.count("rank", *rank);
    }
    object.maybe_number("shrinkage_factor", *shrinkage_factor);
    if let Some(ends) = lambda_star_interval {
        object.numbers("lambda_star_interval", ends);
    }
    object.maybe_number("gamma", *gamma);
    match criterion {
        _ if *fixed => object.string("criterion", "fixed"),
        Some(criterion) => object.string("criterion", criterion.name()),
        None => object,
    }
    .numbers("filter_factors", filter_factors)
    .maybe_number("matrix_norm_squared", *matrix_norm_squared)
    .maybe_number("largest_eigenvalue_bound", *largest_eigenvalue_bound)
    .list("choices", choices, write_choice);
}

fn write_choice(object: &mut Object<'_>, choice: &Choice) {
    let Choice { criterion, lambda_star, condition, bias_norm, predicted_mse, rms } = choice;
    object
        .string("criterion", criterion.map_or("least_squares", Criterion::name))
        .maybe_number("lambda_star", *lambda_star)
        .maybe_number("condition", *condition)
        .number("bias_norm", *bias_norm)
        .maybe_number("predicted_mse", *predicted_mse)
        .number("rms", *rms);
}

fn write_bias(object: &mut Object<'_>, bias: &BiasReport) {
    let BiasReport { norm, sharp_bound, paper_bound, coefficient_norm_limit, coefficient_norm_limit_source, e } = bias;
    object
        .number("norm", *norm)
        .number("sharp_bound", *sharp_bound)
        .maybe_number("paper_bound", *paper_bound)
        .number("coefficient_norm_limit", *coefficient_norm_limit)
        .string("coefficient_norm_limit_source", coefficient_norm_limit_source.name())
        .maybe_number("e", *e);
}

fn write_collinearity(object: &mut Object<'_>, collinearity: &CollinearityReport, squares: bool) {
    let CollinearityReport { columns, correlation, variance_proportions, near_dependencies } = collinearity;
    object.list("columns", columns, |object, ColumnCollinearity { term, vif }| {
        object.string("term", term).maybe_number("vif", *vif);
    });
    if let Some(rows) = correlation.as_ref().filter(|_| squares) {
        object.symmetric_rows("correlation", rows);
    }
    if let Some(rows) = variance_proportions.as_ref().filter(|_| squares) {
        object.rows("variance_proportions", rows);
    }
    object.list("near_dependencies", near_dependencies, |object, found| write_near_dependency(object, found, squares));
}

fn write_near_dependency(object: &mut Object<'_>, dependency: &NearDependency, squares: bool) {
    let NearDependency { eigenvalue, condition_index, weights, terms, cosine, weight_ratio, r_squared, sentence } =
        dependency;
    object.number("eigenvalue", *eigenvalue).maybe_number("condition_index", *condition_index);
    if squares {
        object.numbers("weights", weights);
    }
    object
        .strings("terms", terms)
        .maybe_number("cosine", *cosine)
        .maybe_number("weight_ratio", *weight_ratio)
        .maybe_number("r_squared", *r_squared)
        .string("sentence", sentence);
}

fn write_bounds(object: &mut Object<'_>, bounds: &PerturbationBounds) {
    let PerturbationBounds { square_bound, first_order_bound } = bounds;
    object.maybe_number("square_bound", *square_bound).maybe_number("first_order_bound", *first_order_bound);
}

fn write_residuals(object: &mut Object<'_>, residuals: &ResidualReport) {
    let ResidualReport {
        count,
        degrees_of_freedom,
        rss,
        sigma,
        rms,
        max_abs,
        r_squared,
        least_squares_rss,
        values,
        node_indices,
    } = residuals;
    object
        .count("count", *count)
        .count("degrees_of_freedom", *degrees_of_freedom)
        .number("rss", *rss)
        .maybe_number("sigma", *sigma)
        .number("rms", *rms)
        .maybe_number("max_abs", *max_abs)
        .maybe_number("r_squared", *r_squared)
        .number("least_squares_rss", *least_squares_rss);
    if let Some(values) = values {
        object.numbers("values", values);
    }
    if let Some(indices) = node_indices {
        object.counts("node_indices", indices);
    }
}

fn write_lambda_curve_point(object: &mut Object<'_>, point: &LambdaCurvePoint) {
    let LambdaCurvePoint { lambda_star, condition, bias_norm, predicted_mse, rms, gcv, coefficient_norm } = point;
    object
        .number("lambda_star", *lambda_star)
        .maybe_number("condition", *condition)
        .number("bias_norm", *bias_norm)
        .maybe_number("predicted_mse", *predicted_mse)
        .number("rms", *rms)
        .maybe_number("gcv", *gcv)
        .number("coefficient_norm", *coefficient_norm);
}

#[cfg(test)]
#[path = "text_tests.rs"]
mod tests;
