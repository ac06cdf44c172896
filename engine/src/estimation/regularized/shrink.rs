//! Estimates drawn to a target by one factor: James–Stein, and attraction with its explicit
//! optimum.
//!
//! Attraction: `Â_k = (Â + kT)/(1+k)`, so c = 1/(1+k). Its predicted mean squared error in the
//! scaled columns is `(1−c)² S + c² N` with `S = Σ max((aᵢ−tᵢ)² − σ²/λᵢ, 0)` and `N = Σ σ²/λᵢ`; the
//! derivative by c vanishes at `c = S/(S+N)`, that is at **k = N/S**. With S = 0 nothing of Â − T
//! stands out of the noise: k is infinite and T itself the answer.

use super::{
    context::{Applied, Context},
    target::Aim,
};
use crate::estimation::{
    error::{Faults, FitError},
    result::{Choice, LambdaCurvePoint, RegularizationKind, RegularizationReport, Warning},
    selection::{Rule, Search, Spectral, Unavailable, choice::no_minimiser, range},
    spec::{Attraction, Criterion, JamesStein, Parameter, ShrinkageFactor},
};

/// Refuses to shrink fewer directions than pay for their factor.
pub fn check_directions(p: usize) -> Result<(), Faults> {
    if p >= 3 {
        return Ok(());
    }
    Err(Faults::one(
        "/regularization/type",
        format!("James–Stein needs three directions to shrink; there are {p} here (the grand mean takes one)"),
    ))
}

/// Shrinks by the factor that the data give.
pub fn james_stein(context: &Context, asked: &JamesStein, warnings: &mut Vec<Warning>) -> Result<Applied, FitError> {
    let aim = match (asked.factor, &asked.target) {
        (ShrinkageFactor::EfronMorris, None) => Aim::at_the_mean(context, warnings)?,
        (_, target) => Aim::at(context, target.as_deref(), warnings),
    };
    let p = aim.directions();
    check_directions(p)?;
    context.warn_of_missing("James–Stein", false, warnings);
    let variance = match (context.spec.noise_sigma, asked.factor) {
        (None, ShrinkageFactor::JamesStein | ShrinkageFactor::EfronMorris) => {
            context.variance.map(|_| context.least_squares.rss / (context.degrees_of_freedom as f64 + 2.0))
        }
        _ => context.variance,
    };
    let factor = variance.map(|variance| {
        let reach = aim.reach();
        // Â is T already: every factor gives the same
        if reach == 0.0 {
            return 1.0;
        }
        let factor = 1.0 - (p as f64 - 2.0) * variance / reach;
        if asked.positive_part { factor.max(0.0) } else { factor }
    });
    if factor.is_none() {
        unavailable("James–Stein", warnings);
    }
    let c = factor.unwrap_or(1.0);
    let report = aim.report(RegularizationKind::JamesStein);
    context.judge(&report.choices, &aim.choice(c), warnings);
    Ok(aim.apply(c, RegularizationReport { shrinkage_factor: factor, ..report }, warnings))
}

fn unavailable(what: &str, warnings: &mut Vec<Warning>) {
    warnings.push(Warning {
        code: "criterion_unavailable",
        message: format!(
            "{what} needs σ: there are as many coefficients as nodes, so give noise_sigma; least squares is answered"
        ),
    });
}

/// A factor with the weight that it comes from; an infinite weight is none.
#[derive(Clone, Copy)]
struct Drawn {
    weight: Option<f64>,
    factor: f64,
    reached: bool,
}

impl Drawn {
    fn by(weight: f64) -> Self {
        Drawn { weight: Some(weight), factor: 1.0 / (1.0 + weight), reached: true }
    }
}

