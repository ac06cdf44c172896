//! From what was asked for to the filter that stands, with every other criterion's choice beside
//! it.

use super::{
    classical::ridge_parameter,
    filter::{Rule, Spectral},
    lambda_star::{Chosen, Search, Unavailable, range},
};
use crate::estimation::{
    error::{Faults, FitError},
    result::{Choice, LambdaCurvePoint, RegularizationKind, Warning},
    spec::{Count, Criterion, Parameter, Regularization, Scheme},
};

/// The filter that stands.
pub struct Decided {
    pub kind: RegularizationKind,
    pub rule: Rule,
    /// λ* or k; `None` where nothing is regularised.
    pub chosen: Option<Chosen>,
    pub criterion: Option<Criterion>,
    pub fixed: bool,
    pub choices: Vec<Choice>,
    pub curve: Option<Vec<LambdaCurvePoint>>,
}

impl Decided {
    /// The parameter to evaluate the rule at.
    pub fn parameter(&self) -> f64 {
        self.chosen.map_or(0.0, |chosen| chosen.lambda_star)
    }
}

/// The rule asked for, with its parameter; `auto` counts the eigenvalues beyond the condition
/// limit.
pub fn rule(
    regularization: &Regularization,
    lambda: &[f64],
) -> Result<(RegularizationKind, Rule, Option<Parameter>), FitError> {
    match regularization {
        // the other kinds decide beside their own mathematics, in `regularized`
        Regularization::None
        | Regularization::Tikhonov(_)
        | Regularization::TruncatedSvd { .. }
        | Regularization::JamesStein(_)
        | Regularization::Attraction(_) => Ok((RegularizationKind::None, Rule::None, None)),
        Regularization::Ridge { parameter } => Ok((RegularizationKind::Ridge, Rule::Ridge, Some(*parameter))),
        Regularization::Spectral { scheme, count, condition_limit, lambda_star } => {
            let largest = lambda[lambda.len() - 1];
            let count = match count {
                Count::Auto => lambda.iter().filter(|l| largest / **l > *condition_limit).count().min(lambda.len() - 1),
                Count::Given(count) => checked_count(*count, lambda.len())?,
            };
            Ok((RegularizationKind::Spectral, Rule::Spectral { scheme: *scheme, count }, Some(*lambda_star)))
        }
    }
}

/// A number of eigenvalues to be regularised, out of `all`.
pub fn checked_count(count: usize, all: usize) -> Result<usize, Faults> {
    if count < all {
        return Ok(count);
    }
    Err(Faults::one(
        "/regularization/count",
        format!(
            "{count} of {all} eigenvalues: the largest one cannot be regularised, so at most {}",
            all.saturating_sub(1)
        ),
    ))
}

/// Decides for `problem` with coefficients `a` along its directions; `weight` is Σw, for the root
/// mean squares.
pub fn decide(
    regularization: &Regularization,
    problem: &Spectral,
    a: &[f64],
    weight: f64,
    want_curve: bool,
    warnings: &mut Vec<Warning>,
) -> Result<Decided, FitError> {
    let (kind, rule, parameter) = rule(regularization, problem.lambda)?;
    let evaluate = |criterion: Option<Criterion>, lambda_star: Option<f64>| {
        let rule = if lambda_star.is_some() { rule } else { Rule::None };
        let at = lambda_star.unwrap_or(0.0);
        let sums = problem.sums(rule, at);
        Choice {
            criterion,
            lambda_star,
            condition: problem.condition(rule, at),
            bias_norm: sums.bias.sqrt(),
            predicted_mse: problem.variance.map(|_| sums.mse[0]),
            rms: (sums.rss[0].max(0.0) / weight).sqrt(),
        }
    };
    let mut choices = vec![evaluate(None, None)];
    let nothing = |choices, curve| Decided {
        kind,
        rule: Rule::None,
        chosen: None,
        criterion: None,
        fixed: false,
        choices,
        curve,
    };
    let Some(parameter) = parameter else {
        if want_curve {
            warnings
                .push(Warning { code: "no_lambda_curve", message: "there is no λ* without regularisation".into() });
        }
        return Ok(nothing(choices, None));
    };
    let (criterion, fixed) = match parameter {
        Parameter::Criterion(criterion) => (Some(criterion), false),
        Parameter::Fixed(_) => (None, true),
    };
    if let Rule::Spectral { scheme, count: 0 } = rule {
        // nothing to regularise: every criterion answers least squares
        choices.extend(Criterion::ALL.map(|criterion| Choice { criterion: Some(criterion), ..choices[0].clone() }));
        let curve = want_curve.then(Vec::new);
        let rule = Rule::Spectral { scheme, count: 0 };
        return Ok(Decided { rule, criterion, fixed, ..nothing(choices, curve) });
    }
    let search = Search::new(problem, rule);
    let closed = if rule == Rule::Ridge { &Criterion::RIDGE[..] } else { &[] };
    let answers: Vec<(Criterion, Result<Chosen, Unavailable>)> = Criterion::ALL
        .into_iter()
        .map(|criterion| (criterion, search.choose(criterion)))
        .chain(closed.iter().map(|&criterion| (criterion, ridge_parameter(criterion, problem, a))))
        .collect();
    for (criterion, answer) in &answers {
        if let Ok(chosen) = answer {
            choices.push(evaluate(Some(*criterion), Some(chosen.lambda_star)));
        }
    }
    let chosen = match parameter {
        Parameter::Fixed(value) => Some(Chosen { lambda_star: value, interval: None, reached: true }),
        Parameter::Criterion(wanted) => {
            match answers.iter().find(|(criterion, _)| *criterion == wanted).map(|(_, answer)| *answer) {
                Some(Ok(chosen)) => Some(chosen),
                Some(Err(Unavailable::NoMinimiser)) | None => return Err(no_minimiser(wanted).into()),
                Some(Err(Unavailable::NoSigma)) => {
                    warnings.push(Warning {
                        code: "criterion_unavailable",
                        message: format!(
                            "{} needs σ: there are as many coefficients as nodes, so give noise_sigma; least squares \
                             is answered",
                            wanted.name()
                        ),
                    });
                    None
                }
            }
        }
    };
    if let Some(Chosen { reached: false, .. }) = chosen {
        warnings.push(Warning {
            code: "discrepancy_not_reached",
            message: "the residuals stay below the noise for every λ*: the largest one is answered".into(),
        });
    }
    let curve = want_curve.then(|| curve(&search, problem, rule, weight));
    Ok(Decided { kind, rule, chosen, criterion, fixed, choices, curve })
}

