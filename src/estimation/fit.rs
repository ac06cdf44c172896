//! The way of a fit: nodes → design → factor → scaled columns → spectrum → λ* → estimate → report.

use nalgebra::DMatrix;

use super::{
    admission::{columns_within_range, constant_in_span, refuse_dependence, within_range},
    bias,
    choice::{self, Decided},
    collinearity,
    design::Design,
    digits,
    error::{Faults, FitError},
    estimate::{Estimate, LeastSquares, residuals},
    evidence::Evidence,
    factor::Factor,
    filter::{Filtered, Rule, Spectral},
    nodes::Nodes,
    perturbation,
    residuals::{Heights, Place, matrix_b},
    result::{
        BiasReport, Coefficient, FitResult, Numerics, RegularizationReport, RegularizedSpectrum, ResidualReport,
        SpectrumReport, Warning,
    },
    sample::Sample,
    scaled::{ScaledColumns, caller_columns},
    separable::Separable,
    sound,
    spec::{FitSpec, Scaling},
    spectrum::Spectrum,
};

/// Numbers of B that an answer may hold.
const MOST_OF_B: usize = 1_000_000;

/// Fits `spec` to `nodes`. Pure: no clock, no randomness, no state; the same input gives the same bits.
pub fn fit(nodes: &Nodes, spec: &FitSpec) -> Result<FitResult, FitError> {
    let sample = Sample::new(nodes);
    let design = Design::new(nodes, &sample, spec)?;
    let separable = match nodes {
        Nodes::Grid(grid)
            if spec.scaling != Scaling::Standardized && design.is_full_product() && sample.separates() =>
        {
            Separable::new(&design, grid)
        }
        _ => None,
    };
    let heights = Heights::new(&sample);
    within_range(nodes, &heights)?;
    let factor = Factor::new(&design, &sample, separable)?;
    let evidence = Evidence::Posted { sample: &sample, nodes };
    report(&Place { design: &design, factor: &factor, heights: heights.about_zero, evidence }, &heights, spec)
}

