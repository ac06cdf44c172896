//! Estimates drawn to a target by one factor: James–Stein, and attraction with its explicit
//! optimum.
//!
//! Attraction: `Â_k = (Â + kT)/(1+k)`, so c = 1/(1+k). Its predicted mean squared error in the
//! scaled columns is `(1−c)² S + c² N` with `S = Σ max((aᵢ−tᵢ)² − σ²/λᵢ, 0)` and `N = Σ σ²/λᵢ`; the
//! derivative by c vanishes at `c = S/(S+N)`, that is at **k = N/S**. With S = 0 no part of Â − T
//! exceeds the noise: k is infinite and the estimate is T itself.

use super::{
    context::{Applied, Context},
    report::report,
    target::AttractionTarget,
};
use crate::{
    error::FitError,
    result::{Choice, LambdaCurvePoint, RegularizationKind, RegularizationReport, Warning},
    selection::{
        Place, Rule, Search, Spectral, Unavailable, range,
        selector::{Comparison, ParameterProblem, select},
    },
    spec::{Attraction, Criterion, JamesStein, ShrinkageFactor},
};
use flankfit_numerics::check::Faults;

/// Refuses to shrink fewer directions than pay for their factor.
pub(super) fn check_directions(p: usize) -> Result<(), Faults> {
    if p >= 3 {
        return Ok(());
    }
    Err(Faults::one(
        "regularization.type",
        format_args!("James–Stein needs three directions; there are {p} here (the grand mean uses one)"),
    ))
}

/// Shrinks by the factor that the data give.
pub(super) fn james_stein(
    context: &Context,
    asked: &JamesStein,
    warnings: &mut Vec<Warning>,
) -> Result<Applied, FitError> {
    let target = match (asked.factor, &asked.target) {
        (ShrinkageFactor::EfronMorris, None) => AttractionTarget::at_the_mean(context, warnings)?,
        (_, target) => AttractionTarget::at(context, target.as_deref(), warnings),
    };
    let p = target.directions();
    check_directions(p)?;
    context.warn_of_missing("james_stein", false, warnings);
    let variance = match (context.spec.noise_sigma, asked.factor) {
        (None, ShrinkageFactor::JamesStein | ShrinkageFactor::EfronMorris) => {
            context.variance.map(|_| context.least_squares.rss / (context.degrees_of_freedom as f64 + 2.0))
        }
        _ => context.variance,
    };
    let factor = variance.map(|variance| {
        let reach = target.reach();
        // Â is T already: every factor gives the same
        if reach == 0.0 {
            return 1.0;
        }
        let factor = 1.0 - (p as f64 - 2.0) * variance / reach;
        if asked.positive_part { factor.max(0.0) } else { factor }
    });
    if factor.is_none() {
        warnings.push(Warning::SigmaMissing { criterion: "james_stein" });
    }
    let c = factor.unwrap_or(1.0);
    let report = target.report(RegularizationKind::JamesStein);
    context.judge(&report.choices, &target.choice(c), warnings);
    Ok(target.apply(c, RegularizationReport { shrinkage_factor: factor, ..report }, warnings))
}

/// A factor with the weight that it comes from; an infinite weight is none.
#[derive(Clone, Copy)]
struct Drawn {
    weight: Option<f64>,
    factor: f64,
    place: Place,
}

impl Drawn {
    fn by(weight: f64) -> Self {
        Drawn { weight: Some(weight), factor: 1.0 / (1.0 + weight), place: Place::Inside }
    }
}

