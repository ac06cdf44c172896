//! Target of a shrinkage, and the uniform shrinkage `T + c (Â − T)`.
//!
//! T is a vector of the caller, or the grand mean: the constant function ȳ, whose coefficients `κ
//! ȳ` come from the same heights. In the second case `Π = κ̃ hᵀ` projects on the constant (`h =
//! X̃ᵀΩ1/Σw`), the estimate is `(cI + (1−c)Π) Â`, and its variance is that of the mean plus c²
//! times the rest, for the two are independent.

use nalgebra::DMatrix;

use super::{
    context::{Applied, Context},
    linear_map::{LinearMap, TargetBias},
    report::{regularized_spectrum, report},
};
use crate::{
    design::{Axis, Basis},
    error::FitError,
    estimate::Estimate,
    factor::multiply_upper_vector,
    problem::Evidence,
    result::{Choice, RegularizationKind, RegularizationReport, Warning},
    selection::Filtered,
    spec::ChosenBy,
};
use flankfit_numerics::{Dd, Real, check::Faults};

/// The target, in every coordinate that is needed.
pub(super) struct AttractionTarget<'a> {
    context: &'a Context<'a>,
    /// T in the caller's terms; of standardised columns the constant follows from the others.
    caller: Vec<Dd>,
    /// `Vᵢᵀ T̃`.
    along: Vec<f64>,
    /// `aᵢ − Vᵢᵀ T̃`.
    pub away: Vec<f64>,
    /// The constant 1, where T is the grand mean.
    mean: Option<Constant>,
}

/// The function 1 in this model.
struct Constant {
    /// Its coefficients in the caller's terms.
    caller: Vec<f64>,
    /// `Vᵢᵀ κ̃`.
    along: Vec<f64>,
}

impl<'a> AttractionTarget<'a> {
    /// A vector of the caller (as long as there are coefficients), 0 where none is given.
    pub(super) fn at(context: &'a Context<'a>, target: Option<&[f64]>, warnings: &mut Vec<Warning>) -> Self {
        let n = context.linear.design.size();
        let given = |j: usize| target.map_or(0.0, |t| t[j]);
        if let Some(constant) = &context.columns.constant
            && given(constant.index) != 0.0
        {
            warnings.push(Warning::TargetOfConstantUnused);
        }
        Self::with((0..n).map(|j| Dd::from(given(j))).collect(), None, context)
    }

    /// The grand mean of the heights; of standardised columns it is what the unpenalised constant
    /// does anyway.
    pub(super) fn at_the_mean(context: &'a Context<'a>, warnings: &mut Vec<Warning>) -> Result<Self, FitError> {
        if context.columns.constant.is_some() {
            return Ok(Self::at(context, None, warnings));
        }
        let Some(constant) = Constant::new(context) else {
            return Err(Faults::one(
                "regularization.variant",
                "`efron_morris` shrinks to the grand mean, which these columns cannot represent: give a target",
            )
            .into());
        };
        // 1ᵀΩz = (X̃κ̃)ᵀΩz, of which Qᵀ√Ωz knows all
        let factor = context.linear.factor;
        let mut image: Vec<Dd> = constant.caller.iter().map(|&x| Dd::from(x)).collect();
        multiply_upper_vector(&factor.change, &mut image);
        multiply_upper_vector(&factor.r, &mut image);
        let sum = image.iter().zip(&factor.qty).fold(Dd::ZERO, |sum, (&x, &b)| sum + x * b);
        let mean = sum / context.weight;
        let caller = constant.caller.iter().map(|&x| mean.mul_f64(x)).collect();
        Ok(Self::with(caller, Some(constant), context))
    }

    fn with(mut caller: Vec<Dd>, mean: Option<Constant>, context: &'a Context<'a>) -> Self {
        let columns = context.columns;
        if let Some(constant) = &columns.constant {
            let kept = columns.kept.iter().zip(&constant.means);
            caller[constant.index] = kept.fold(context.spectrum.level, |level, (&j, &mean)| level - mean * caller[j]);
        }
        let plain: Vec<f64> = caller.iter().map(|x| x.to_f64()).collect();
        let along = along(context, &plain);
        let away = context.spectrum.a.iter().zip(&along).map(|(a, t)| a - t).collect();
        AttractionTarget { context, caller, along, away, mean }
    }

    /// Numerically nonzero directions, which are drawn to the target.
    pub(super) fn directions(&self) -> usize {
        self.context.spectrum.rank - usize::from(self.mean.is_some())
    }

    fn nonzero(&self) -> impl Iterator<Item = (usize, f64)> {
        self.context.spectrum.lambda.iter().copied().enumerate().filter(|(_, lambda)| *lambda > 0.0)
    }

    /// `Q = ‖X(Â − T)‖²`.
    pub(super) fn reach(&self) -> f64 {
        self.nonzero().map(|(i, lambda)| lambda * self.away[i] * self.away[i]).sum()
    }