/// Everything from the factor on: scaled columns, spectrum, λ*, estimate, bounds. What needs the nodes themselves asks
/// `place`; where they are gone (a stream keeps sums only) such figures are left out.
pub(super) fn report(place: &Place, heights: &Heights, spec: &FitSpec) -> Result<FitResult, FitError> {
    let (design, factor) = (place.design, place.factor);
    let count = place.evidence.count();
    let mut warnings = Vec::new();
    let caller = caller_columns(factor);
    columns_within_range(design, &caller)?;
    let mut columns = ScaledColumns::new(design, &caller, spec.scaling, heights.weight)?;
    if let Some(constant) = &mut columns.constant {
        constant.set_level(&caller, &factor.qty);
    }
    let unit = match spec.scaling {
        Scaling::UnitLength => None,
        Scaling::None | Scaling::Standardized => {
            let columns = ScaledColumns::new(design, &caller, Scaling::UnitLength, heights.weight)?;
            let spectrum = Spectrum::new(factor, &columns, Scaling::UnitLength, None)?;
            Some((columns, spectrum))
        }
    };
    let rank = match (&unit, spec.scaling) {
        (Some((_, unit)), Scaling::None) => Some(unit.rank),
        _ => None,
    };
    let spectrum = Spectrum::new(factor, &columns, spec.scaling, rank)?;
    if !spectrum.full_rank() {
        // names must not depend on how the columns are scaled
        match (&unit, spec.scaling) {
            (Some((columns, spectrum)), Scaling::None) => {
                refuse_dependence(design, columns, spectrum, spec, &mut warnings)?;
            }
            _ => refuse_dependence(design, &columns, &spectrum, spec, &mut warnings)?,
        }
    }
    let least_squares = LeastSquares::new(place, &columns, &spectrum);
    let free = spectrum.rank + usize::from(columns.constant.is_some());
    let degrees_of_freedom = count - free;
    let sigma = (degrees_of_freedom > 0).then(|| (least_squares.rss / degrees_of_freedom as f64).sqrt());
    if sigma.is_none() {
        warnings.push(Warning {
            code: "no_degrees_of_freedom",
            message: "as many coefficients as nodes: there is no estimate of the noise, so no standard errors".into(),
        });
    }
    let problem = Spectral::new(
        &spectrum.lambda,
        &spectrum.a,
        spec.noise_sigma.or(sigma).map(|s| s * s),
        least_squares.rss,
        count,
        usize::from(columns.constant.is_some()),
    );
    let decided =
        choice::decide(&spec.regularization, &problem, heights.weight, spec.include.lambda_curve, &mut warnings)?;
    let rule = if decided.chosen.is_some() { decided.rule } else { Rule::None };
    let filtered: Vec<Filtered> =
        spectrum.lambda.iter().enumerate().map(|(i, &lambda)| rule.at(i, lambda, decided.parameter())).collect();
    let estimate = Estimate::new(&columns, &spectrum, &filtered, &least_squares);

    let residuals = residuals(place, &spectrum, &filtered, &estimate, &least_squares, spec);
    let rss = problem.sums(rule, decided.parameter()).rss[0];
    let report =
        Reporter { spec, design, columns: &columns, spectrum: &spectrum, decided: &decided, rule, filtered: &filtered };
    let bias = report.bias(&estimate.directions, &mut warnings);
    let regularization = report.regularization(&problem, &mut warnings, heights.weight);
    let collinearity = collinearity::report(
        design,
        factor,
        &caller,
        unit.as_ref().map_or(&spectrum, |(_, unit)| unit),
        heights.weight,
        spec.include.collinearity,
        &mut warnings,
    );
    let spectrum_report = report.spectrum();
    let perturbation = spec.node_uncertainty.map(|uncertainty| {
        let largest = filtered.iter().map(|f| f.eigenvalue).fold(0.0, f64::max);
        let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>().sqrt();
        let before = perturbation::Estimate {
            condition: spectrum_report.condition,
            largest: spectrum.largest(),
            norm: norm(&mut spectrum.a.iter().copied()),
        };
        let after = perturbation::Estimate {
            condition: spectrum_report.regularized.condition,
            largest,
            norm: norm(&mut spectrum.a.iter().zip(&filtered).map(|(a, f)| a * f.factor)),
        };
        let rss = least_squares.rss;
        let slopes = place.evidence.slopes(design, &columns);
        perturbation::report(slopes, heights.weight, uncertainty, heights.about_zero.sqrt(), rss, [before, after])
    });
    if let Some(p) = &perturbation
        && (p.least_squares.square_bound.is_none() || p.regularized.square_bound.is_none())
    {
        warnings.push(Warning {
            code: "perturbation_unbounded",
            message: "the node uncertainty times the condition reaches 1: the square bound does not exist there".into(),
        });
    }
    let total = if constant_in_span(design, factor, &columns, &spectrum, heights.weight) {
        heights.about_mean
    } else {
        heights.about_zero
    };
    let matrix_b = report.matrix_b(place, &mut warnings)?;
    let correct_digits = digits::correct_digits(&digits::Fitted {
        design,
        evidence: place.evidence,
        largest_height: heights.largest,
        r: &factor.r,
        working: &least_squares.working,
        coefficients: &least_squares.coefficients,
        leverage: &estimate.leverage,
        sensitivity: &estimate.sensitivity,
        sigma,
        // without the nodes √rss is all that is known of the largest residual
        max_residual: least_squares.max_abs.unwrap_or_else(|| least_squares.rss.sqrt()),
        relative_error: factor.relative_error,
        length: heights.about_zero.sqrt(),
    });
    // where columns depend on each other the nodes do not determine the coefficients at all, and a warning said so
    let correct_digits = if spectrum.full_rank() { correct_digits } else { 0.0 };
    if correct_digits < 6.0 && spectrum.full_rank() {
        warnings.push(Warning {
            code: "few_digits",
            message: format!(
                "the posted numbers, rounded to doubles, determine the worst coefficient to about {correct_digits:.0} digits only"
            ),
        });
    }
    let coefficients = (0..design.size())
        .map(|j| Coefficient {
            term: design.labels[j].clone(),
            key: design.keys[j].clone(),
            value: estimate.coefficients[j],
            std_error: sigma.map(|s| s * estimate.spread[j]),
            least_squares: least_squares.coefficients[j],
            least_squares_std_error: sigma.map(|s| s * estimate.leverage[j]),
            bias_bound: bias.1[j],
        })
        .collect();
    let result = FitResult {
        coefficients,
        domain: design.domain,
        spectrum: spectrum_report,
        regularization,
        bias: bias.0,
        collinearity,
        perturbation,
        residuals: ResidualReport {
            count,
            degrees_of_freedom,
            rss,
            sigma,
            rms: (rss / heights.weight).sqrt(),
            max_abs: residuals.max_abs,
            r_squared: (total > 0.0).then(|| 1.0 - rss / total),
            least_squares_rss: least_squares.rss,
            node_indices: spec
                .include
                .residuals
                .then(|| place.evidence.counted().map(|index| index.iter().map(|&k| k as usize).collect()))
                .flatten(),
            values: residuals.values.filter(|_| spec.include.residuals),
        },
        lambda_curve: decided.curve.clone(),
        matrix_b,
        filtering: None,
        numerics: Numerics { arithmetic: factor.arithmetic, correct_digits },
        warnings,
    };
    sound::checked(result)
}

