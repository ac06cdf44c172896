//! Filters on the eigenvectors: the requested rule and its parameter.

use super::{
    classical::ridge_parameter,
    filter::Rule,
    nodewise::LeftOut,
    search::{Chosen, Place, Search, Unavailable, range},
    selector::{Comparison, ParameterProblem, Selection, select},
    spectral::Spectral,
};
use crate::{
    error::FitError,
    result::{Choice, LambdaCurvePoint, RegularizationKind, Warning},
    spec::{ChosenBy, Criterion, Parameter, Regularization, Scheme},
};

/// The rule that is applied, and its parameter.
pub(crate) struct SelectedFilter {
    pub kind: RegularizationKind,
    pub rule: Rule,
    /// λ* or k; no answer where nothing is regularised.
    pub selection: Selection<Chosen>,
}

impl SelectedFilter {
    /// The parameter to evaluate the rule at.
    pub(crate) fn parameter(&self) -> f64 {
        self.selection.answer.map_or(0.0, |chosen| chosen.lambda_star)
    }
}

/// Input of a choice.
pub(crate) struct FilterRequest<'a> {
    pub regularization: &'a Regularization,
    /// Σw, for the root mean squares.
    pub weight: f64,
    /// True if the curve along λ* is wanted.
    pub curve: bool,
}

/// Choice of `criterion` for a rule, without the other criteria; `None` if it has none.
pub(crate) fn choose(problem: &Spectral, rule: Rule, a: &[f64], parameter: Parameter) -> Option<f64> {
    let nodewise = || None;
    let filters = Filters { problem, rule, a, weight: 1.0, nodewise: &nodewise, search: Search::new(problem, rule) };
    filters.answer(parameter).ok().map(|chosen| chosen.lambda_star)
}

/// Decides for `problem` with coefficients `a` along its directions; `nodewise` finds the nodes in
/// their coordinates.
pub(crate) fn decide(
    asked: &FilterRequest,
    problem: &Spectral,
    a: &[f64],
    nodewise: &dyn Fn() -> Option<LeftOut>,
    warnings: &mut Vec<Warning>,
) -> Result<SelectedFilter, FitError> {
    let FilterRequest { regularization, weight, curve: want_curve } = *asked;
    let (kind, rule) = Rule::requested(regularization, problem.lambda)?;
    let Some(parameter) = regularization.parameter() else {
        if want_curve {
            warnings.push(Warning::NoLambda);
        }
        let choices = vec![figures(problem, Rule::None, weight, None, None)];
        let selection = Selection { answer: None, criterion: None, fixed: false, choices, curve: None };
        return Ok(SelectedFilter { kind, rule: Rule::None, selection });
    };
    if let Rule::Spectral { count: 0, .. } = rule {
        // nothing to regularise: every criterion chooses least squares
        let least_squares = figures(problem, rule, weight, None, None);
        let same = Criterion::ALL
            .map(|criterion| Choice { criterion: ChosenBy::Criterion(criterion), ..least_squares.clone() });
        let mut choices: Vec<Choice> = std::iter::once(least_squares.clone()).chain(same).collect();
        let (criterion, fixed) = match parameter {
            Parameter::Criterion(criterion) => (Some(criterion), false),
            Parameter::Fixed(_) => (None, true),
        };
        if criterion.is_some_and(|asked| !Criterion::ALL.contains(&asked)) {
            choices.push(Choice { criterion: criterion.into(), ..least_squares });
        }
        let selection = Selection { answer: None, criterion, fixed, choices, curve: want_curve.then(Vec::new) };
        return Ok(SelectedFilter { kind, rule, selection });
    }
    let filters = Filters { problem, rule, a, weight, nodewise, search: Search::new(problem, rule) };
    Ok(SelectedFilter { kind, rule, selection: select(&filters, parameter, want_curve, warnings)? })
}

/// Filters on the eigenvectors by one rule.
struct Filters<'a> {
    problem: &'a Spectral<'a>,
    rule: Rule,
    /// Coefficients along the directions.
    a: &'a [f64],
    /// Σw.
    weight: f64,
    /// The nodes along the directions, where they are there.
    nodewise: &'a dyn Fn() -> Option<LeftOut>,
    search: Search<'a>,
}

impl ParameterProblem for Filters<'_> {
    type Answer = Chosen;
    type Refusal = Unavailable;

    fn fixed(&self, parameter: f64) -> Result<Chosen, Unavailable> {
        Ok(Chosen { lambda_star: parameter, interval: None, place: Place::Inside })
    }

    fn choose(&self, criterion: Criterion) -> Result<Chosen, Unavailable> {
        match criterion {
            Criterion::Hkb | Criterion::Hkb1975 | Criterion::LawlessWang if self.rule == Rule::Ridge => {
                ridge_parameter(criterion, self.problem, self.a)
            }
            Criterion::Press | Criterion::BlockedCv => {
                let nodes = (self.nodewise)().ok_or(Unavailable::NoMinimiser)?;
                Ok(self.search.least_of_nodes(|removed| nodes.sum(removed)))
            }
            _ => self.search.choose(criterion),
        }
    }
}

impl Comparison for Filters<'_> {
    const PARAMETER: &'static str = "λ*";

    fn criteria(&self) -> impl Iterator<Item = Criterion> {
        let closed = if self.rule == Rule::Ridge { &Criterion::RIDGE[..] } else { &[] };
        Criterion::ALL.into_iter().chain(closed.iter().copied())
    }

    fn place(answer: &Chosen) -> Place {
        answer.place
    }

    fn figures(&self, criterion: Option<Criterion>, answer: Option<Chosen>) -> Choice {
        figures(self.problem, self.rule, self.weight, criterion, answer.map(|chosen| chosen.lambda_star))
    }

    fn at_share(&self, share: f64) -> f64 {
        let [low, high] = range(self.problem, self.rule);
        low * (high / low).powf(share)
    }

    fn curve_point(&self, lambda_star: f64) -> LambdaCurvePoint {
        let Filters { problem, rule, weight, search, .. } = self;
        let sums = problem.sums(*rule, lambda_star);
        let gcv = search.gcv(&sums);
        LambdaCurvePoint {
            lambda_star,
            condition: problem.condition(*rule, lambda_star),
            bias_norm: sums.bias.sqrt(),
            predicted_mse: problem.variance.map(|_| sums.mse[0]),
            rms: (sums.rss[0].max(0.0) / weight).sqrt(),
            gcv: gcv.is_finite().then_some(gcv),
            coefficient_norm: sums.norm[0].sqrt(),
        }
    }
}

/// The figures at λ*, or of least squares.
fn figures(
    problem: &Spectral,
    rule: Rule,
    weight: f64,
    criterion: Option<Criterion>,
    lambda_star: Option<f64>,
) -> Choice {
    let rule = if lambda_star.is_some() { rule } else { Rule::None };
    let at = lambda_star.unwrap_or(0.0);
    let sums = problem.sums(rule, at);
    Choice {
        criterion: criterion.into(),
        lambda_star,
        condition: problem.condition(rule, at),
        bias_norm: sums.bias.sqrt(),
        predicted_mse: problem.variance.map(|_| sums.mse[0]),
        rms: (sums.rss[0].max(0.0) / weight).sqrt(),
    }
}

/// The scheme and L, where there are any.
pub(crate) fn scheme_and_count(rule: Rule) -> (Option<Scheme>, Option<usize>) {
    match rule {
        Rule::Spectral { scheme, count } => (Some(scheme), Some(count)),
        _ => (None, None),
    }
}
