//! Input and result of a regularisation.

use super::{linear_map::LinearMap, prior_applied::PriorApplied};
use crate::{
    diagnostics::perturbation,
    estimate::{Estimate, LeastSquares},
    prior::{FormIntervals, PooledNoise},
    problem::{LinearProblem, Residuals},
    result::{
        BiasReport, Choice, ConstraintsReport, LambdaCurvePoint, MatrixBFactors, NormLimitSource, RegularizationReport,
        RegularizedSpectrum, RidgeTracePoint, Warning,
    },
    selection::{Spectral, selector::warn_about},
    spec::{ExpectedSize, FitSpec, Piece},
    spectrum::{ScaledColumns, Spectrum},
};
use flankfit_numerics::{
    distribution::{chi_squared, fisher},
    root::boundary,
};

/// Probability below which nodes contradict a limit of the norm.
const CONTRADICTED: f64 = 0.01;

/// Everything known of the fit before it is regularised.
pub(crate) struct Context<'a> {
    pub spec: &'a FitSpec,
    pub linear: &'a LinearProblem<'a>,
    pub columns: &'a ScaledColumns,
    pub spectrum: &'a Spectrum,
    pub least_squares: &'a LeastSquares,
    /// Σw.
    pub weight: f64,
    /// m − rank.
    pub degrees_of_freedom: usize,
    /// σ² of the request, else that of the residuals; `None` where there is neither.
    pub variance: Option<f64>,
}

impl Context<'_> {
    /// m.
    pub(crate) fn count(&self) -> usize {
        self.linear.evidence.count()
    }

    /// Coefficients that no filter acts on: the constant of standardised columns.
    pub(crate) fn unpenalised(&self) -> usize {
        usize::from(self.columns.constant.is_some())
    }

    /// Problem from which criteria are computed, for the coordinates `a` along eigenvectors with
    /// eigenvalues `lambda`.
    pub(crate) fn spectral_problem<'l>(&self, lambda: &'l [f64], a: &[f64]) -> Spectral<'l> {
        Spectral::new(lambda, a, self.variance, self.least_squares.rss, self.count(), self.unpenalised())
            .with_sigma(self.spec.noise_sigma)
    }

    /// r, with a warning where that of the request lies below ‖Â‖. `regularized` is ‖Â_B‖.
    pub(crate) fn norm_limit(&self, regularized: f64, warnings: &mut Vec<Warning>) -> f64 {
        let a = &self.spectrum.a;
        let norm = a.iter().map(|a| a * a).sum::<f64>().sqrt();
        let Some(r) = self.spec.coefficient_norm_limit else {
            return match &self.spec.expected_size {
                ExpectedSize::Estimated => norm,
                ExpectedSize::OfHeights => self.size_of_heights().max(regularized),
                ExpectedSize::Within(limits) => self.norm_of(limits).max(regularized),
            };
        };
        if let Some(p) = self.contradiction(r).filter(|p| *p < CONTRADICTED) {
            warnings.push(Warning::NormLimitContradicted { limit: r, norm, p });
        }
        r
    }

    /// Returns the greatest probability that least squares lies so far from all coefficients with a
    /// norm of at most `r` if the true ones are among them: F of the distance to the nearest.
    fn contradiction(&self, r: f64) -> Option<f64> {
        let largest = self.spectrum.largest();
        let known = || self.spectrum.lambda.iter().zip(&self.spectrum.a).filter(|(lambda, _)| **lambda > 0.0);
        // the nearest are those of ridge with k = largest (1 − t)/t
        let kept = |t: f64, lambda: f64| lambda * t / (lambda * t + largest * (1.0 - t));
        let norm = |t: f64| known().map(|(l, a)| (kept(t, *l) * a).powi(2)).sum::<f64>().sqrt();
        if norm(1.0) <= r {
            return None;
        }
        let [t, _] = boundary([0.0, 1.0], 0.0, |t| norm(t) <= r);
        let distance: f64 = known().map(|(l, a)| l * ((1.0 - kept(t, *l)) * a).powi(2)).sum::<f64>() / self.variance?;
        let count = known().count() as f64;
        Some(match self.spec.noise_sigma {
            Some(_) => chi_squared::upper_tail(distance, count),
            None => fisher::upper_tail(distance / count, count, self.degrees_of_freedom as f64),
        })
    }

    /// √n τ with τ² = Σλᵢ aᵢ² / Σλᵢ; 0 where the columns reach nothing.
    pub(crate) fn size_of_heights(&self) -> f64 {
        let (lambda, a) = (&self.spectrum.lambda, &self.spectrum.a);
        let total: f64 = lambda.iter().sum();
        let reached: f64 = lambda.iter().zip(a).map(|(l, a)| (l.sqrt() * a).powi(2)).sum();
        if total > 0.0 { (lambda.len() as f64 * (reached / total)).sqrt() } else { 0.0 }
    }

    /// Norm of the caller's coefficients in the scaled columns.
    pub(crate) fn norm_of(&self, coefficients: &[f64]) -> f64 {
        let ScaledColumns { kept, scale, .. } = self.columns;
        let scaled = kept.iter().zip(scale).filter_map(|(&j, scale)| Some(coefficients.get(j)? * scale.to_f64()));
        scaled.map(|a| a * a).sum::<f64>().sqrt()
    }

    /// Warns about the choice if the size of the coefficients is estimated from the same heights.
    pub(crate) fn judge(&self, choices: &[Choice], chosen: &Choice, warnings: &mut Vec<Warning>) {
        if self.spec.expected_size == ExpectedSize::Estimated {
            warn_about(choices, chosen, warnings);
        }
    }

    /// The report on a bias that has neither e nor Ineq. 51.
    pub(crate) fn bias(&self, norm: f64, sharp_bound: f64, r: f64) -> BiasReport {
        BiasReport {
            norm,
            sharp_bound,
            paper_bound: None,
            coefficient_norm_limit: r,
            coefficient_norm_limit_source: match (self.spec.coefficient_norm_limit, &self.spec.expected_size) {
                (Some(_), _) => NormLimitSource::Request,
                (None, ExpectedSize::Estimated) => NormLimitSource::Estimate,
                (None, ExpectedSize::OfHeights) => NormLimitSource::Heights,
                (None, ExpectedSize::Within(_)) => NormLimitSource::Limits,
            },
            upper_confidence: None,
            e: None,
        }
    }

    /// Says what was included but does not exist for this regularisation.
    pub(crate) fn warn_of_missing(&self, regularization: &'static str, curve: bool, warnings: &mut Vec<Warning>) {
        let include = self.spec.include;
        if include.lambda_curve && !curve {
            warnings.push(Warning::NoLambdaOf { regularization });
        }
        if include.matrix_b {
            warnings.push(Warning::MatrixBIsSpectral);
        }
        if include.representative {
            warnings.push(Warning::NoPieceToGive);
        }
        self.warn_of_trace(warnings);
    }

    pub(crate) fn warn_of_trace(&self, warnings: &mut Vec<Warning>) {
        if self.spec.include.ridge_trace {
            warnings.push(Warning::NoRidgeTrace);
        }
    }
}

