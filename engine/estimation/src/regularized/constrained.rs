//! Least squares under constraints on the shape.
//!
//! The estimate is no linear map of the heights. Derived results hold the active places fixed:
//! standard errors are those of least squares among the functions whose derivative is 0 there.
//! Intervals are about least squares and do not depend on the constraints.
//!
//! Where the true function meets the constraints, its image `x` lies in a convex cone that least
//! squares b is projected on: the estimate lies no further from x than b does, node by node summed,
//! for every draw. So its expectation lies within `E‖b − x‖ ≤ σ√n`, which bounds the bias of a form
//! q by `‖q‖ σ√n`; of norms in the scaled columns by `σ√n/√λ₁`.

use nalgebra::DMatrix;

use super::{
    context::{Applied, Context},
    linear_map::{Form, LinearMap},
    report::{regularized_spectrum, unregularized},
};
use crate::{
    constrained::constrained,
    error::FitError,
    estimate::Estimate,
    result::{BiasReport, RegularizationReport, Warning},
    selection::Rule,
};
use flankfit_numerics::{check::Faults, length, triangular};

/// Fits under the constraints of the spec.
pub(super) fn apply(context: &Context, warnings: &mut Vec<Warning>) -> Result<Applied, FitError> {
    let Context { spec, linear, columns, spectrum, least_squares, .. } = *context;
    if !spectrum.full_rank() {
        let message = "the nodes do not determine every coefficient: use fewer terms";
        return Err(Faults::one("constraints", message).into());
    }
    let variance = context.variance.ok_or_else(|| {
        Faults::one(
            "noise_sigma",
            "there are as many coefficients as nodes, so the noise, which `constraints` need, cannot be estimated: \
                give `noise_sigma`",
        )
    })?;
    let factor = linear.factor;
    let found = constrained(linear.design, &factor.r, &factor.qty, least_squares.rss, &spec.constraints)?;
    context.warn_of_missing("constrained", false, warnings);
    let active = found.report.constraints.iter().map(|one| one.active.len()).sum();
    if active > 0 {
        warnings.push(Warning::ConstraintsActive { count: active });
    }
    let n = linear.design.size();
    let reach = (variance * n as f64).sqrt();
    let held = orthonormal(&found.normals, n);
    let filter_factors = (0..n).map(|i| f64::from(u8::from(i >= held.ncols()))).collect();
    let map = LinearMap::Constrained { held, reach, working: found.working.clone() };
    let mut exact = found.working.clone();
    triangular::solve_upper(&factor.change, &mut exact);
    let filtered: Vec<_> = spectrum.lambda.iter().map(|&lambda| Rule::None.at(0, lambda, 0.0)).collect();
    let plain = Estimate::new(columns, spectrum, &filtered, least_squares);
    let inverse = triangular::inverse_upper(&triangular::multiply_upper(&factor.r, &factor.change));
    let form =
        |j: usize| Form::new((0..n).map(|k| if k < j { 0.0 } else { inverse[(j, k)].to_f64() }).collect(), spectrum);
    let forms: Vec<Form> = (0..n).map(form).collect();
    // nothing is moved where nothing is active
    let coefficients = match active {
        0 => plain.coefficients.clone(),
        _ => exact.iter().map(|x| x.to_f64()).collect(),
    };
    let moved: Vec<f64> = coefficients.iter().zip(&plain.coefficients).map(|(a, b)| a - b).collect();
    let r = context.norm_limit(context.norm_of(&coefficients), warnings);
    let residuals = linear.of_working(&found.working, spec.include.residuals);
    let bias = BiasReport { ..context.bias(context.norm_of(&moved), reach / spectrum.lambda[0].sqrt(), r) };
    Ok(Applied {
        rss: residuals.rss,
        residuals,
        spectrum: regularized_spectrum(spectrum.lambda.clone()),
        regularization: RegularizationReport { filter_factors, ..unregularized(context) },
        bias,
        bounds: forms.iter().map(|form| reach * length(&form.q)).collect(),
        curve: None,
        trace: None,
        matrix_b: None,
        matrix_b_factors: None,
        after: None,
        estimate: Estimate {
            spread: forms.iter().map(|form| length(&map.row(form, spectrum))).collect(),
            coefficients,
            ..plain
        },
        map,
        prior: None,
        constraints: Some(found.report),
        representative: None,
    })
}

/// Orthonormal columns that span the vectors.
fn orthonormal(vectors: &[Vec<f64>], n: usize) -> DMatrix<f64> {
    let mut found: Vec<Vec<f64>> = Vec::new();
    for vector in vectors {
        let size = length(vector);
        let mut rest = vector.clone();
        for _ in 0..2 {
            for q in &found {
                let along: f64 = q.iter().zip(&rest).map(|(q, x)| q * x).sum();
                rest.iter_mut().zip(q).for_each(|(x, q)| *x -= along * q);
            }
        }
        let left = length(&rest);
        if left > 1e-9 * size {
            found.push(rest.iter().map(|x| x / left).collect());
        }
    }
    DMatrix::from_fn(n, found.len(), |i, k| found[k][i])
}
