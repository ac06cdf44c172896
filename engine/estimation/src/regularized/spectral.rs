//! None, the matrix B (Eqs. 27–48) and ridge: filters on the eigenvectors of the Fisher information
//! matrix.

use nalgebra::DMatrix;

use super::{
    bias,
    context::{Applied, Context},
    corrected,
    error_interval::error_interval,
    linear_map::LinearMap,
    node_shares,
    report::{check_b, regularized_spectrum, report},
    trace,
};
use crate::{
    data::Sample,
    diagnostics::perturbation,
    error::FitError,
    estimate::{Estimate, residuals},
    problem::{Evidence, image_of_nodes, matrix_b},
    result::{BiasReport, Choice, MatrixBFactors, ProductOfB, RegularizationKind, RegularizationReport, Warning},
    selection::{
        Filtered, Rule, Spectral,
        filters::{self, SelectedFilter},
    },
    spec::{Domain, Piece, Scheme},
    spectrum::Directions,
};

/// Rows of B, and B as a product.
type FormedB = (Vec<Vec<f64>>, MatrixBFactors);

/// Applies the requested rule.
pub(super) fn apply(context: &Context, warnings: &mut Vec<Warning>) -> Result<Applied, FitError> {
    let Context { spec, spectrum, columns, least_squares, linear, .. } = *context;
    let problem = context.spectral_problem(&spectrum.lambda, &spectrum.a);
    let include = spec.include;
    node_shares::check(context)?;
    let nodewise = || {
        let root = |i: usize| spectrum.lambda[i].sqrt();
        let images =
            DMatrix::from_fn(spectrum.image.nrows(), spectrum.image.ncols(), |k, i| spectrum.image[(k, i)] / root(i));
        node_shares::left_out(context, &images, spectrum.a.iter().enumerate().map(|(i, a)| root(i) * a).collect())
    };
    let asked = filters::FilterRequest {
        regularization: &spec.regularization,
        weight: context.weight,
        curve: include.lambda_curve,
    };
    let selected = filters::decide(&asked, &problem, &spectrum.a, &nodewise, warnings)?;
    let rule = if selected.selection.answer.is_some() { selected.rule } else { Rule::None };
    let filtered: Vec<Filtered> =
        spectrum.lambda.iter().enumerate().map(|(i, &lambda)| rule.at(i, lambda, selected.parameter())).collect();
    let estimate = Estimate::new(columns, spectrum, &filtered, least_squares);
    let residuals = residuals(linear, spectrum, &filtered, &estimate, least_squares, spec);
    let applied = AppliedFilter { context, selected: &selected, rule, filtered: &filtered };
    let (bias, bounds) = applied.bias(&estimate.coefficients, &estimate.directions, warnings);
    let mut regularization = applied.regularization(&problem, warnings);
    if include.predicted_mse {
        regularization.predicted_mse_corrected = corrected::of_filter(context, &problem, rule, &selected);
        regularization.squared_error_interval = error_interval(context, &filtered);
    }
    let (matrix_b, matrix_b_factors) = applied.matrix_b(warnings)?.unzip();
    let representative = applied.piece(warnings);
    let trace = match selected.kind {
        RegularizationKind::Ridge => include.ridge_trace.then(|| trace::points(context, selected.selection.answer)),
        _ => {
            context.warn_of_trace(warnings);
            None
        }
    };
    let spectrum_after = regularized_spectrum(filtered.iter().map(|f| f.eigenvalue).collect());
    Ok(Applied {
        rss: problem.sums(rule, selected.parameter()).rss[0],
        after: Some(perturbation::Estimate {
            condition: spectrum_after.condition,
            largest: filtered.iter().map(|f| f.eigenvalue).fold(0.0, f64::max),
            norm: spectrum.a.iter().zip(&filtered).map(|(a, f)| (a * f.factor).powi(2)).sum::<f64>().sqrt(),
        }),
        map: LinearMap::Eigenvectors { removed: filtered.iter().map(|f| f.removed).collect() },
        prior: None,
        constraints: None,
        representative,
        estimate,
        residuals,
        spectrum: spectrum_after,
        regularization,
        bias,
        bounds,
        curve: selected.selection.curve.clone(),
        trace,
        matrix_b,
        matrix_b_factors,
    })
}

/// The chosen filter, from which the results are made.
struct AppliedFilter<'a> {
    context: &'a Context<'a>,
    selected: &'a SelectedFilter,
    rule: Rule,
    filtered: &'a [Filtered],
}