/// Puts what was computed into the shape of the answer.
struct Reporter<'a> {
    spec: &'a FitSpec,
    design: &'a Design,
    columns: &'a ScaledColumns,
    spectrum: &'a Spectrum,
    decided: &'a Decided,
    rule: Rule,
    filtered: &'a [Filtered],
}

impl Reporter<'_> {
    fn spectrum(&self) -> SpectrumReport {
        let lambda = &self.spectrum.lambda;
        let condition = |values: &mut dyn Iterator<Item = f64>| {
            let (mut low, mut high) = (f64::INFINITY, 0.0f64);
            for value in values {
                (low, high) = (low.min(value), high.max(value));
            }
            Some(high / low).filter(|c| low > 0.0 && c.is_finite())
        };
        let log10_determinant = |values: &mut dyn Iterator<Item = f64>| {
            Some(values.map(f64::log10).sum::<f64>()).filter(|sum| sum.is_finite())
        };
        let plain = condition(&mut lambda.iter().copied());
        SpectrumReport {
            condition: plain,
            log10_condition: plain.map(f64::log10),
            log10_determinant: log10_determinant(&mut lambda.iter().copied()),
            rank: self.spectrum.rank + usize::from(self.columns.constant.is_some()),
            eigenvalues: lambda.clone(),
            regularized: RegularizedSpectrum {
                eigenvalues: self.filtered.iter().map(|f| f.eigenvalue).collect(),
                condition: condition(&mut self.filtered.iter().map(|f| f.eigenvalue)),
                log10_determinant: log10_determinant(&mut self.filtered.iter().map(|f| f.eigenvalue)),
            },
        }
    }

    fn bias(&self, directions: &DMatrix<f64>, warnings: &mut Vec<Warning>) -> (BiasReport, Vec<f64>) {
        let norm = self.spectrum.a.iter().map(|a| a * a).sum::<f64>().sqrt();
        let r = self.spec.coefficient_norm_limit.unwrap_or(norm);
        if r < norm {
            warnings.push(Warning {
                code: "norm_limit_below_estimate",
                message: format!(
                    "coefficient_norm_limit {r} is below ‖Â‖ = {norm} of this fit: the bounds limit the expected bias, \
                     the observed one may exceed them"
                ),
            });
        }
        let bias = bias::bias(self.spectrum, self.rule, self.decided.parameter(), self.filtered, r);
        let report = BiasReport {
            norm: bias.norm,
            sharp_bound: bias.sharp,
            paper_bound: bias.paper,
            coefficient_norm_limit: r,
            coefficient_norm_limit_from_request: self.spec.coefficient_norm_limit.is_some(),
            e: bias.e,
        };
        (report, bias::per_coefficient(directions, self.filtered, r))
    }

    fn regularization(&self, problem: &Spectral, warnings: &mut Vec<Warning>, weight: f64) -> RegularizationReport {
        let (scheme, count) = choice::scheme_and_count(self.decided.rule);
        let lambda = &self.spectrum.lambda;
        let parameter = self.decided.chosen.map(|c| c.lambda_star);
        let spectral = matches!(self.rule, Rule::Spectral { count: 1.., .. });
        let sums = problem.sums(self.rule, self.decided.parameter());
        let standing = super::result::Choice {
            criterion: self.decided.criterion,
            lambda_star: parameter,
            condition: None,
            bias_norm: sums.bias.sqrt(),
            predicted_mse: problem.variance.map(|_| sums.mse[0]),
            rms: (sums.rss[0] / weight).sqrt(),
        };
        choice::warn_about(self.decided, &standing, warnings);
        let c = |i: usize| self.rule.coefficient(i, lambda[i], self.decided.parameter()).unwrap_or(0.0);
        RegularizationReport {
            kind: self.decided.kind,
            scheme,
            count,
            lambda_star: parameter,
            lambda_star_interval: self.decided.chosen.and_then(|c| c.interval),
            gamma: parameter.filter(|_| spectral).map(|p| p - lambda[0]),
            criterion: self.decided.criterion,
            fixed: self.decided.fixed,
            filter_factors: self.filtered.iter().map(|f| f.factor).collect(),
            matrix_norm_squared: scheme.map(|_| (0..lambda.len()).map(|i| c(i) * c(i) * lambda[i]).sum()),
            largest_eigenvalue_bound: scheme
                .map(|_| self.spectrum.largest() + (self.filtered[0].eigenvalue - lambda[0])),
            choices: self.decided.choices.clone(),
        }
    }

    fn matrix_b(&self, place: &Place, warnings: &mut Vec<Warning>) -> Result<Option<Vec<Vec<f64>>>, FitError> {
        if !self.spec.include.matrix_b {
            return Ok(None);
        }
        let (_, Some(_)) = choice::scheme_and_count(self.decided.rule) else {
            warnings
                .push(Warning { code: "no_matrix_b", message: "only spectral regularisation has a matrix B".into() });
            return Ok(None);
        };
        if self.columns.constant.is_some() {
            warnings.push(Warning {
                code: "no_matrix_b",
                message: "of standardised columns there is no B to be added to the posted ones".into(),
            });
            return Ok(None);
        }
        let Evidence::Posted { sample, .. } = place.evidence else {
            warnings.push(Warning { code: "no_matrix_b", message: "the rows of B need the nodes themselves".into() });
            return Ok(None);
        };
        let (m, n) = (sample.count(), self.design.size());
        if m * n > MOST_OF_B {
            return Err(Faults::one(
                "/include",
                format!("B has {m} × {n} entries here; at most {MOST_OF_B} are answered"),
            )
            .into());
        }
        let lambda = &self.spectrum.lambda;
        let c: Vec<f64> = (0..lambda.len())
            .map(|i| self.rule.coefficient(i, lambda[i], self.decided.parameter()).unwrap_or(0.0))
            .collect();
        let scale: Vec<f64> = self.columns.scale.iter().map(|s| s.to_f64()).collect();
        let Spectrum { image, v, .. } = self.spectrum;
        Ok(Some(matrix_b(place.design, sample, place.factor, image, v, &c, &scale)))
    }
}
