//! The mean of the posterior, where something was known of the coefficients before.
//!
//! In the coordinates of [`crate::prior`] the estimate is `Gᵧ y + t`: a linear map of
//! the heights of now, the prior and the weights of its mixture held. Coefficients that lie as far
//! from the prior's mean as it says on average, `eᵀP⁻¹e ≤ n` with P its covariance, make a bias
//! along a form q of at most `√n ‖P^½ (1 − Gᵧ)ᵀq‖`, and what the parts of the mixture differ by.
//! That does not depend on the basis, and of a single prior it is at most ½√n standard errors of
//! least squares.

use nalgebra::{DMatrix, DVector};

use super::{
    context::{Applied, Context},
    linear_map::{Form, LinearMap},
    prior_applied::PriorApplied,
    report::{regularized_spectrum, unregularized},
    spectral,
};
use crate::{
    error::{FitError, Unconverged},
    estimate::Estimate,
    factor::multiply_upper_vector,
    prior::{Current, Mixture, Outcome, exceeds_double, weigh},
    result::{
        BiasReport, NormLimitSource, PriorConflict, PriorReport, RegularizationReport, RegularizedSpectrum,
        UsedCorrection, Warning,
    },
    selection::Rule,
    spec::{Moves, Prior},
    spectrum::caller_columns,
};
use flankfit_numerics::{Dd, check::Faults, jacobi, svd_dd, triangular};

/// Weighs the prior against the nodes.
pub(super) fn apply(context: &Context, prior: &Prior, warnings: &mut Vec<Warning>) -> Result<Applied, FitError> {
    let Context { spec, linear, least_squares, .. } = *context;
    if !context.spectrum.full_rank() {
        return Err(
            Faults::one("prior", "the nodes themselves do not determine every coefficient: use fewer terms").into()
        );
    }
    let given = matches!(prior, Prior::Given { .. });
    if given && spec.noise_sigma.is_none() && context.degrees_of_freedom > 0 && least_squares.rss == 0.0 {
        warnings.push(Warning::PriorWithoutNoise);
        return plain(context, prior, None, warnings);
    }
    let columns = caller_columns(linear.factor);
    let mut coefficients = least_squares.working.clone();
    triangular::solve_upper(&linear.factor.change, &mut coefficients);
    let current = Current {
        spec,
        design: linear.design,
        inverse: triangular::inverse_upper(&columns),
        columns: &columns,
        coefficients,
        rss: least_squares.rss,
        freedom: context.degrees_of_freedom,
    };
    let outcome = weigh(&current, prior)?;
    let Some(outcome) = outcome else {
        warnings.push(Warning::NoEarlierIterations);
        return plain(context, prior, None, warnings);
    };
    warnings.extend(outcome.unequal.clone());
    match &outcome.posterior {
        Some(mixture) => {
            let posterior = Posterior::new(context, &current, mixture, outcome.noise.sigma);
            context.warn_of_missing("posterior", false, warnings);
            match posterior.applied(context, prior, &outcome) {
                Ok(applied) if is_finite(&applied) => Ok(applied),
                Ok(_) | Err(FitError::NotConverged(Unconverged::SingularValues)) => Err(exceeds_double(prior)),
                Err(other) => Err(other),
            }
        }
        None => {
            if let Some(PriorConflict { statistic, p, .. }) = outcome.conflict {
                warnings.push(Warning::PriorConflict { statistic, p });
            }
            plain(context, prior, Some(&outcome), warnings)
        }
    }
}

/// True if doubles hold what follows from nodes and prior together.
fn is_finite(applied: &Applied) -> bool {
    let bias = &applied.bias;
    let figures = [applied.rss, bias.norm, bias.sharp_bound, bias.coefficient_norm_limit];
    let lists = [&applied.bounds, &applied.estimate.coefficients, &applied.spectrum.eigenvalues];
    figures.iter().chain(lists.into_iter().flatten()).all(|x| x.is_finite())
}

/// Least squares of the nodes alone. If moves were estimated the intervals are still those that
/// hold whatever the flank did: least squares' own miss more often after they decided that the
/// prior is dropped.
fn plain(
    context: &Context,
    prior: &Prior,
    outcome: Option<&Outcome>,
    warnings: &mut Vec<Warning>,
) -> Result<Applied, FitError> {
    let applied = spectral::apply(context, warnings)?;
    let share = vec![0.0; applied.estimate.coefficients.len()];
    let report = report_of(prior, outcome, share, &applied.estimate.leverage);
    let intervals = outcome.and_then(|outcome| outcome.intervals.clone());
    Ok(Applied { prior: Some(PriorApplied { report, noise: None, intervals }), ..applied })
}

