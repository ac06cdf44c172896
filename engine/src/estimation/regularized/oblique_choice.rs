//! λ along oblique directions, by every criterion.
//!
//! Residuals and trace are the sums of ridge with eigenvalues 1/δ (the standard form of the
//! problem), so `gcv`, `discrepancy` and the L-curve of (‖Y − XÂ‖, √P(Â)) are searched where those
//! of ridge are. The predicted mean squared error is in the scaled columns and the condition that
//! of `X̃ᵀX̃ + λP`; both have searches of their own.

use super::{context::Context, oblique::Oblique};
use crate::estimation::{
    error::FitError,
    result::{Choice, LambdaCurvePoint, Warning},
    selection::{Rule, Search, Spectral, Unavailable, choice::no_minimiser, range, scan},
    spec::{Criterion, Parameter},
};

/// The λ that stands.
pub struct Decided {
    /// `None` where the criterion has no answer: least squares stands.
    pub lambda_star: Option<f64>,
    pub criterion: Option<Criterion>,
    pub fixed: bool,
    pub choices: Vec<Choice>,
    pub standing: Choice,
    pub curve: Option<Vec<LambdaCurvePoint>>,
}

/// Decides for `oblique`.
pub fn decide(
    context: &Context,
    oblique: &Oblique,
    parameter: Parameter,
    warnings: &mut Vec<Warning>,
) -> Result<Decided, FitError> {
    let size = oblique.delta.len();
    let penalised = (oblique.silent..size).filter(|&i| oblique.delta[i] > 0.0).collect::<Vec<_>>();
    let lambda: Vec<f64> = penalised.iter().map(|&i| 1.0 / oblique.delta[i]).collect();
    let a: Vec<f64> = penalised.iter().map(|&i| oblique.a[i] * oblique.delta[i].sqrt()).collect();
    let rss = context.least_squares.rss;
    let free = size - oblique.silent - penalised.len() + context.unpenalised();
    let problem = Spectral::new(&lambda, &a, context.variance, rss, context.count(), free);
    let search = Search::new(&problem, Rule::Ridge);
    let ends = range(&problem, Rule::Ridge);
    let logarithms = ends.map(f64::ln);
    let choose = |criterion: Criterion| -> Result<(f64, bool), Unavailable> {
        match criterion {
            Criterion::MinMse if context.variance.is_none() => Err(Unavailable::NoSigma),
            Criterion::MinMse => {
                let at = |x: f64| oblique.mse(x.exp()).unwrap_or((f64::INFINITY, 0.0));
                Ok((scan::least(logarithms, at).exp(), true))
            }
            Criterion::MinCondition => {
                scan::turning(logarithms, |x| oblique.condition(x.exp()).map_or(-1.0, |(_, slope)| slope))
                    .map(|x| (x.exp(), true))
                    .ok_or(Unavailable::NoMinimiser)
            }
            _ => search.choose(criterion).map(|chosen| (chosen.lambda_star, chosen.reached)),
        }
    };
    let evaluate = |criterion: Option<Criterion>, lambda: f64| Choice {
        criterion,
        lambda_star: Some(lambda),
        condition: oblique.condition(lambda).map(|(condition, _)| condition),
        bias_norm: oblique.bias(lambda),
        predicted_mse: oblique.mse(lambda).map(|(mse, _)| mse),
        rms: ((rss + oblique.risen(lambda)) / context.weight).sqrt(),
    };
    let least_squares = Choice {
        criterion: None,
        lambda_star: None,
        condition: super::report::condition(context.spectrum.lambda.iter().copied()),
        bias_norm: 0.0,
        predicted_mse: oblique.mse(0.0).map(|(mse, _)| mse),
        rms: (rss / context.weight).sqrt(),
    };
    let mut choices = vec![least_squares.clone()];
    let mut asked = None;
    for criterion in Criterion::ALL {
        let answer = choose(criterion);
        if let Ok((lambda, _)) = answer {
            choices.push(evaluate(Some(criterion), lambda));
        }
        if parameter == Parameter::Criterion(criterion) {
            asked = Some(answer);
        }
    }
    let (lambda_star, criterion, fixed) = match (parameter, asked) {
        (Parameter::Fixed(lambda), _) => (Some(lambda), None, true),
        (Parameter::Criterion(criterion), Some(Ok((lambda, reached)))) => {
            if !reached {
                warnings.push(Warning {
                    code: "discrepancy_not_reached",
                    message: "the residuals stay below the noise for every λ*: the largest one is answered".into(),
                });
            }
            (Some(lambda), Some(criterion), false)
        }
        (Parameter::Criterion(criterion), Some(Err(Unavailable::NoSigma))) => {
            warnings.push(Warning {
                code: "criterion_unavailable",
                message: format!(
                    "{} needs σ: there are as many coefficients as nodes, so give noise_sigma; least squares is \
                     answered",
                    criterion.name()
                ),
            });
            (None, Some(criterion), false)
        }
        (Parameter::Criterion(criterion), _) => return Err(no_minimiser(criterion).into()),
    };
    let standing = lambda_star.map_or(least_squares, |lambda| evaluate(criterion, lambda));
    let curve = context.spec.include.lambda_curve.then(|| {
        const POINTS: usize = 60;
        let [low, high] = logarithms;
        (0..=POINTS)
            .map(|i| {
                let lambda_star = (low + (high - low) * (i as f64 / POINTS as f64)).exp();
                let choice = evaluate(None, lambda_star);
                let gcv = search.gcv(&problem.sums(Rule::Ridge, lambda_star));
                LambdaCurvePoint {
                    lambda_star,
                    condition: choice.condition,
                    bias_norm: choice.bias_norm,
                    predicted_mse: choice.predicted_mse,
                    rms: choice.rms,
                    gcv: gcv.is_finite().then_some(gcv),
                    coefficient_norm: oblique.norm(lambda_star),
                }
            })
            .collect()
    });
    Ok(Decided { lambda_star, criterion, fixed, choices, standing, curve })
}