    /// Variance of the mean along direction i, for σ = 1.
    fn mean_share(&self, i: usize) -> f64 {
        self.mean.as_ref().map_or(0.0, |constant| constant.along[i] * constant.along[i] / self.context.weight)
    }

    /// `S = Σ max((aᵢ−tᵢ)² − σ²/λᵢ, 0)`, what of the distance is more than noise, and `N = Σ
    /// σ²/λᵢ`, the noise.
    pub(super) fn signal_and_noise(&self, variance: f64) -> (f64, f64) {
        self.nonzero().fold((0.0, 0.0), |(signal, noise), (i, lambda)| {
            let own = variance * (1.0 / lambda - self.mean_share(i)).max(0.0);
            (signal + (self.away[i] * self.away[i] - own).max(0.0), noise + own)
        })
    }

    /// Results of factor `c`, to be listed with those of the criteria.
    pub(super) fn choice(&self, c: f64) -> Choice {
        let context = self.context;
        let distance = self.away.iter().map(|d| d * d).sum::<f64>().sqrt();
        Choice {
            criterion: ChosenBy::LeastSquares,
            lambda_star: None,
            condition: super::report::condition(context.spectrum.lambda.iter().copied()),
            bias_norm: (1.0 - c).abs() * distance,
            predicted_mse: context.variance.map(|variance| {
                let (signal, noise) = self.signal_and_noise(variance);
                let mean: f64 = self.nonzero().map(|(i, _)| variance * self.mean_share(i)).sum();
                (1.0 - c) * (1.0 - c) * signal + c * c * noise + mean
            }),
            rms: (self.rss(c) / context.weight).sqrt(),
        }
    }

    /// `‖Y − X Â_c‖²`, since Â − T lies at right angles to the residuals.
    pub(super) fn rss(&self, c: f64) -> f64 {
        self.context.least_squares.rss + (1.0 - c) * (1.0 - c) * self.reach()
    }

    /// `‖T + c(Â − T)‖` in the scaled columns.
    pub(super) fn norm(&self, c: f64) -> f64 {
        self.along.iter().zip(&self.away).map(|(t, d)| (t + c * d).powi(2)).sum::<f64>().sqrt()
    }

    /// Sharp bounds on the bias for `‖A‖ ≤ r`: of the vector, and of each caller's coefficient.
    fn bounds(&self, c: f64, r: f64, directions: &DMatrix<f64>) -> (f64, Vec<f64>) {
        let removed = (1.0 - c).abs();
        let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>().sqrt();
        let bias = self.bias();
        let whole = match &bias.mean {
            None => removed * (r + norm(&mut bias.target.iter().copied())),
            // ‖I − Π‖ = ‖Π‖ for a projection that is neither 0 nor I
            Some((kappa, h)) => removed * r * norm(&mut kappa.iter().copied()) * norm(&mut h.iter().copied()),
        };
        let each = directions.row_iter().map(|row| bias.of(removed, r, &row.iter().copied().collect::<Vec<_>>()));
        (whole, each.collect())
    }

    /// Quantities that bound the bias.
    fn bias(&self) -> TargetBias {
        let h = |kappa: &[f64]| {
            let entries = kappa.iter().zip(&self.context.spectrum.lambda);
            entries.map(|(kappa, lambda)| lambda * kappa / self.context.weight).collect()
        };
        let mean = self.mean.as_ref().map(|constant| (constant.along.clone(), h(&constant.along)));
        TargetBias { target: self.along.clone(), mean }
    }

    /// The direction that is estimated without shrinkage, in Q's coordinates, of length 1: that of
    /// the constant.
    fn kept(&self) -> Option<Vec<f64>> {
        let factor = self.context.linear.factor;
        let mut image: Vec<Dd> = match (&self.mean, &self.context.columns.constant) {
            (Some(constant), _) => constant.caller.iter().map(|&x| Dd::from(x)).collect(),
            (None, Some(constant)) => {
                (0..factor.size()).map(|j| if j == constant.index { Dd::ONE } else { Dd::ZERO }).collect()
            }
            (None, None) => return None,
        };
        multiply_upper_vector(&factor.change, &mut image);
        multiply_upper_vector(&factor.r, &mut image);
        let length = image.iter().fold(Dd::ZERO, |sum, &x| sum + x * x).sqrt();
        Some(image.iter().map(|&x| (x / length).to_f64()).collect())
    }

