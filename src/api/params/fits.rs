//! Of fits and shapes.

use super::Params;
use flankfit_engine::estimation::result::{NeedsSigma, Regularized, ShapeBound, Warning};

impl From<&Warning> for Params {
    fn from(warning: &Warning) -> Self {
        let none = Params::new();
        match warning {
            Warning::RankDeficient { terms, rank, columns } => {
                none.list("terms", terms.clone()).with("rank", *rank).with("columns", *columns)
            }
            Warning::NoSpectralSchemes { rank, columns } => none.with("rank", *rank).with("columns", *columns),
            Warning::InfiniteInflation(terms) => none.list("terms", terms.clone()),
            Warning::BeyondDouble(figures) => none.list("figures", figures.iter().copied()),
            Warning::FewDigits(digits) => none.with("digits", *digits),
            Warning::NormLimitBelowEstimate { limit, norm } => none.with("limit", *limit).with("norm", *norm),
            Warning::NormLimitIsEstimate { norm, along, error } => {
                none.with("norm", *norm).with("along_worst", *along).with("std_error", *error)
            }
            Warning::NoLambdaOf(regularized) => none.with("regularization", regularization(*regularized)),
            Warning::DiscrepancyNotReached(parameter) | Warning::LambdaAtLimit(parameter) => {
                none.with("parameter", *parameter)
            }
            Warning::SigmaMissing(what) => none.with("criterion", criterion(*what)),
            Warning::WorseThanLeastSquares(factor) => none.with("factor", *factor),
            Warning::WeightsNotConverged { iterations, reached } => {
                none.with("iterations", *iterations).with("change_scales", *reached)
            }
            Warning::NewtonNotConverged { iterations, reached } => {
                none.with("iterations", *iterations).with("relative_change", *reached)
            }
            Warning::SimplexStopped(steps) => none.with("steps", *steps),
            Warning::ExactFit { on, nodes } => none.with("on_surface", *on).with("nodes", *nodes),
            Warning::FilterNotConverged { filter, rounds, lines } => {
                none.with("filter", *filter).with("rounds", *rounds).with("lines", *lines)
            }
            Warning::FilteringRaisesCollinearity { before, after } => {
                none.with("condition_before", *before).with("condition_after", *after)
            }
            Warning::Forgetting { factor, nodes, weight } => {
                none.with("forgetting_factor", *factor).with("nodes", *nodes).with("weight", *weight)
            }
            Warning::EmptySpans { empty, cells } => none.with("empty", *empty).with("cells", *cells),
            Warning::NoStandardErrors(coefficients) => none.with("coefficients", *coefficients),
            Warning::DependentLevels(levels) => none.list("levels", levels.clone()),
            Warning::PositionsUncertain { share, bend, weights } => {
                none.with("share", *share).with("bend_std_errors", *bend).with("weight_std_error", *weights)
            }
            Warning::UncertaintyContradicted(found) => {
                none.with("sigma_ratio", found.ratio).with("degrees_of_freedom", found.freedom)
            }
            Warning::GroupVarianceUncertain { group, freedom } => {
                none.with("group", *group).with("degrees_of_freedom", *freedom)
            }
            Warning::PowerUncertain { freedom, more } => {
                none.with("degrees_of_freedom", *freedom).with("more_nodes", *more)
            }
            Warning::CorrelationAtBound(correlation) => none.with("correlation", *correlation),
            Warning::InfluenceOfMany { nodes, most } => none.with("nodes", *nodes).with("most", *most),
            Warning::PlacesBeyondDouble { places, count } => {
                none.list("places", places.iter().copied()).with("count", *count)
            }
            Warning::FullLeverage { nodes, count } => none.list("nodes", nodes.iter().copied()).with("count", *count),
            Warning::NoNoiseWithout(found) => {
                none.list("nodes", found.nodes.iter().copied()).with("count", found.count)
            }
            Warning::ShapeAtBound(ShapeBound::Freedom(freedom)) => none.with("degrees_of_freedom", *freedom),
            Warning::ShapeAtBound(ShapeBound::Exponent(exponent)) => none.with("exponent", *exponent),
            Warning::NoShapeOfDegree { degree, most } => none.with("degree", *degree).with("most", *most),
            Warning::OutsideDomain(count) | Warning::ConstraintsActive(count) | Warning::PostSelection(count) => {
                none.with("count", *count)
            }
            Warning::CorrelatedResiduals { along, correlation, p, factor } => {
                none.with("along", along.name()).with("correlation", *correlation).with("p", *p).with("factor", *factor)
            }
            Warning::OutliersSuspected(found) => found.into(),
            Warning::PriorConflict(conflict) => none.with("statistic", conflict.statistic).with("p", conflict.p),
            Warning::UnequalNoise(noise) => {
                none.with("now", noise.now).with("earlier", noise.earlier).with("p", noise.p)
            }
            Warning::PieceMisaligned(alignment) => none.with("alignment", *alignment),
            // they hold nothing
            _ => none,
        }
    }
}

