//! The regularisation of a request: wire parts to checked domain types.

use crate::api::{
    faults::Faults,
    fits::spec::request::*,
    fits::spec::zeros::unsigned_zeros,
    json::{
        tags::{read_tag, unknown_type},
        value::read_value,
    },
};
use flankfit_engine::{estimation::spec, words::Shown};

/// The regularisations that there are.
const REGULARIZATIONS: &str = "none, spectral, ridge, tikhonov, truncated_svd, james_stein, attraction and \
                               representative are";

/// The regularisation, with the contract's defaults and ranges.
pub fn read_regularization(slice: &[u8], faults: &mut Faults) -> Option<spec::Regularization> {
    const AT: &str = "/regularization";
    match read_tag(slice, AT, REGULARIZATIONS, faults)?.as_str() {
        "none" => read_value::<NoRegularization>(slice, AT, faults).map(|_| spec::Regularization::None),
        "spectral" => {
            let body: SpectralRegularization = read_value(slice, AT, faults)?;
            let condition_limit = body.condition_limit.unwrap_or(spec::DEFAULT_CONDITION_LIMIT);
            if condition_limit <= 1.0 {
                faults
                    .push(format!("{AT}/condition_limit"), format!("{} is not greater than 1", Shown(condition_limit)));
            }
            let lambda_star = parameter(body.lambda_star, &format!("{AT}/lambda_star"), &[], faults)?;
            Some(spec::Regularization::Spectral {
                scheme: body.scheme.map_or_else(spec::Scheme::default, spec::Scheme::from),
                count: match body.count {
                    None | Some(CountBody::Auto(_)) => spec::Count::Auto,
                    Some(CountBody::Given(n)) => spec::Count::Given(n),
                },
                condition_limit,
                lambda_star,
            })
        }
        "ridge" => {
            let body: RidgeRegularization = read_value(slice, AT, faults)?;
            let parameter = parameter(body.parameter, &format!("{AT}/parameter"), &spec::Criterion::RIDGE, faults)?;
            Some(spec::Regularization::Ridge { parameter })
        }
        "tikhonov" => {
            let body: TikhonovRegularization = read_value(slice, AT, faults)?;
            if body.order > 3 {
                faults.push(format!("{AT}/order"), format!("{} is not one of 0 to 3", body.order));
            }
            let weights = body.weights.as_deref().unwrap_or(&[1.0]);
            for (i, weight) in weights.iter().enumerate().filter(|(_, weight)| **weight < 0.0) {
                faults.push(format!("{AT}/weights/{i}"), format!("{} is negative", Shown(*weight)));
            }
            if weights.len() > 2 || weights.iter().all(|weight| *weight == 0.0) {
                faults.push(format!("{AT}/weights"), "one weight for each axis, at least one greater than 0");
            }
            Some(spec::Regularization::Tikhonov(spec::Tikhonov {
                order: body.order,
                parameter: parameter(body.parameter, &format!("{AT}/parameter"), &[], faults)?,
                weights: body.weights.as_deref().map(unsigned_zeros),
            }))
        }
        "representative" => super::representative::read(slice, AT, faults),
        "truncated_svd" => truncated_svd(read_value(slice, AT, faults)?, faults),
        "james_stein" => james_stein(read_value(slice, AT, faults)?, faults),
        "attraction" => {
            let mut body: AttractionRegularization = read_value(slice, AT, faults)?;
            body.parameter.get_or_insert(ParameterBody { criterion: CriterionName::Optimal, value: None });
            let own = [spec::Criterion::Optimal];
            Some(spec::Regularization::Attraction(spec::Attraction {
                parameter: parameter(body.parameter, &format!("{AT}/parameter"), &own, faults)?,
                target: unsigned_zeros(&body.target),
            }))
        }
        other => {
            unknown_type(AT, other, REGULARIZATIONS, faults);
            None
        }
    }
}

fn truncated_svd(body: TruncatedSvdRegularization, faults: &mut Faults) -> Option<spec::Regularization> {
    match (body.rank, body.parameter) {
        (Some(0), _) => {
            faults.push("/regularization/rank", "at least one direction must be kept");
            None
        }
        (Some(rank), None) => Some(spec::Regularization::TruncatedSvd { rank }),
        (None, Some(RankParameterBody { criterion })) => Some(spec::Regularization::TruncatedSvdBy {
            criterion: match criterion {
                RankCriterionName::Gcv => spec::Criterion::Gcv,
                RankCriterionName::Reml => spec::Criterion::Reml,
                RankCriterionName::Discrepancy => spec::Criterion::Discrepancy,
            },
        }),
        (Some(_), Some(_)) => {
            faults.push("/regularization/parameter", "give either `rank` or `parameter`, not both");
            None
        }
        (None, None) => {
            faults.push("/regularization/rank", "missing; give it, or `parameter` with a criterion that chooses it");
            None
        }
    }
}

fn james_stein(body: JamesSteinRegularization, faults: &mut Faults) -> Option<spec::Regularization> {
    let (factor, positive_part) = match (body.variant, body.positive_part) {
        (None, positive) => (spec::ShrinkageFactor::JamesStein, positive.unwrap_or(true)),
        (Some(JamesSteinVariant::HoerlKennard), positive) => {
            (spec::ShrinkageFactor::HoerlKennard, positive.unwrap_or(false))
        }
        (Some(JamesSteinVariant::EfronMorris), positive) => {
            (spec::ShrinkageFactor::EfronMorris, positive.unwrap_or(false))
        }
        (Some(JamesSteinVariant::PositivePart), None | Some(true)) => (spec::ShrinkageFactor::JamesStein, true),
        (Some(JamesSteinVariant::PositivePart), Some(false)) => {
            faults.push(
                "/regularization/positive_part",
                "false contradicts the variant `positive_part`; leave one of them out",
            );
            return None;
        }
    };
    let target = body.target.as_deref().map(unsigned_zeros);
    Some(spec::Regularization::JamesStein(spec::JamesStein { factor, positive_part, target }))
}

/// The parameter; beside the criteria for all, those of `own` are taken.
pub fn parameter(
    body: Option<ParameterBody>,
    pointer: &str,
    own: &[spec::Criterion],
    faults: &mut Faults,
) -> Option<spec::Parameter> {
    let Some(body) = body else { return Some(spec::Parameter::Criterion(spec::Criterion::MinMse)) };
    let Some(criterion) = body.criterion.criterion() else {
        let Some(value) = body.value else {
            faults.push_missing(format!("{pointer}/value"), "missing; the criterion `fixed` needs it");
            return None;
        };
        if value <= 0.0 {
            faults.push(format!("{pointer}/value"), format!("{} is not greater than 0", Shown(value)));
        }
        return Some(spec::Parameter::Fixed(value));
    };
    let for_all = spec::Criterion::ALL.contains(&criterion) || spec::Criterion::MORE.contains(&criterion);
    if !for_all && !own.contains(&criterion) {
        faults.push(
            format!("{pointer}/criterion"),
            format!(
                "`{}` is for another regularisation (hkb, hkb_1975, lawless_wang: ridge; optimal: attraction)",
                criterion.name()
            ),
        );
    }
    if body.value.is_some() {
        faults.push(format!("{pointer}/value"), "only the criterion `fixed` takes a value");
    }
    Some(spec::Parameter::Criterion(criterion))
}
