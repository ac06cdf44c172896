//! A regularisation as JSON with every default filled in.

use super::{request::*, zeros::unsigned_zeros};
use flankfit_engine::estimation::spec;

/// The regularisation with every default filled in.
pub fn regularization(regularization: &spec::Regularization) -> RegularizationBody {
    match regularization {
        spec::Regularization::None => RegularizationBody::None(NoRegularization { kind: NoneTag::None }),
        spec::Regularization::Spectral { scheme, count, condition_limit, lambda_star } => {
            RegularizationBody::Spectral(SpectralRegularization {
                kind: SpectralTag::Spectral,
                scheme: Some((*scheme).into()),
                count: Some(match count {
                    spec::Count::Auto => CountBody::Auto(super::count::AutoName::Auto),
                    spec::Count::Given(n) => CountBody::Given(*n),
                }),
                condition_limit: Some(*condition_limit),
                lambda_star: Some(parameter(*lambda_star)),
            })
        }
        spec::Regularization::Ridge { parameter: k } => {
            RegularizationBody::Ridge(RidgeRegularization { kind: RidgeTag::Ridge, parameter: Some(parameter(*k)) })
        }
        spec::Regularization::Tikhonov(spec::Tikhonov { order, weights, parameter: lambda }) => {
            RegularizationBody::Tikhonov(TikhonovRegularization {
                kind: TikhonovTag::Tikhonov,
                order: *order,
                weights: weights.as_deref().map(unsigned_zeros),
                parameter: Some(parameter(*lambda)),
            })
        }
        spec::Regularization::TruncatedSvd { rank } => RegularizationBody::TruncatedSvd(TruncatedSvdRegularization {
            kind: TruncatedSvdTag::TruncatedSvd,
            rank: Some(*rank),
            parameter: None,
        }),
        spec::Regularization::TruncatedSvdBy { criterion } => {
            RegularizationBody::TruncatedSvd(TruncatedSvdRegularization {
                kind: TruncatedSvdTag::TruncatedSvd,
                rank: None,
                parameter: Some(RankParameterBody {
                    // the reader takes no others
                    criterion: match criterion {
                        spec::Criterion::Reml => RankCriterionName::Reml,
                        spec::Criterion::Discrepancy => RankCriterionName::Discrepancy,
                        _ => RankCriterionName::Gcv,
                    },
                }),
            })
        }
        spec::Regularization::JamesStein(spec::JamesStein { factor, positive_part, target }) => {
            RegularizationBody::JamesStein(JamesSteinRegularization {
                kind: JamesSteinTag::JamesStein,
                variant: match (factor, positive_part) {
                    (spec::ShrinkageFactor::HoerlKennard, _) => Some(JamesSteinVariant::HoerlKennard),
                    (spec::ShrinkageFactor::EfronMorris, _) => Some(JamesSteinVariant::EfronMorris),
                    (spec::ShrinkageFactor::JamesStein, true) => Some(JamesSteinVariant::PositivePart),
                    (spec::ShrinkageFactor::JamesStein, false) => None,
                },
                positive_part: Some(*positive_part),
                target: target.as_deref().map(unsigned_zeros),
            })
        }
        spec::Regularization::Representative(asked) => RegularizationBody::Representative(Box::new(asked.into())),
        spec::Regularization::Attraction(spec::Attraction { target, parameter: k }) => {
            RegularizationBody::Attraction(AttractionRegularization {
                kind: AttractionTag::Attraction,
                target: unsigned_zeros(target),
                parameter: Some(parameter(*k)),
            })
        }
    }
}

fn parameter(parameter: spec::Parameter) -> ParameterBody {
    match parameter {
        spec::Parameter::Criterion(criterion) => ParameterBody { criterion: criterion.into(), value: None },
        spec::Parameter::Fixed(value) => ParameterBody { criterion: CriterionName::Fixed, value: Some(value) },
    }
}