/// The names of the contract.
fn regularization(of: Regularized) -> &'static str {
    match of {
        Regularized::TruncatedSvd => "truncated_svd",
        Regularized::JamesStein => "james_stein",
        Regularized::Attraction => "attraction",
        Regularized::Tikhonov => "tikhonov",
        Regularized::Posterior => "posterior",
        Regularized::Constrained => "constrained",
        Regularized::Representative => "representative",
    }
}

fn criterion(of: NeedsSigma) -> &'static str {
    match of {
        NeedsSigma::Criterion(criterion) => criterion.name(),
        NeedsSigma::JamesStein => "james_stein",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flankfit_engine::estimation::{
        result::{Contradiction, ExactWithout, PriorConflict},
        spec::Along,
    };

    /// Every number and every word that the engine's own sentence tells stands in the parameters,
    /// to the digits of the sentence.
    #[test]
    fn sentences_speak_of_nothing_else() {
        let all = [
            Warning::RankDeficient { terms: vec!["u".into(), "v^2".into()], rank: 5, columns: 6 },
            Warning::NormLimitBelowEstimate { limit: 2.5, norm: 3.25 },
            Warning::WeightsNotConverged { iterations: 50, reached: 0.5 },
            Warning::FilteringRaisesCollinearity { before: 12.0, after: 480.0 },
            Warning::Forgetting { factor: 0.5, nodes: 7, weight: 1.75 },
            Warning::UncertaintyContradicted(Contradiction { ratio: 0.125, freedom: 26 }),
            Warning::PowerUncertain { freedom: 4, more: 6 },
            Warning::FullLeverage { nodes: vec![3, 8], count: 2 },
            Warning::NoNoiseWithout(ExactWithout { nodes: vec![4], count: 1, all: false }),
            Warning::CorrelatedResiduals { along: Along::V, correlation: 0.25, p: 0.001, factor: 1.5 },
            Warning::PriorConflict(PriorConflict { statistic: 9.5, p: 0.001, let_go: true }),
        ];
        for warning in all {
            let Params(found) = Params::from(&warning);
            let mut told: Vec<f64> = Vec::new();
            let flat = found.values().flat_map(|value| match value {
                serde_json::Value::Array(list) => list.clone(),
                one => vec![one.clone()],
            });
            told.extend(flat.filter_map(|value| value.as_f64()));
            let sentence = warning.to_string();
            let numbers = sentence.split(|c: char| !(c.is_ascii_digit() || ".e-".contains(c)));
            for number in numbers.filter_map(|text| text.trim_matches(|c| ".-e".contains(c)).parse::<f64>().ok()) {
                // `v^2` and `S⁻¹` are names
                let near = |x: &f64| (x - number).abs() <= 0.01 * number.abs();
                assert!(told.iter().any(near) || [1.0, 2.0].contains(&number), "{number} of {sentence}: {found:?}");
            }
        }
        assert_eq!(Params::from(&Warning::NoDegreesOfFreedom).some(), None);
    }
}
