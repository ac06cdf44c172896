//! Forms of a request, and specs as they are stored.

use proptest::prelude::*;

use super::*;
use crate::api::fits::{canonical::input_sha256, spec::json::to_json};
use flankfit_engine::estimation::spec::{self, Criterion, Model, Parameter, Regularization};

mod drawn;

fn read(text: &str) -> Result<(Nodes, FitSpec), ReadError> {
    read_fit::<()>(text.as_bytes()).map(|(nodes, spec, _)| (nodes, spec))
}

const LINE: &str = r#""model":{"type":"polynomial","degree":1}"#;

fn with_spec(spec: &str) -> String {
    format!(r#"{{"nodes":{{"type":"curve","x":[0,1,2],"y":[0,1,4]}},{spec}}}"#)
}

#[test]
fn estimators_are_stored_with_every_default_and_read_back() {
    for (short, long) in [
        (r#"{"type":"least_squares"}"#, r#"{"type":"least_squares"}"#),
        (
            r#"{"type":"m_estimator","loss":"huber"}"#,
            r#"{"type":"m_estimator","loss":"huber","tuning":[1.345],"scale":{"rule":"mad_0_6745"},"tolerance":1e-13,"max_iterations":1000,"start":"least_squares"}"#,
        ),
        (
            r#"{"scale":{"rule":"proposal2"},"tuning":[2,4,9],"start":"least_trimmed_squares","type":"m_estimator","loss":"hampel"}"#,
            r#"{"type":"m_estimator","loss":"hampel","tuning":[2.0,4.0,9.0],"scale":{"rule":"proposal2","value":1.345},"tolerance":1e-13,"max_iterations":1000,"start":"least_trimmed_squares"}"#,
        ),
        (
            r#"{"type":"m_estimator","loss":"andrews","scale":{"rule":"fixed","value":2}}"#,
            r#"{"type":"m_estimator","loss":"andrews","tuning":[1.339],"scale":{"rule":"fixed","value":2.0},"tolerance":1e-13,"max_iterations":1000,"start":"least_squares"}"#,
        ),
        (r#"{"type":"least_absolute_deviations"}"#, r#"{"type":"least_absolute_deviations"}"#),
        (r#"{"type":"lp","p":1}"#, r#"{"type":"lp","p":1.0}"#),
        (r#"{"type":"quantile","tau":0.25}"#, r#"{"type":"quantile","tau":0.25}"#),
        (r#"{"type":"least_trimmed_squares"}"#, r#"{"type":"least_trimmed_squares","coverage":0.75,"seed":0}"#),
        (r#"{"type":"rank"}"#, r#"{"type":"rank","scores":"wilcoxon"}"#),
    ] {
        let (_, spec) = read(&with_spec(&format!(r#"{LINE},"estimator":{short}"#))).unwrap();
        let stored = to_json(&spec);
        assert!(stored.contains(&format!(r#""estimator":{long}"#)), "{stored}");
        assert_eq!(read_stored(&stored).unwrap(), spec);
        let (_, again) = read(&with_spec(&format!(r#"{LINE},"estimator":{long}"#))).unwrap();
        assert_eq!(again, spec);
    }
}

#[test]
fn the_digest_does_not_see_how_a_request_is_written() {
    let digest = |text: &str| read(text).map(|(nodes, spec)| input_sha256(&nodes, &spec)).unwrap();
    let plain = digest(&with_spec(LINE));
    let same = r#" { "regularization":{"lambda_star":{"criterion":"min_mse"},"type":"spectral","condition_limit":9e2},
        "estimator":{"type":"least_squares"}, "scaling":"unit_length", "include":[],
        "model":{"degree":1,"terms":"tensor","type":"polynomial","basis":"monomial"},
        "n\u006fdes":{"y":[-0,1.0,40e-1],"x":[0.0,1,2],"type":"curve"}}"#;
    assert_eq!(digest(same), plain);
    for other in [
        with_spec(r#""model":{"type":"polynomial","degree":[1,1]}"#),
        with_spec(&format!(r#"{LINE},"scaling":"none""#)),
        with_spec(&format!(r#"{LINE},"noise_sigma":1"#)),
        with_spec(&format!(r#"{LINE},"estimator":{{"type":"rank"}}"#)),
    ] {
        assert_ne!(digest(&other), plain, "{other}");
    }
}

proptest! {
    #[test]
    fn specs_survive_storing(
        model in 0..5_usize, scaling in 0..3_usize, regularization in 0..9_usize, value in 1e-9..1e9_f64,
        include in 0..16_usize,
    ) {
        let spec = FitSpec {
            scaling: [spec::Scaling::UnitLength, spec::Scaling::None, spec::Scaling::Standardized][scaling],
            regularization: [
                Regularization::None,
                Regularization::default(),
                Regularization::Ridge { parameter: Parameter::Fixed(value) },
                Regularization::Spectral {
                    scheme: spec::Scheme::Exact,
                    count: spec::Count::Given(3),
                    condition_limit: 1.0 + value,
                    lambda_star: Parameter::Criterion(Criterion::LCurve),
                },
                Regularization::Ridge { parameter: Parameter::Criterion(Criterion::Hkb1975) },
                Regularization::Tikhonov(spec::Tikhonov {
                    order: include % 4,
                    weights: (include > 7).then(|| vec![value, 0.0]),
                    parameter: Parameter::Criterion(Criterion::Gcv),
                }),
                match include % 4 {
                    3 => Regularization::TruncatedSvdBy { criterion: Criterion::OF_RANK[include / 4 % 3] },
                    _ => Regularization::TruncatedSvd { rank: include + 1 },
                },
                Regularization::JamesStein(spec::JamesStein {
                    factor: [
                        spec::ShrinkageFactor::JamesStein,
                        spec::ShrinkageFactor::HoerlKennard,
                        spec::ShrinkageFactor::EfronMorris,
                    ][include % 3],
                    positive_part: include > 7,
                    target: (include & 1 > 0).then(|| vec![0.0, -value]),
                }),
                Regularization::Attraction(spec::Attraction {
                    target: vec![value],
                    parameter: Parameter::Criterion(Criterion::Optimal),
                }),
            ][regularization].clone(),
            domain: (include > 7).then_some(spec::Domain { u: Some([-value, value]), v: None }),
            coefficient_norm_limit: (include > 3).then_some(value),
            noise_sigma: Some(value),
            node_uncertainty: Some(spec::NodeUncertainty { position: 0.0, height: value, kind: None }),
            include: spec::Include {
                residuals: include & 1 > 0,
                fitted: include & 2 > 0,
                collinearity: include & 2 > 0,
                lambda_curve: include & 4 > 0,
                matrix_b: include & 8 > 0,
                ridge_trace: include & 8 > 0,
                robust_weights: include & 2 > 0,
                peaks: include & 1 > 0,
                covariance: include & 4 > 0,
                influence: include & 2 > 0,
                shape: include & 8 > 0,
                representative: include & 4 > 0,
                predicted_mse: include & 8 > 0,
                enclosure: include & 1 > 0,
            },
            level: [0.95, 0.6][include & 1],
            predict: drawn::predict(include, value),
            select: drawn::select(include, value),
            folds: drawn::folds(include),
            ..FitSpec::new(
                [
                    Model::Linear,
                    Model::Polynomial {
                        degree: spec::Degree::Each(2, 3),
                        basis: spec::PolynomialBasis::Legendre,
                        terms: spec::Terms::Total,
                    },
                    Model::BSpline { degree: spec::Degree::Both(3), knots: spec::Knots::SpansEach(2, 5),
                        weights: None },
                    Model::BSpline { degree: spec::Degree::Both(1), knots: spec::Knots::Curve(vec![0.0, 0.1, value]),
                        weights: None },
                    Model::BSpline {
                        degree: spec::Degree::Both(1),
                        knots: spec::Knots::Surface(vec![0.0, value], vec![-value, 0.3]),
 weights: None,
},
                ][model]
                    .clone(),
            )
        };
        let text = to_json(&spec);
        prop_assert_eq!(&read_stored(&text).unwrap(), &spec, "{}", text);
        prop_assert!(!text.contains("null"));
    }
}