fn report_of(prior: &Prior, outcome: Option<&Outcome>, share: Vec<f64>, leverage: &[f64]) -> PriorReport {
    let noise = outcome.map(|outcome| outcome.noise);
    let chain = if let Prior::Iterations(chain) = prior { Some(chain) } else { None };
    let earlier = chain.map(|chain| chain.earlier.as_deref().unwrap_or_default());
    let ratio = outcome.and_then(|outcome| outcome.ratio);
    let moved = chain.and_then(|chain| match &chain.moves {
        Moves::StdError(deviations) => Some(deviations.clone()),
        Moves::Estimated => {
            let size = ratio? * noise?.sigma;
            Some(leverage.iter().map(|l| size * l).collect())
        }
    });
    PriorReport {
        iterations: earlier.map(|earlier| earlier.iter().map(|one| one.number).collect()),
        fit_ids: earlier.map(|earlier| earlier.iter().map(|one| one.fit_id.clone()).collect()),
        corrections: earlier
            .iter()
            .flat_map(|earlier| earlier.iter())
            .flat_map(|one| &one.corrections)
            .map(|used| UsedCorrection {
                iteration: used.iteration,
                record_id: used.record_id.clone(),
                entered: used.entered.clone(),
            })
            .collect(),
        move_std_error: moved,
        move_ratio: ratio,
        conflict: outcome.and_then(|outcome| outcome.conflict),
        share,
        sigma: noise.map(|noise| noise.sigma),
        degrees_of_freedom: noise.and_then(|noise| noise.freedom),
    }
}

/// The posterior in the caller's terms and in the scaled columns.
struct Posterior<'a> {
    mixture: &'a Mixture,
    sigma: f64,
    /// Row j is coefficient j as a form in Q's coordinates.
    forms: DMatrix<f64>,
    coefficients: Vec<f64>,
    /// The mean of the posterior in the working basis.
    working: Vec<Dd>,
    /// The inverse of `X̃` in Q's coordinates.
    unscaled: DMatrix<f64>,
    /// r, the root of the prior's variance in the scaled columns.
    radius: f64,
    /// 1 − Gᵧ.
    removal: DMatrix<f64>,
    /// `√n σ C (1 − Gᵧ)ᵀ`, σ²CᵀC being the covariance of the prior.
    reach: DMatrix<f64>,
    /// Bias in addition to that of a single prior.
    offset: DVector<f64>,
}

