//! One selector of a parameter of regularisation: from the request to the parameter that is used,
//! with the choices of all criteria.
//!
//! A kind of regularisation defines how its criteria are evaluated and the effect of a parameter.
//! The order of the criteria, refusals, warnings and the curve are the same for all of them.

use super::search::{Place, Unavailable};
use crate::{
    error::FitError,
    result::{Choice, LambdaCurvePoint, Warning},
    spec::{ChosenBy, Criterion, Parameter},
};
use flankfit_numerics::check::Faults;

/// Points of a curve, less one.
const POINTS: usize = 60;

/// A problem with one parameter that a caller fixes or a criterion chooses.
pub(crate) trait ParameterProblem {
    /// A parameter, with what is known of how it was found.
    type Answer: Copy;
    /// Reason why there is no choice.
    type Refusal;

    /// The parameter of a caller.
    fn fixed(&self, parameter: f64) -> Result<Self::Answer, Self::Refusal>;
    /// Choice of `criterion`.
    fn choose(&self, criterion: Criterion) -> Result<Self::Answer, Self::Refusal>;

    /// Returns the requested parameter.
    fn answer(&self, parameter: Parameter) -> Result<Self::Answer, Self::Refusal> {
        match parameter {
            Parameter::Fixed(value) => self.fixed(value),
            Parameter::Criterion(criterion) => self.choose(criterion),
        }
    }
}

/// A problem cheap enough for evaluating every criterion in addition to the requested one.
pub(crate) trait Comparison: ParameterProblem<Refusal = Unavailable> {
    /// Name of the parameter in messages.
    const PARAMETER: &'static str;

    /// The criteria whose choices are reported, in this order.
    fn criteria(&self) -> impl Iterator<Item = Criterion>;
    /// Returns the position of an answer in the search range.
    fn place(answer: &Self::Answer) -> Place;
    /// The figures of an answer; of `None` those of least squares.
    fn figures(&self, criterion: Option<Criterion>, answer: Option<Self::Answer>) -> Choice;
    /// The parameter at a share (0 to 1) of the range of the search.
    fn at_share(&self, share: f64) -> f64;
    /// The curve at a parameter.
    fn curve_point(&self, parameter: f64) -> LambdaCurvePoint;
}

/// The parameter that is used, and what else could have been.
pub(crate) struct Selection<A> {
    /// `None` if the criterion has no parameter: least squares is used.
    pub answer: Option<A>,
    pub criterion: Option<Criterion>,
    pub fixed: bool,
    /// Least squares first.
    pub choices: Vec<Choice>,
    pub curve: Option<Vec<LambdaCurvePoint>>,
}

impl<A> Selection<A> {
    /// Returns the origin of the parameter; `None` without regularisation.
    pub(crate) fn chosen_by(&self) -> Option<ChosenBy> {
        if self.fixed { Some(ChosenBy::Fixed) } else { self.criterion.map(ChosenBy::Criterion) }
    }
}

/// Selects the parameter for `problem`.
pub(crate) fn select<P: Comparison>(
    problem: &P,
    parameter: Parameter,
    want_curve: bool,
    warnings: &mut Vec<Warning>,
) -> Result<Selection<P::Answer>, FitError> {
    let mut choices = vec![problem.figures(None, None)];
    let mut asked = None;
    for criterion in problem.criteria() {
        let answer = problem.choose(criterion);
        if let Ok(answer) = answer {
            choices.push(problem.figures(Some(criterion), Some(answer)));
        }
        if parameter == Parameter::Criterion(criterion) {
            asked = Some(answer);
        }
    }
    let (criterion, fixed) = match parameter {
        Parameter::Criterion(criterion) => (Some(criterion), false),
        Parameter::Fixed(_) => (None, true),
    };
    let asked = asked.unwrap_or_else(|| {
        let answer = problem.answer(parameter);
        if let (Ok(answer), Some(criterion)) = (answer, criterion) {
            choices.push(problem.figures(Some(criterion), Some(answer)));
        }
        answer
    });
    let answer = match (asked, criterion) {
        (Ok(answer), _) => Some(answer),
        (Err(Unavailable::NoSigma), Some(criterion)) => {
            warnings.push(Warning::SigmaMissing { criterion: criterion.name() });
            None
        }
        (Err(_), Some(criterion)) => return Err(no_minimiser(criterion).into()),
        (Err(_), None) => None,
    };
    match answer.as_ref().map(P::place) {
        Some(Place::Missed) => warnings.push(Warning::DiscrepancyNotReached { parameter: P::PARAMETER }),
        Some(Place::Limit) => warnings.push(Warning::LambdaAtLimit { parameter: P::PARAMETER }),
        Some(Place::Inside) | None => {}
    }
    let curve = want_curve
        .then(|| (0..=POINTS).map(|i| problem.curve_point(problem.at_share(i as f64 / POINTS as f64))).collect());
    Ok(Selection { answer, criterion, fixed, choices, curve })
}

/// Error for a criterion that a regularisation does not have.
pub(crate) fn no_minimiser(wanted: Criterion) -> Faults {
    let message = match wanted {
        Criterion::MinCondition => {
            "no parameter minimises the condition number: it decreases without end, or is constant".to_owned()
        }
        Criterion::Hkb | Criterion::Hkb1975 | Criterion::LawlessWang => format!(
            "`{}` is for ridge, and needs coefficients that are not all 0 (`hkb_1975` one, the others three)",
            wanted.name()
        ),
        _ => format!("`{}` is not for this regularisation", wanted.name()),
    };
    Faults::one("regularization.parameter.criterion", message)
}

/// Adds the warnings about the choice.
pub(crate) fn warn_about(choices: &[Choice], chosen: &Choice, warnings: &mut Vec<Warning>) {
    let [least_squares, ..] = choices else { return };
    if let (Some(here), Some(there)) = (chosen.predicted_mse, least_squares.predicted_mse)
        && here > there * (1.0 + 1e-9)
    {
        let factor = here / there;
        warnings.push(Warning::WorseThanLeastSquares { factor });
    }
}