/// Draws Â to the target with the requested weight.
pub(super) fn attraction(
    context: &Context,
    asked: &Attraction,
    warnings: &mut Vec<Warning>,
) -> Result<Applied, FitError> {
    let target = AttractionTarget::at(context, Some(&asked.target), warnings);
    context.warn_of_missing("attraction", true, warnings);
    // seen from T, every direction of X(Â − T) is alike: the sums of ridge with eigenvalue 1
    let lambda = vec![1.0; target.directions()];
    let away: Vec<f64> = context
        .spectrum
        .lambda
        .iter()
        .zip(&target.away)
        .filter(|(lambda, _)| **lambda > 0.0)
        .map(|(lambda, d)| lambda.sqrt() * d)
        .collect();
    let problem = context.spectral_problem(&lambda, &away);
    let search = (!lambda.is_empty()).then(|| Search::new(&problem, Rule::Ridge));
    let want_curve = search.is_some() && context.spec.include.lambda_curve;
    let attracted = Attracted { target: &target, problem: &problem, search };
    let selection = select(&attracted, asked.parameter, want_curve, warnings)?;
    let drawn = selection.answer;
    if let Some(Drawn { weight: None, .. }) = drawn {
        warnings.push(Warning::AttractedEntirely);
    }
    let c = drawn.map_or(1.0, |drawn| drawn.factor);
    context.judge(&selection.choices, &target.choice(c), warnings);
    let report = RegularizationReport {
        lambda_star: drawn.and_then(|drawn| drawn.weight),
        shrinkage_factor: drawn.map(|drawn| drawn.factor),
        criterion: selection.chosen_by(),
        choices: selection.choices,
        ..report(RegularizationKind::Attraction)
    };
    Ok(Applied { curve: selection.curve, ..target.apply(c, report, warnings) })
}

/// Attraction to a target, and the same as ridge.
struct Attracted<'a> {
    target: &'a AttractionTarget<'a>,
    problem: &'a Spectral<'a>,
    /// `None` where no direction is numerically nonzero.
    search: Option<Search<'a>>,
}

impl ParameterProblem for Attracted<'_> {
    type Answer = Drawn;
    type Refusal = Unavailable;

    fn fixed(&self, parameter: f64) -> Result<Drawn, Unavailable> {
        Ok(Drawn::by(parameter))
    }

    fn choose(&self, criterion: Criterion) -> Result<Drawn, Unavailable> {
        match (criterion, &self.search) {
            (Criterion::Optimal | Criterion::MinMse, _) => {
                let variance = self.problem.variance.ok_or(Unavailable::NoSigma)?;
                let (signal, noise) = self.target.signal_and_noise(variance);
                Ok(match noise / signal {
                    weight if weight.is_finite() => Drawn::by(weight),
                    // neither signal nor noise: Â is T
                    _ if noise == 0.0 => Drawn::by(0.0),
                    _ => Drawn { weight: None, factor: 0.0, place: Place::Inside },
                })
            }
            (_, Some(search)) => {
                search.choose(criterion).map(|chosen| Drawn { place: chosen.place, ..Drawn::by(chosen.lambda_star) })
            }
            _ => Err(Unavailable::NoMinimiser),
        }
    }
}

impl Comparison for Attracted<'_> {
    const PARAMETER: &'static str = "weight";

    fn criteria(&self) -> impl Iterator<Item = Criterion> {
        [Criterion::Optimal].into_iter().chain(Criterion::ALL)
    }

    fn place(answer: &Drawn) -> Place {
        answer.place
    }

    fn figures(&self, criterion: Option<Criterion>, answer: Option<Drawn>) -> Choice {
        let lambda_star = answer.and_then(|drawn| drawn.weight);
        Choice {
            criterion: criterion.into(),
            lambda_star,
            ..self.target.choice(answer.map_or(1.0, |drawn| drawn.factor))
        }
    }

    fn at_share(&self, share: f64) -> f64 {
        let [low, high] = range(self.problem, Rule::Ridge);
        low * (high / low).powf(share)
    }

    fn curve_point(&self, lambda_star: f64) -> LambdaCurvePoint {
        let c = Drawn::by(lambda_star).factor;
        let Choice { condition, bias_norm, predicted_mse, rms, .. } = self.target.choice(c);
        let sums = self.problem.sums(Rule::Ridge, lambda_star);
        let gcv = self.search.as_ref().map(|search| search.gcv(&sums));
        LambdaCurvePoint {
            lambda_star,
            condition,
            bias_norm,
            predicted_mse,
            rms,
            gcv: gcv.filter(|gcv| gcv.is_finite()),
            coefficient_norm: self.target.norm(c),
        }
    }
}