impl<'a> Posterior<'a> {
    fn new(context: &Context, current: &Current, mixture: &'a Mixture, sigma: f64) -> Self {
        let n = mixture.mean.len();
        let mut moved: Vec<Dd> = mixture.mean.iter().map(|&x| Dd::product(x, sigma)).collect();
        multiply_upper_vector(&current.inverse, &mut moved);
        let exact: Vec<Dd> = current.coefficients.iter().zip(&moved).map(|(&a, &d)| a + d).collect();
        let coefficients = exact.iter().map(|x| x.to_f64()).collect();
        let mut working = exact;
        multiply_upper_vector(&context.linear.factor.change, &mut working);
        let unscaled = triangular::inverse_upper(&context.columns.matrix).map(|x| x.to_f64());
        let removal = DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j)) - mixture.gain[(i, j)]);
        let offset = (&mixture.mean - times(&removal, &mixture.prior_mean)) * sigma;
        let reach = product(&mixture.prior_root, &removal.transpose()) * (sigma * (n as f64).sqrt());
        // the trace of the prior's covariance in the scaled columns
        let square: f64 = product(&unscaled, &mixture.prior_root.transpose()).iter().map(|x| x * x).sum();
        Posterior {
            mixture,
            sigma,
            forms: current.inverse.map(|x| x.to_f64()),
            coefficients,
            working,
            unscaled,
            radius: sigma * square.sqrt(),
            removal,
            reach,
            offset,
        }
    }

    fn applied(self, context: &Context, prior: &Prior, outcome: &Outcome) -> Result<Applied, FitError> {
        let Context { spec, linear, columns, spectrum, least_squares, .. } = *context;
        let filtered: Vec<_> = spectrum.lambda.iter().map(|&lambda| Rule::None.at(0, lambda, 0.0)).collect();
        let plain = Estimate::new(columns, spectrum, &filtered, least_squares);
        let n = plain.coefficients.len();
        let row = |j: usize| DVector::from_iterator(n, self.forms.row(j).iter().copied());
        let spread: Vec<f64> = (0..n).map(|j| times(&self.mixture.root, &row(j)).norm()).collect();
        let share = spread.iter().zip(&plain.leverage).map(|(s, l)| (1.0 - (s / l).powi(2)).max(0.0)).collect();
        let residuals = linear.of_working(&self.working, spec.include.residuals);
        let report = report_of(prior, Some(outcome), share, &plain.leverage);
        let bias = self.bias()?;
        let eigenvalues = self.eigenvalues(context)?;
        let filter_factors = self.filter_factors()?;
        let map = LinearMap::Posterior {
            root: self.mixture.root.clone(),
            removal: self.removal,
            reach: self.reach,
            offset: self.offset,
            working: self.working,
        };
        let bounds = (0..n)
            .map(|j| map.bias(&Form::new(self.forms.row(j).iter().copied().collect(), spectrum), columns, self.radius))
            .collect();
        Ok(Applied {
            rss: residuals.rss,
            residuals,
            spectrum: eigenvalues,
            regularization: RegularizationReport { filter_factors, ..unregularized(context) },
            bias,
            bounds,
            curve: None,
            trace: None,
            matrix_b: None,
            matrix_b_factors: None,
            after: None,
            map,
            estimate: Estimate { coefficients: self.coefficients, spread, ..plain },
            prior: Some(PriorApplied { report, noise: Some(outcome.noise), intervals: outcome.intervals.clone() }),
            constraints: None,
            representative: None,
        })
    }

    /// The eigenvalues of Gᵧ, which is symmetric: what of each direction in which nodes and prior
    /// are independent comes from the nodes.
    fn filter_factors(&self) -> Result<Vec<f64>, FitError> {
        let found = jacobi::svd(self.mixture.gain.clone());
        let found = found.ok_or(FitError::NotConverged(Unconverged::SingularValues))?;
        Ok(found.sigma.iter().map(|share| share.min(1.0)).collect())
    }

    /// Distance of the posterior from least squares, and the greatest distance of its expectation
    /// from the coefficients, in the scaled columns.
    fn bias(&self) -> Result<BiasReport, FitError> {
        let moved = times(&self.unscaled, &(&self.mixture.mean * self.sigma));
        let reach = product(&self.unscaled, &self.reach.transpose());
        let found = jacobi::svd(reach).ok_or(FitError::NotConverged(Unconverged::SingularValues))?;
        let largest = found.sigma.last().copied().unwrap_or(0.0);
        Ok(BiasReport {
            norm: moved.norm(),
            sharp_bound: largest + times(&self.unscaled, &self.offset).norm(),
            paper_bound: None,
            coefficient_norm_limit: self.radius,
            coefficient_norm_limit_source: NormLimitSource::Prior,
            upper_confidence: None,
            e: None,
        })
    }

    /// Eigenvalues of the information matrix of nodes and prior together: the squared singular
    /// values of `C⁻ᵀX̃`, `CᵀC` being the covariance.
    fn eigenvalues(&self, context: &Context) -> Result<RegularizedSpectrum, FitError> {
        let root = self.mixture.root.map(Dd::from);
        let mut together = context.columns.matrix.clone();
        for mut column in together.column_iter_mut() {
            triangular::solve_upper_transposed(&root, column.as_mut_slice());
        }
        let found = svd_dd(&together).ok_or(FitError::NotConverged(Unconverged::SingularValues))?;
        Ok(regularized_spectrum(found.sigma.iter().map(|s| (*s * *s).to_f64()).collect()))
    }
}

/// `A x`, summed row by row.
fn times(a: &DMatrix<f64>, x: &DVector<f64>) -> DVector<f64> {
    DVector::from_iterator(a.nrows(), a.row_iter().map(|row| row.iter().zip(x.iter()).map(|(a, x)| a * x).sum::<f64>()))
}

/// `A B`, by columns.
fn product(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let columns: Vec<DVector<f64>> = b.column_iter().map(|column| times(a, &column.into_owned())).collect();
    DMatrix::from_columns(&columns)
}