/// Results of the regularisation.
pub(crate) struct Applied {
    pub estimate: Estimate,
    pub residuals: Residuals,
    /// Σ w r², as the spectral sums have it.
    pub rss: f64,
    pub spectrum: RegularizedSpectrum,
    pub regularization: RegularizationReport,
    pub bias: BiasReport,
    /// Sharp bound on each caller's coefficient.
    pub bounds: Vec<f64>,
    pub curve: Option<Vec<LambdaCurvePoint>>,
    pub trace: Option<Vec<RidgeTracePoint>>,
    pub matrix_b: Option<Vec<Vec<f64>>>,
    pub matrix_b_factors: Option<MatrixBFactors>,
    /// Input of the perturbation bounds; `None` if the estimate is not that of one matrix `X + B`.
    pub after: Option<perturbation::Estimate>,
    /// Map from least squares to the estimate.
    pub map: LinearMap,
    /// Present when something was known before.
    pub prior: Option<PriorApplied>,
    /// Present with `constraints`.
    pub constraints: Option<ConstraintsReport>,
    /// Part of the fit that others can use as representative piece, if it was included.
    pub representative: Option<Piece>,
}

impl Applied {
    /// Parts of the intervals of a posterior, if moves were estimated.
    pub(crate) fn posterior_intervals(&self) -> Option<&FormIntervals> {
        self.prior.as_ref()?.intervals.as_deref()
    }

    /// The noise by which the posterior of a prior was weighed, where there is one.
    pub(crate) fn pooled(&self) -> Option<PooledNoise> {
        self.prior.as_ref().and_then(|prior| prior.noise)
    }
}