/// Draws Â to the target with the weight asked for.
pub fn attraction(context: &Context, asked: &Attraction, warnings: &mut Vec<Warning>) -> Result<Applied, FitError> {
    let aim = Aim::at(context, Some(&asked.target), warnings);
    context.warn_of_missing("attraction", true, warnings);
    // seen from T, every direction of X(Â − T) is alike: the sums of ridge with eigenvalue 1
    let lambda = vec![1.0; aim.directions()];
    let away: Vec<f64> = context
        .spectrum
        .lambda
        .iter()
        .zip(&aim.away)
        .filter(|(lambda, _)| **lambda > 0.0)
        .map(|(lambda, d)| lambda.sqrt() * d)
        .collect();
    let problem = Spectral::new(
        &lambda,
        &away,
        context.variance,
        context.least_squares.rss,
        context.count(),
        context.unpenalised(),
    );
    let search = (!lambda.is_empty()).then(|| Search::new(&problem, Rule::Ridge));
    let choose = |criterion: Criterion| -> Result<Drawn, Unavailable> {
        match (criterion, &search) {
            (Criterion::Optimal | Criterion::MinMse, _) => {
                let (signal, noise) = aim.signal_and_noise(context.variance.ok_or(Unavailable::NoSigma)?);
                Ok(match noise / signal {
                    weight if weight.is_finite() => Drawn::by(weight),
                    // neither signal nor noise: Â is T
                    _ if noise == 0.0 => Drawn::by(0.0),
                    _ => Drawn { weight: None, factor: 0.0, reached: true },
                })
            }
            (_, Some(search)) => search
                .choose(criterion)
                .map(|chosen| Drawn { reached: chosen.reached, ..Drawn::by(chosen.lambda_star) }),
            _ => Err(Unavailable::NoMinimiser),
        }
    };
    let mut report = aim.report(RegularizationKind::Attraction);
    for criterion in [Criterion::Optimal].into_iter().chain(Criterion::ALL) {
        if let Ok(drawn) = choose(criterion) {
            report.choices.push(Choice {
                criterion: Some(criterion),
                lambda_star: drawn.weight,
                ..aim.choice(drawn.factor)
            });
        }
    }
    let drawn = match asked.parameter {
        Parameter::Fixed(weight) => Some(Drawn::by(weight)),
        Parameter::Criterion(criterion) => match choose(criterion) {
            Ok(drawn) => Some(drawn),
            Err(Unavailable::NoMinimiser) => return Err(no_minimiser(criterion).into()),
            Err(Unavailable::NoSigma) => {
                unavailable(criterion.name(), warnings);
                None
            }
        },
    };
    match drawn {
        Some(Drawn { weight: None, .. }) => warnings.push(Warning {
            code: "attracted_entirely",
            message:
                "nothing of the distance to the target stands out of the noise: the target itself is answered, and \
                      the weight, which would be infinite, is left out"
                    .into(),
        }),
        Some(Drawn { reached: false, .. }) => warnings.push(Warning {
            code: "discrepancy_not_reached",
            message: "the residuals stay below the noise for every weight: the largest one is answered".into(),
        }),
        _ => {}
    }
    let c = drawn.map_or(1.0, |drawn| drawn.factor);
    context.judge(&report.choices, &aim.choice(c), warnings);
    report.lambda_star = drawn.and_then(|drawn| drawn.weight);
    report.shrinkage_factor = drawn.map(|drawn| drawn.factor);
    (report.criterion, report.fixed) = match asked.parameter {
        Parameter::Criterion(criterion) => (Some(criterion), false),
        Parameter::Fixed(_) => (None, true),
    };
    let curve =
        search.filter(|_| context.spec.include.lambda_curve).map(|search| curve(context, &aim, &problem, &search));
    Ok(Applied { curve, ..aim.apply(c, report, warnings) })
}

/// About sixty points over the range of the search.
fn curve(context: &Context, aim: &Aim, problem: &Spectral, search: &Search) -> Vec<LambdaCurvePoint> {
    const POINTS: usize = 60;
    let [low, high] = range(problem, Rule::Ridge);
    (0..=POINTS)
        .map(|i| {
            let lambda_star = low * (high / low).powf(i as f64 / POINTS as f64);
            let c = Drawn::by(lambda_star).factor;
            let Choice { condition, bias_norm, predicted_mse, .. } = aim.choice(c);
            let gcv = search.gcv(&problem.sums(Rule::Ridge, lambda_star));
            LambdaCurvePoint {
                lambda_star,
                condition,
                bias_norm,
                predicted_mse,
                rms: (aim.rss(c) / context.weight).sqrt(),
                gcv: gcv.is_finite().then_some(gcv),
                coefficient_norm: aim.norm(c),
            }
        })
        .collect()
}
