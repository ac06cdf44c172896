//! λ along oblique directions, by every criterion.
//!
//! Residuals and trace are the sums of ridge with eigenvalues 1/δ (the standard form of the
//! problem), so `gcv`, `discrepancy` and the L-curve of (‖Y − XÂ‖, √P(Â)) are searched where those
//! of ridge are. The predicted mean squared error is in the scaled columns and the condition that
//! of `X̃ᵀX̃ + λP`; both have searches of their own.

use nalgebra::DMatrix;

use super::{context::Context, node_shares, oblique::Oblique};
use crate::{
    error::FitError,
    result::{Choice, LambdaCurvePoint, Warning},
    selection::{
        Chosen, LeftOut, Place, Rule, Search, Spectral, Unavailable, range, scan,
        selector::{Comparison, ParameterProblem, Selection, select},
    },
    spec::{ChosenBy, Criterion, Parameter},
};

/// Greatest number of coefficients for which the least condition is computed unasked.
const COMPARED_UP_TO: usize = 64;

/// The λ that is used, with its figures.
pub(super) struct SelectedPenalty {
    pub selection: Selection<Lambda>,
    pub figures: Choice,
}

/// λ and its position in the search range.
#[derive(Clone, Copy)]
pub(super) struct Lambda {
    pub value: f64,
    place: Place,
}

impl From<Chosen> for Lambda {
    fn from(chosen: Chosen) -> Self {
        Lambda { value: chosen.lambda_star, place: chosen.place }
    }
}

/// Decides for `oblique`, whose directions are the columns of `images` in Q's coordinates.
pub(super) fn decide(
    context: &Context,
    oblique: &Oblique,
    images: &DMatrix<f64>,
    parameter: Parameter,
    warnings: &mut Vec<Warning>,
) -> Result<SelectedPenalty, FitError> {
    node_shares::check(context)?;
    let size = oblique.delta.len();
    let penalised = (oblique.silent..size).filter(|&i| oblique.delta[i] > 0.0).collect::<Vec<_>>();
    let lambda: Vec<f64> = penalised.iter().map(|&i| 1.0 / oblique.delta[i]).collect();
    let a: Vec<f64> = penalised.iter().map(|&i| oblique.a[i] * oblique.delta[i].sqrt()).collect();
    let rss = context.least_squares.rss;
    let free = size - oblique.silent - penalised.len() + context.unpenalised();
    let problem =
        Spectral::new(&lambda, &a, context.variance, rss, context.count(), free).with_sigma(context.spec.noise_sigma);
    let search = Search::new(&problem, Rule::Ridge);
    let logarithms = range(&problem, Rule::Ridge).map(f64::ln);
    let nodewise = || {
        let along = DMatrix::from_fn(images.nrows(), penalised.len(), |k, i| images[(k, penalised[i])]);
        node_shares::left_out(context, &along, penalised.iter().map(|&i| oblique.a[i]).collect())
    };
    let penalty = Penalised { context, oblique, problem: &problem, search, logarithms, nodewise: &nodewise };
    let selection = select(&penalty, parameter, context.spec.include.lambda_curve, warnings)?;
    if let Some(answer) = selection.answer {
        oblique.prepare(answer.value);
    }
    let figures = penalty.figures(selection.criterion.filter(|_| selection.answer.is_some()), selection.answer);
    Ok(SelectedPenalty { selection, figures })
}

/// λ for other heights, by one criterion alone.
pub(super) fn again(
    context: &Context,
    oblique: &Oblique,
    variance: f64,
    rss: f64,
    parameter: Parameter,
) -> Option<f64> {
    let size = oblique.delta.len();
    let penalised = || (oblique.silent..size).filter(|&i| oblique.delta[i] > 0.0);
    let lambda: Vec<f64> = penalised().map(|i| 1.0 / oblique.delta[i]).collect();
    let a: Vec<f64> = penalised().map(|i| oblique.a[i] * oblique.delta[i].sqrt()).collect();
    let free = size - oblique.silent - lambda.len() + context.unpenalised();
    let problem =
        Spectral::new(&lambda, &a, Some(variance), rss, context.count(), free).with_sigma(context.spec.noise_sigma);
    let search = Search::new(&problem, Rule::Ridge);
    let logarithms = range(&problem, Rule::Ridge).map(f64::ln);
    let nodewise = || None;
    let penalty = Penalised { context, oblique, problem: &problem, search, logarithms, nodewise: &nodewise };
    penalty.answer(parameter).ok().map(|lambda| lambda.value)
}

