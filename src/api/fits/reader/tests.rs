//! Forms of a request, and the places of its errors.

use proptest::prelude::*;

use super::*;
use crate::api::{
    fits::{canonical::input_sha256, spec::json::to_json},
    json::request::request,
};
use flankfit_engine::estimation::spec::{self, Criterion, Model, Parameter, Regularization};

mod drawn;
mod faults;

fn read(text: &str) -> Result<(Nodes, FitSpec), ReadError> {
    read_fit::<()>(text.as_bytes()).map(|(nodes, spec, _)| (nodes, spec))
}

/// Returns the errors of a well-formed request.
fn faults(text: &str) -> Vec<(String, String)> {
    match read(text) {
        Err(ReadError::Invalid(faults)) => {
            faults.list().iter().map(|fault| (fault.pointer.clone(), fault.detail.clone())).collect()
        }
        other => panic!("{text}: {other:?}"),
    }
}

fn pointers(text: &str) -> Vec<String> {
    faults(text).into_iter().map(|(pointer, _)| pointer).collect()
}

const LINE: &str = r#""model":{"type":"polynomial","degree":1}"#;

fn with_nodes(nodes: &str) -> String {
    format!(r#"{{"nodes":{nodes},{LINE}}}"#)
}

fn with_spec(spec: &str) -> String {
    format!(r#"{{"nodes":{{"type":"curve","x":[0,1,2],"y":[0,1,4]}},{spec}}}"#)
}

#[test]
fn the_defaults_are_those_of_the_contract() {
    let (_, read) = read(&with_spec(LINE)).unwrap();
    let expected = FitSpec::new(Model::Polynomial {
        degree: spec::Degree::Both(1),
        basis: spec::PolynomialBasis::Monomial,
        terms: spec::Terms::Tensor,
    });
    assert_eq!(read, expected);
    assert_eq!(
        read.regularization,
        Regularization::Spectral {
            scheme: spec::Scheme::FirstOrder,
            count: spec::Count::Auto,
            condition_limit: 900.0,
            lambda_star: Parameter::Criterion(Criterion::MinMse)
        }
    );
}

#[test]
fn keys_come_in_any_order_with_any_space_and_any_escapes() {
    let text = "\r\n\t{ \"mod\\u0065l\" : {\"degree\" : [1 , 0],\n\"type\":\"polynomial\"} , \"nodes\" :\n\
                { \"z\" : [ [ 1 , null ] , [ 2.5e0, -4E-1 ] ] ,\"\\u0076\":[0,1],\"u\" : [ 0.0 , 1 ],\"type\":\"grid\" \
                } }\n ";
    let (nodes, spec) = read(text).unwrap();
    let Nodes::Grid(grid) = nodes else { panic!() };
    assert_eq!((grid.u(), grid.v(), grid.valid(), grid.weight()), (&[0.0, 1.0][..], &[0.0, 1.0][..], None, None));
    assert_eq!(grid.z().iter().map(|z| z.to_bits()).collect::<Vec<_>>(), [1.0, f64::NAN, 2.5, -0.4].map(f64::to_bits));
    assert!(matches!(spec.model, Model::Polynomial { degree: spec::Degree::Each(1, 0), .. }));
}

#[test]
fn all_types_of_nodes_are_read() {
    for nodes in [
        r#"{"type":"curve","x":[1],"y":[2],"weight":[0]}"#,
        r#"{"type":"scattered","u":[1],"v":[2],"z":[3],"weight":[1]}"#,
        r#"{"type":"grid","u":[1],"v":[2],"z":[[3]],"valid":[[true]],"weight":[[2]]}"#,
        r#"{"type":"matrix","x":[[1,2],[3,4]],"y":[5,6],"names":["a","b"],"weight":[1,1]}"#,
    ] {
        assert!(read(&with_nodes(nodes)).is_ok(), "{nodes}");
    }
}

#[test]
fn malformed_json_is_refused_with_its_position() {
    for (text, place, word) in [
        ("", "Line 1, column 1", "ends"),
        ("{\n \"nodes\": nope}", "Line 2, column 11", "a value"),
        ("{\"nodes\":{\"type\":\"grid\",\"z\":[[1,NaN]]}}", "column 33", "missing"),
        ("{\"nodes\":{\"type\":\"grid\",\"z\":[[1,-Infinity]]}}", "column 33", "missing"),
        ("{\"model\":{\"a\":nan}}", "column 15", "missing"),
        ("{\"nodes\":{\"x\":[01]}}", "column 16", "superfluous"),
        ("{\"nodes\":{\"x\":[1.]}}", "column 18", "decimal"),
        ("{\"nodes\":{\"x\":[.5]}}", "column 16", "value"),
        ("{\"nodes\":{\"x\":[+1]}}", "column 16", "value"),
        ("{\"nodes\":{\"x\":[0x1]}}", "column 17", "`,` or `]`"),
        ("{\"nodes\":{\"x\":[1,]}}", "column 18", "value"),
        ("{\"nodes\":{\"x\":[1 2]}}", "column 18", "`,` or `]`"),
        ("{\"nodes\":{\"x\":[1", "column 17", "ends"),
        ("{} {}", "column 4", "follows"),
    ] {
        match read(text) {
            Err(ReadError::Malformed { detail }) => {
                assert!(detail.contains(place) && detail.contains(word), "{text}: {detail}");
            }
            other => panic!("{text}: {other:?}"),
        }
    }
    let deep = format!("{{\"model\":{}1{}}}", "[".repeat(50), "]".repeat(50));
    assert!(matches!(read(&deep), Err(ReadError::Malformed { .. })));
    assert!(matches!(read_fit::<()>(b"{\"\xff\":1}"), Err(ReadError::Malformed { .. })));
}

request! {
    /// Further details.
    pub struct Note as NoteMembers, read whole {
        optional note: String,
        optional operator: String,
    }
}

#[test]
fn other_requests_may_have_more_fields_or_no_nodes() {
    let text = with_spec(&format!(r#"{LINE},"note":"warm \u00b5""#));
    let (_, _, extra) = read_fit::<Note>(text.as_bytes()).unwrap();
    assert_eq!(extra.note.as_deref(), Some("warm µ"));
    let text = format!(r#"{{{LINE},"note":3,"nodes":{{}}}}"#);
    let Err(ReadError::Invalid(faults)) = read_refit::<Note>(text.as_bytes()) else { panic!() };
    let pointers: Vec<_> = faults.list().iter().map(|fault| fault.pointer.as_str()).collect();
    assert_eq!(pointers, ["/nodes", "/note"]);
}

#[test]
fn tables_are_read_and_their_errors_have_line_and_column() {
    let spec = format!("{{{LINE}}}");
    let read =
        |table: &str| read_fit_with_table::<()>(spec.as_bytes(), table.as_bytes(), None).map(|(nodes, _, _)| nodes);
    let faults = |table: &str| match read(table) {
        Err(ReadError::Invalid(faults)) => faults.list().to_vec(),
        other => panic!("{table}: {other:?}"),
    };
    let expected = Nodes::scattered(vec![0.0, 2.0], vec![1.0, 1.0], vec![-5e-3, 7.0], None).unwrap();
    assert_eq!(read("u,v,z\n0,1,-5e-3\r\n1,1,\n 2 , 1 ,7\n").unwrap(), expected);
    let expected = Nodes::curve(vec![1.0], vec![2.0], Some(vec![0.5])).unwrap();
    assert_eq!(read("\u{feff}x,y,weight\n1,2,0.5").unwrap(), expected);
    let found = faults("u,v,z,weight\n1,2,3,4\nx,2,n/a,\n1,2,3,4\n");
    assert!(found.iter().all(|fault| fault.pointer == "/nodes"), "{found:?}");
    let told: Vec<_> = found.iter().map(|fault| fault.detail.as_str()).collect();
    assert_eq!(
        told,
        [
            "3 cells are not finite numbers",
            "line 3, column 1 (u): `x`",
            "line 3, column 3 (z): `n/a`",
            "line 3, column 4 (weight): empty",
        ]
    );
    let found = faults("u,v,z\n1,2,3\n1,2\n");
    assert!(found[0].detail.contains("1 row has 2 cells for 3 columns"), "{found:?}");
    assert!(found[1].detail.contains("line 3"), "{found:?}");
    for (word, column) in [("nan", 3), ("NaN", 3), ("-inf", 3), ("+Infinity", 3)] {
        let Err(ReadError::Malformed { detail }) = read(&format!("u,v,z\n1,x,3\n1,2,{word}\n1,1,1\n")) else {
            panic!("{word}")
        };
        assert!(detail.starts_with(&format!("Line 3, column {column}: NaN and Infinity")), "{detail}");
    }
    for table in ["", "x\n1\n", "a,b,c,d,e\n1,2,3,4,5\n", "x,y,z\n1,2,3\n", "x,y\n"] {
        assert_eq!(faults(table)[0].pointer, "/nodes", "{table}");
    }
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
        "nodes":{"y":[-0,1.0,40e-1],"x":[0.0,1,2],"type":"curve"}}"#;
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

    /// Whatever bytes arrive: an answer, never a panic; what serde_json takes for JSON is never
    /// called malformed.
    #[test]
    fn mutated_requests_are_answered(
        cut in 0..400_usize, insert in r#"[\[\]{},:"0-9eE.+\-a-z \\]{0,6}"#, delete in 0..4_usize, which in 0..5_usize,
    ) {
        let text = crate::api::examples::REQUEST_EXAMPLES[which].text;
        let begin = cut.min(text.len());
        let end = (begin + delete).min(text.len());
        let mutated = format!("{}{insert}{}", &text[..begin], &text[end..]);
        let json = serde_json::from_str::<serde::de::IgnoredAny>(&mutated).is_ok();
        let malformed = matches!(read(&mutated), Err(ReadError::Malformed { .. }));
        prop_assert_eq!(malformed, !json, "{}", mutated);
    }
}