    /// The estimate with factor `c`, `factors` standing for it in the answer.
    pub(super) fn apply(&self, c: f64, regularization: RegularizationReport, warnings: &mut Vec<Warning>) -> Applied {
        let context = self.context;
        let Context { spectrum, columns, least_squares, linear, spec, .. } = *context;
        let filtered: Vec<Filtered> =
            spectrum.lambda.iter().map(|&eigenvalue| Filtered { factor: c, removed: 1.0 - c, eigenvalue }).collect();
        let mut estimate = Estimate::new(columns, spectrum, &filtered, least_squares);
        for (j, value) in estimate.coefficients.iter_mut().enumerate() {
            *value = (self.caller[j].mul_f64(1.0 - c) + Dd::product(c, least_squares.coefficients[j])).to_f64();
        }
        if let Some(constant) = &self.mean {
            for (spread, kappa) in estimate.spread.iter_mut().zip(&constant.caller) {
                *spread = (*spread * *spread + (1.0 - c * c) * kappa * kappa / context.weight).max(0.0).sqrt();
            }
        }
        let mut working = self.caller.clone();
        multiply_upper_vector(&linear.factor.change, &mut working);
        for (to, &whole) in working.iter_mut().zip(&least_squares.working) {
            *to = to.mul_f64(1.0 - c) + whole.mul_f64(c);
        }
        let residuals = linear.of_working(&working, spec.include.residuals);
        let r = context.norm_limit(self.norm(c), warnings);
        let (sharp, bounds) = self.bounds(c, r, &estimate.directions);
        Applied {
            rss: self.rss(c),
            residuals,
            // drawing the estimate to a target does not change the matrix
            spectrum: regularized_spectrum(spectrum.lambda.clone()),
            regularization: RegularizationReport { filter_factors: vec![c; spectrum.lambda.len()], ..regularization },
            bias: context.bias(self.choice(c).bias_norm, sharp, r),
            bounds,
            curve: None,
            trace: None,
            matrix_b: None,
            matrix_b_factors: None,
            // the factor follows the nodes
            after: None,
            map: LinearMap::Toward { factor: c, kept: self.kept(), bias: self.bias(), working },
            prior: None,
            constraints: None,
            representative: None,
            estimate,
        }
    }

    /// A report of `kind` with least squares as the first choice.
    pub(super) fn report(&self, kind: RegularizationKind) -> RegularizationReport {
        RegularizationReport { choices: vec![self.choice(1.0)], ..report(kind) }
    }
}

/// `Vᵢᵀ` of coefficients of the caller.
fn along(context: &Context, caller: &[f64]) -> Vec<f64> {
    let columns = context.columns;
    let scaled: Vec<f64> = columns.kept.iter().zip(&columns.scale).map(|(&j, s)| caller[j] * s.to_f64()).collect();
    context.spectrum.v.column_iter().map(|v| v.iter().zip(&scaled).map(|(v, s)| v * s).sum()).collect()
}

impl Constant {
    /// `None` where the columns cannot add up to 1.
    fn new(context: &Context) -> Option<Self> {
        let Context { linear, spectrum, columns, weight, .. } = *context;
        let n = linear.design.size();
        let caller: Vec<f64> = match (&linear.design.basis, linear.design.constant) {
            (Basis::Product { u: Axis::Spline(_), .. } | Basis::Product { v: Axis::Spline(_), .. }, _) => vec![1.0; n],
            (Basis::Product { .. }, _) => (0..n).map(|j| if j == 0 { 1.0 } else { 0.0 }).collect(),
            (Basis::Columns { .. }, Some(constant)) => {
                let value = match linear.evidence {
                    Evidence::Posted { sample, .. } => sample.matrix_row(0)[constant],
                    Evidence::Summed(_) => {
                        let sum = linear.factor.ones.as_ref()?[constant];
                        (linear.factor.change[(constant, constant)] * sum).to_f64() / weight
                    }
                };
                (0..n).map(|j| if j == constant { 1.0 / value } else { 0.0 }).collect()
            }
            (Basis::Columns { .. }, None) => {
                // X̃ᵀΩ1 along the directions, T being diagonal here
                let ones = linear.factor.ones.as_ref()?;
                let sums: Vec<f64> = columns
                    .kept
                    .iter()
                    .zip(&columns.scale)
                    .map(|(&j, s)| (linear.factor.change[(j, j)] * ones[j] / *s).to_f64())
                    .collect();
                let mut seen = 0.0;
                let mut scaled = vec![0.0; columns.kept.len()];
                for (i, &lambda) in spectrum.lambda.iter().enumerate().filter(|(_, lambda)| **lambda > 0.0) {
                    let v = spectrum.v.column(i);
                    let share: f64 = v.iter().zip(&sums).map(|(v, s)| v * s).sum();
                    seen += share * share / lambda;
                    scaled.iter_mut().zip(v.iter()).for_each(|(to, v)| *to += share / lambda * v);
                }
                if (weight - seen).abs() > 1e-9 * weight {
                    return None;
                }
                let mut caller = vec![0.0; n];
                for ((&j, s), x) in columns.kept.iter().zip(&columns.scale).zip(&scaled) {
                    caller[j] = x / s.to_f64();
                }
                caller
            }
        };
        Some(Constant { along: along(context, &caller), caller })
    }
}