/// A penalty along oblique directions, and the same as ridge.
struct Penalised<'a> {
    context: &'a Context<'a>,
    oblique: &'a Oblique,
    problem: &'a Spectral<'a>,
    search: Search<'a>,
    /// ln λ is searched between these.
    logarithms: [f64; 2],
    /// The nodes along the directions that are penalised.
    nodewise: &'a dyn Fn() -> Option<LeftOut>,
}

impl ParameterProblem for Penalised<'_> {
    type Answer = Lambda;
    type Refusal = Unavailable;

    fn fixed(&self, parameter: f64) -> Result<Lambda, Unavailable> {
        Ok(Lambda { value: parameter, place: Place::Inside })
    }

    fn choose(&self, criterion: Criterion) -> Result<Lambda, Unavailable> {
        let oblique = self.oblique;
        match criterion {
            Criterion::Press | Criterion::BlockedCv => {
                let nodes = (self.nodewise)().ok_or(Unavailable::NoMinimiser)?;
                Ok(self.search.least_of_nodes(|removed| nodes.sum(removed)).into())
            }
            Criterion::MinMse if oblique.is_noiseless() => Err(Unavailable::NoSigma),
            Criterion::MinMse => {
                let at = |x: f64| oblique.mse(x.exp()).unwrap_or((f64::INFINITY, 0.0));
                let (x, place) = scan::least(self.logarithms, at);
                Ok(Lambda { value: x.exp(), place })
            }
            Criterion::MinCondition => {
                let slope = |x: f64| oblique.condition_with_slope(x.exp()).map_or(-1.0, |(_, slope)| slope);
                let x = scan::turning(self.logarithms, slope).ok_or(Unavailable::NoMinimiser)?;
                let place = if self.logarithms.contains(&x) { Place::Limit } else { Place::Inside };
                Ok(Lambda { value: x.exp(), place })
            }
            _ => Ok(self.search.choose(criterion)?.into()),
        }
    }
}

impl Comparison for Penalised<'_> {
    const PARAMETER: &'static str = "λ*";

    fn criteria(&self) -> impl Iterator<Item = Criterion> {
        // of many coefficients the search for the least condition is dearer than all else together
        let spec = self.context.spec;
        let few = self.oblique.delta.len() <= COMPARED_UP_TO || spec.include.lambda_curve;
        let asked = spec.regularization.criterion() == Some(Criterion::MinCondition);
        Criterion::ALL.into_iter().filter(move |c| few || asked || *c != Criterion::MinCondition)
    }

    fn place(answer: &Lambda) -> Place {
        answer.place
    }

    fn figures(&self, criterion: Option<Criterion>, answer: Option<Lambda>) -> Choice {
        let Penalised { context, oblique, .. } = self;
        let rss = context.least_squares.rss;
        match answer {
            None => Choice {
                criterion: ChosenBy::LeastSquares,
                lambda_star: None,
                condition: super::report::condition(context.spectrum.lambda.iter().copied()),
                bias_norm: 0.0,
                predicted_mse: oblique.mse(0.0).map(|(mse, _)| mse),
                rms: (rss / context.weight).sqrt(),
            },
            Some(Lambda { value, .. }) => Choice {
                criterion: criterion.into(),
                lambda_star: Some(value),
                condition: oblique.condition(value),
                bias_norm: oblique.bias(value),
                predicted_mse: oblique.mse(value).map(|(mse, _)| mse),
                rms: ((rss + oblique.risen(value)) / context.weight).sqrt(),
            },
        }
    }

    fn at_share(&self, share: f64) -> f64 {
        let [low, high] = self.logarithms;
        (low + (high - low) * share).exp()
    }

    fn curve_point(&self, lambda_star: f64) -> LambdaCurvePoint {
        let gcv = self.search.gcv(&self.problem.sums(Rule::Ridge, lambda_star));
        let figures = self.figures(None, Some(Lambda { value: lambda_star, place: Place::Inside }));
        LambdaCurvePoint {
            lambda_star,
            condition: figures.condition,
            bias_norm: figures.bias_norm,
            predicted_mse: figures.predicted_mse,
            rms: figures.rms,
            gcv: gcv.is_finite().then_some(gcv),
            coefficient_norm: self.oblique.norm(lambda_star),
        }
    }
}