/// Why a criterion cannot be had of a regularisation at all.
pub fn no_minimiser(wanted: Criterion) -> Faults {
    let pointer = "/regularization/parameter/criterion";
    match wanted {
        Criterion::MinCondition => Faults::one(
            pointer,
            "there is no parameter of least condition: the condition falls for ever, or does not change at all",
        ),
        Criterion::Hkb | Criterion::Hkb1975 | Criterion::LawlessWang => Faults::one(
            pointer,
            format!(
                "`{}` is for ridge, and needs coefficients that are not all 0 (`hkb_1975` one, the others three)",
                wanted.name()
            ),
        ),
        _ => Faults::one(pointer, format!("`{}` is not for this regularisation", wanted.name())),
    }
}

/// About sixty points over the range of the search.
fn curve(search: &Search, problem: &Spectral, rule: Rule, weight: f64) -> Vec<LambdaCurvePoint> {
    let [low, high] = range(problem, rule);
    const POINTS: usize = 60;
    (0..=POINTS)
        .map(|i| {
            let lambda_star = low * (high / low).powf(i as f64 / POINTS as f64);
            let sums = problem.sums(rule, lambda_star);
            let gcv = search.gcv(&sums);
            LambdaCurvePoint {
                lambda_star,
                condition: problem.condition(rule, lambda_star),
                bias_norm: sums.bias.sqrt(),
                predicted_mse: problem.variance.map(|_| sums.mse[0]),
                rms: (sums.rss[0].max(0.0) / weight).sqrt(),
                gcv: gcv.is_finite().then_some(gcv),
                coefficient_norm: sums.norm[0].sqrt(),
            }
        })
        .collect()
}

/// What the caller should hear about the choice that stands.
pub fn warn_about(choices: &[Choice], chosen: &Choice, warnings: &mut Vec<Warning>) {
    let [least_squares, ..] = choices else { return };
    if let (Some(here), Some(there)) = (chosen.predicted_mse, least_squares.predicted_mse)
        && here > there * (1.0 + 1e-9)
    {
        let factor = here / there;
        let factor = match factor {
            _ if factor < 1e4 => format!("{factor:.2} times"),
            _ if factor.is_finite() => format!("{factor:.1e} times"),
            _ => "infinitely many times".to_owned(),
        };
        warnings.push(Warning {
            code: "worse_than_least_squares",
            message: format!(
                "this choice is predicted to have {factor} the mean squared coefficient error of plain least squares: \
                 the surface has a real component along the regularised directions; see regularization.choices"
            ),
        });
    }
}

/// The scheme and L, where there are any.
pub fn scheme_and_count(rule: Rule) -> (Option<Scheme>, Option<usize>) {
    match rule {
        Rule::Spectral { scheme, count } => (Some(scheme), Some(count)),
        Rule::None | Rule::Ridge => (None, None),
    }
}