impl AppliedFilter<'_> {
    fn bias(
        &self,
        coefficients: &[f64],
        directions: &DMatrix<f64>,
        warnings: &mut Vec<Warning>,
    ) -> (BiasReport, Vec<f64>) {
        let r = self.context.norm_limit(self.context.norm_of(coefficients), warnings);
        let bias = bias::bias(self.context.spectrum, self.rule, self.selected.parameter(), self.filtered, r);
        let report = BiasReport { paper_bound: bias.paper, e: bias.e, ..self.context.bias(bias.norm, bias.sharp, r) };
        (report, bias::per_coefficient(directions, self.filtered, r))
    }

    /// cᵢ of Eq. 40, 0 where there is none.
    fn c(&self, i: usize) -> f64 {
        self.rule.coefficient(i, self.context.spectrum.lambda[i], self.selected.parameter()).unwrap_or(0.0)
    }

    fn regularization(&self, problem: &Spectral, warnings: &mut Vec<Warning>) -> RegularizationReport {
        let (scheme, count) = filters::scheme_and_count(self.selected.rule);
        let lambda = &self.context.spectrum.lambda;
        let parameter = self.selected.selection.answer.map(|c| c.lambda_star);
        let spectral = matches!(self.rule, Rule::Spectral { count: 1.., .. });
        let sums = problem.sums(self.rule, self.selected.parameter());
        let applied = Choice {
            criterion: self.selected.selection.criterion.into(),
            lambda_star: parameter,
            condition: None,
            bias_norm: sums.bias.sqrt(),
            predicted_mse: problem.variance.map(|_| sums.mse[0]),
            rms: (sums.rss[0] / self.context.weight).sqrt(),
        };
        self.context.judge(&self.selected.selection.choices, &applied, warnings);
        RegularizationReport {
            scheme,
            count,
            lambda_star: parameter,
            lambda_star_interval: self.selected.selection.answer.and_then(|c| c.interval),
            gamma: parameter.filter(|_| spectral).map(|p| p - lambda[0]),
            criterion: self.selected.selection.chosen_by(),
            filter_factors: self.filtered.iter().map(|f| f.factor).collect(),
            matrix_norm_squared: scheme.map(|_| (0..lambda.len()).map(|i| self.c(i) * self.c(i) * lambda[i]).sum()),
            largest_eigenvalue_bound: scheme
                .map(|_| self.context.spectrum.largest() + (self.filtered[0].eigenvalue - lambda[0])),
            choices: self.selected.selection.choices.clone(),
            ..report(self.selected.kind)
        }
    }

    /// Part of the fit that others can use as representative piece, if it was included.
    fn piece(&self, warnings: &mut Vec<Warning>) -> Option<Piece> {
        let Context { spec, linear, columns, spectrum, .. } = *self.context;
        if !spec.include.representative {
            return None;
        }
        let (scheme, count) = filters::scheme_and_count(self.rule);
        let found = scheme.zip(self.selected.selection.answer).filter(|_| columns.constant.is_none());
        let count = count.unwrap_or(0);
        let Some((scheme, chosen)) = found.filter(|_| count > 0) else {
            warnings.push(Warning::NoPieceToGive);
            return None;
        };
        // −0 is 0: specifications that contain the piece have one text
        let end = |ends: [f64; 2]| ends.map(|x| x + 0.0);
        Some(Piece {
            model: spec.model.clone(),
            domain: linear.design.domain.map(|Domain { u, v }| Domain { u: u.map(end), v: v.map(end) }),
            scheme,
            lambda_star: chosen.lambda_star,
            eigenvalues: spectrum.lambda[..count].to_vec(),
            directions: (0..count).map(|i| spectrum.v.column(i).iter().map(|x| x + 0.0).collect()).collect(),
            scale: columns.scale.iter().map(|s| s.to_f64()).collect(),
        })
    }

    fn matrix_b(&self, warnings: &mut Vec<Warning>) -> Result<Option<FormedB>, FitError> {
        let Context { spec, linear, columns, .. } = *self.context;
        if !spec.include.matrix_b {
            return Ok(None);
        }
        let (_, Some(_)) = filters::scheme_and_count(self.selected.rule) else {
            warnings.push(Warning::MatrixBIsSpectral);
            return Ok(None);
        };
        if columns.constant.is_some() {
            warnings.push(Warning::MatrixBOfStandardized);
            return Ok(None);
        }
        let Evidence::Posted { sample, .. } = linear.evidence else {
            warnings.push(Warning::MatrixBNeedsNodes);
            return Ok(None);
        };
        let (m, n) = (sample.count(), linear.design.size());
        check_b(m, n)?;
        let Directions { image, v, lambda, .. } = &self.context.spectrum.directions;
        let c: Vec<f64> = (0..lambda.len()).map(|i| self.c(i)).collect();
        let scale: Vec<f64> = columns.scale.iter().map(|s| s.to_f64()).collect();
        let rows = matrix_b(linear.design, sample, linear.factor, image, v, &c, &scale);
        Ok(Some((rows, self.factors(&c, sample))))
    }

    /// The product of Eq. 28, and Eqs. 42 to 46.
    fn factors(&self, c: &[f64], sample: &Sample) -> MatrixBFactors {
        let Context { spectrum, linear, .. } = *self.context;
        let Directions { image, v, lambda, .. } = &spectrum.directions;
        let e = c.iter().copied().fold(0.0, f64::max);
        let largest = |f: &dyn Fn(usize) -> f64| (0..c.len()).map(f).fold(0.0, f64::max);
        let parameter = self.selected.selection.answer.map_or(lambda[0], |chosen| chosen.lambda_star);
        let products = (0..c.len()).filter(|&i| c[i] > 0.0).map(|i| ProductOfB {
            eigenvalue: lambda[i],
            mu: c[i],
            q: image_of_nodes(linear.design, sample, linear.factor, image, i),
            s: v.column(i).iter().map(|v| c[i] / e * v).collect(),
        });
        MatrixBFactors {
            e,
            products: products.collect(),
            largest_eigenvalue: largest(&|i| c[i] * c[i] * lambda[i]),
            largest_eigenvalue_bound: match self.rule {
                Rule::Spectral { scheme: Scheme::FirstOrder, count: 1 } => {
                    (parameter - lambda[0]).powi(2) / (4.0 * lambda[0])
                }
                _ => (0..c.len()).map(|i| c[i] * c[i] * lambda[i]).sum(),
            },
            mixed_eigenvalue: largest(&|i| 2.0 * c[i] * lambda[i]),
            mixed_eigenvalue_bound: (parameter - lambda[0]).max(0.0),
        }
    }
}
