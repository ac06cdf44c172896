//! What a request may look like, and where its faults are said to be.

use proptest::prelude::*;

use super::*;
use crate::api::{
    fits::{canonical::input_sha256, spec::json::to_json},
    json::request::request,
};
use flankfit_engine::estimation::spec::{self, Criterion, Model, Parameter, Regularization};

#[path = "tests_drawn.rs"]
mod drawn;

fn read(text: &str) -> Result<(Nodes, FitSpec), ReadError> {
    read_fit::<()>(text.as_bytes()).map(|(nodes, spec, _)| (nodes, spec))
}

/// The faults of a well-formed request.
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
fn every_bad_node_is_named_at_once() {
    let text = with_nodes(
        r#"{"type":"scattered","u":[0,"a",2,1e400],"v":[0,1,null,[3]],"z":[true,1,2,{"a":[]}],"weight":[1,-1,1,1]}"#,
    );
    assert_eq!(
        pointers(&text),
        ["/nodes/u/1", "/nodes/u/3", "/nodes/v/3", "/nodes/v/2", "/nodes/z/0", "/nodes/z/3", "/nodes/weight/1"]
    );
}

#[test]
fn of_many_faults_a_hundred_are_listed_and_all_are_counted() {
    let text = with_nodes(&format!(r#"{{"type":"curve","x":[{}],"y":[1]}}"#, vec!["null"; 1000].join(",")));
    let Err(ReadError::Invalid(faults)) = read(&text) else { panic!() };
    assert_eq!((faults.list().len(), faults.count()), (100, 1000));
    assert_eq!(faults.list()[99].pointer, "/nodes/x/99");
}

#[test]
fn faults_of_nodes_are_pointed_at() {
    for (nodes, expected) in [
        (r#"{"type":"grid","u":[0,1],"v":[0,1],"z":[[1,2],[3]]}"#, vec!["/nodes/z/1"]),
        (r#"{"type":"grid","u":[0,1],"v":[0,1],"z":[[1,2]]}"#, vec!["/nodes/z"]),
        (r#"{"type":"grid","u":[0,1],"v":[0,1],"z":[1,2]}"#, vec!["/nodes/z"]),
        (r#"{"type":"grid","u":[0,1],"v":[0,1],"z":[]}"#, vec!["/nodes/z"]),
        (r#"{"type":"grid","u":[0,1],"v":[0,1],"z":[[1,2],7]}"#, vec!["/nodes/z/1", "/nodes/z/1"]),
        (r#"{"type":"grid","u":[0,0],"v":[1,0],"z":[[1,2],[3,4]]}"#, vec!["/nodes/u/1", "/nodes/v/1"]),
        (r#"{"type":"grid","u":[0,1],"v":[0],"z":[[1],[1e999]]}"#, vec!["/nodes/z/1/0"]),
        (
            r#"{"type":"grid","u":[0,1],"v":[0],"z":[[1],[2]],"weight":[[null],[-1]]}"#,
            vec!["/nodes/weight/0/0", "/nodes/weight/1/0"],
        ),
        (r#"{"type":"grid","u":[0,1],"v":[0],"z":[[1],[2]],"valid":[[true],[1]]}"#, vec!["/nodes/valid/1/0"]),
        (r#"{"type":"grid","u":[0,1],"v":[0],"z":[[1],[2]],"valid":[[true]]}"#, vec!["/nodes/valid"]),
        (r#"{"type":"grid","u":[],"v":[0],"z":[]}"#, vec!["/nodes/u"]),
        (r#"{"type":"curve","x":[],"y":[]}"#, vec!["/nodes/x"]),
        (r#"{"type":"curve","x":[1,2],"y":[1]}"#, vec!["/nodes/y"]),
        (r#"{"type":"curve","x":[1]}"#, vec!["/nodes/y"]),
        (r#"{"type":"curve","x":"1","y":[1]}"#, vec!["/nodes/x", "/nodes/y"]),
        (r#"{"type":"curve","x":[[1]],"y":[1]}"#, vec!["/nodes/x"]),
        (r#"{"type":"curve","x":[1],"y":[1],"z":[1]}"#, vec!["/nodes/z"]),
        (r#"{"type":"curve","x":[1],"y":[1],"a/b~":[1]}"#, vec!["/nodes/a~1b~0"]),
        (r#"{"type":"curve","x":[1],"x":[1],"y":[1]}"#, vec!["/nodes/x"]),
        (r#"{"type":"circle","x":[1],"y":[1]}"#, vec!["/nodes/type"]),
        (r#"{"type":3,"x":[1],"y":[1]}"#, vec!["/nodes/type"]),
        (r#"{"x":[1],"y":[1]}"#, vec!["/nodes/type"]),
        ("[]", vec!["/nodes"]),
        ("null", vec!["/nodes"]),
        (r#"{"type":"matrix","x":[[1,2],[3]],"y":[1,2]}"#, vec!["/nodes/x/1"]),
        (r#"{"type":"matrix","x":[1,2],"y":[1,2]}"#, vec!["/nodes/x"]),
        (r#"{"type":"matrix","x":[[1,null]],"y":[1]}"#, vec!["/nodes/x/0/1"]),
        (r#"{"type":"matrix","x":[[1,2]],"y":[1],"names":["a",2]}"#, vec!["/nodes/names/1"]),
        (r#"{"type":"matrix","x":[[1,2]],"y":[1],"names":["a","a"]}"#, vec!["/nodes/names/1"]),
        (r#"{"type":"matrix","x":[],"y":[]}"#, vec!["/nodes/x"]),
        (r#"{"type":"matrix","x":[[]],"y":[1]}"#, vec!["/nodes/x", "/nodes/y"]),
    ] {
        assert_eq!(pointers(&with_nodes(nodes)), expected, "{nodes}");
    }
}

#[test]
fn faults_of_the_spec_are_pointed_at() {
    let model = |text: &str| format!(r#""model":{text}"#);
    let beside = |text: &str| format!("{LINE},{text}");
    for (spec, expected) in [
        (model(r#"{"type":"polynomial"}"#), "/model/degree"),
        (model(r#"{"type":"polynomial","degree":-1}"#), "/model/degree"),
        (model(r#"{"type":"polynomial","degree":1.5}"#), "/model/degree"),
        (model(r#"{"type":"polynomial","degree":[1]}"#), "/model/degree"),
        (model(r#"{"type":"polynomial","degree":[1,2,3]}"#), "/model/degree"),
        (model(r#"{"type":"polynomial","degree":[1,"2"]}"#), "/model/degree/1"),
        (model(r#"{"type":"polynomial","degree":1e30}"#), "/model/degree"),
        (model(r#"{"type":"polynomial","degree":99999999999999999999}"#), "/model/degree"),
        (model(r#"{"type":"polynomial","degree":1,"basis":"fourier"}"#), "/model/basis"),
        (model(r#"{"type":"polynomial","degree":1,"basis":null}"#), "/model/basis"),
        (model(r#"{"type":"polynomial","degree":1,"knots":[1]}"#), "/model/knots"),
        (model(r#"{"type":"polynomial","degree":1,"degree":1}"#), "/model/degree"),
        (model(r#"{"type":"b_spline","degree":1}"#), "/model"),
        (model(r#"{"type":"b_spline","degree":1,"spans":2,"knots":[1,2]}"#), "/model/spans"),
        (model(r#"{"type":"b_spline","degree":1,"knots":[0,1e400]}"#), "/model/knots/1"),
        (model(r#"{"type":"b_spline","degree":1,"knots":[[0],["a"]]}"#), "/model/knots/1/0"),
        (model(r#"{"type":"b_spline","degree":1,"spans":"many"}"#), "/model/spans"),
        (model(r#"{"type":"fourier"}"#), "/model/type"),
        (model(r#"{"degree":1}"#), "/model/type"),
        (model("3"), "/model"),
        (beside(r#""scaling":"paper""#), "/scaling"),
        (beside(r#""scaling":null"#), "/scaling"),
        (beside(r#""regularization":{"type":"lasso"}"#), "/regularization/type"),
        (beside(r#""regularization":{"type":"none","count":1}"#), "/regularization/count"),
        (beside(r#""regularization":{"type":"spectral","count":"all"}"#), "/regularization/count"),
        (beside(r#""regularization":{"type":"spectral","count":-1}"#), "/regularization/count"),
        (beside(r#""regularization":{"type":"spectral","condition_limit":1}"#), "/regularization/condition_limit"),
        (
            beside(r#""regularization":{"type":"spectral","lambda_star":{"criterion":"luck"}}"#),
            "/regularization/lambda_star/criterion",
        ),
        (
            beside(r#""regularization":{"type":"spectral","lambda_star":{"criterion":"fixed"}}"#),
            "/regularization/lambda_star/value",
        ),
        (
            beside(r#""regularization":{"type":"spectral","lambda_star":{"criterion":"gcv","value":1}}"#),
            "/regularization/lambda_star/value",
        ),
        (
            beside(r#""regularization":{"type":"ridge","parameter":{"criterion":"fixed","value":0}}"#),
            "/regularization/parameter/value",
        ),
        (beside(r#""regularization":{"type":"ridge","lambda_star":{}}"#), "/regularization/lambda_star"),
        (beside(r#""estimator":{"type":"huber"}"#), "/estimator/type"),
        (beside(r#""estimator":{"type":"m_estimator"}"#), "/estimator/loss"),
        (beside(r#""estimator":{"type":"m_estimator","loss":"huber","tuning":[0]}"#), "/estimator/tuning/0"),
        (beside(r#""estimator":{"type":"m_estimator","loss":"hampel","tuning":[2]}"#), "/estimator/tuning"),
        (beside(r#""estimator":{"type":"m_estimator","loss":"hampel","tuning":[2,8,4]}"#), "/estimator/tuning"),
        (
            beside(r#""estimator":{"type":"m_estimator","loss":"huber","scale":{"rule":"fixed"}}"#),
            "/estimator/scale/value",
        ),
        (
            beside(r#""estimator":{"type":"m_estimator","loss":"huber","scale":{"rule":"mad","value":1}}"#),
            "/estimator/scale/value",
        ),
        (
            beside(r#""estimator":{"type":"m_estimator","loss":"huber","scale":{"rule":"proposal2","value":0}}"#),
            "/estimator/scale/value",
        ),
        (beside(r#""estimator":{"type":"m_estimator","loss":"huber","tolerance":0}"#), "/estimator/tolerance"),
        (
            beside(r#""estimator":{"type":"m_estimator","loss":"huber","max_iterations":0}"#),
            "/estimator/max_iterations",
        ),
        (beside(r#""estimator":{"type":"m_estimator","loss":"huber","start":"zero"}"#), "/estimator/start"),
        (beside(r#""estimator":{"type":"lp","p":2.5}"#), "/estimator/p"),
        (beside(r#""estimator":{"type":"lp"}"#), "/estimator/p"),
        (beside(r#""estimator":{"type":"quantile","tau":1}"#), "/estimator/tau"),
        (beside(r#""estimator":{"type":"least_trimmed_squares","coverage":0.4}"#), "/estimator/coverage"),
        (beside(r#""estimator":{"type":"least_trimmed_squares","seed":-1}"#), "/estimator/seed"),
        (beside(r#""estimator":{"type":"rank","scores":"savage"}"#), "/estimator/scores"),
        (beside(r#""estimator":{"type":"least_squares","tuning":1}"#), "/estimator/tuning"),
        (beside(r#""domain":{"u":[0]}"#), "/domain/u"),
        (beside(r#""domain":{"u":[1,0]}"#), "/domain/u"),
        (beside(r#""domain":{"w":[1,0]}"#), "/domain/w"),
        (beside(r#""coefficient_norm_limit":0"#), "/coefficient_norm_limit"),
        (beside(r#""coefficient_norm_limit":"1""#), "/coefficient_norm_limit"),
        (beside(r#""noise_sigma":-1"#), "/noise_sigma"),
        (beside(r#""noise_sigma":1e400"#), "/noise_sigma"),
        (beside(r#""node_uncertainty":{"position":0}"#), "/node_uncertainty/height"),
        (beside(r#""node_uncertainty":{"position":-1,"height":0}"#), "/node_uncertainty/position"),
        (beside(r#""include":["everything"]"#), "/include/0"),
        (beside(r#""include":"residuals""#), "/include"),
        (beside(r#""filter":[]"#), "/filter"),
        (beside(r#""scaling":"none","scaling":"none""#), "/scaling"),
    ] {
        assert_eq!(pointers(&with_spec(&spec)), [expected], "{spec}");
    }
    assert_eq!(pointers("{}"), ["/nodes", "/model"]);
    assert_eq!(pointers("[1]"), ["", "/nodes", "/model"]);
    let details = faults(&with_spec(&beside(r#""estimator":{"type":"huber"}"#)));
    assert!(details[0].1.contains("least_squares"), "{details:?}");
}

#[test]
fn faults_of_nodes_and_spec_are_answered_together() {
    let text = r#"{"nodes":{"type":"curve","x":[1,null],"y":[1,2]},"model":{"type":"fourier"},"noise":1}"#;
    assert_eq!(pointers(text), ["/noise", "/nodes/x/1", "/model/type"]);
}

#[test]
fn what_is_not_json_is_refused_with_its_place() {
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
    /// What else is known.
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
fn tables_are_read_and_their_faults_have_line_and_column() {
    let spec = format!("{{{LINE}}}");
    let read = |table: &str| read_fit_with_csv::<()>(spec.as_bytes(), table.as_bytes()).map(|(nodes, _, _)| nodes);
    let faults = |table: &str| match read(table) {
        Err(ReadError::Invalid(faults)) => faults.list().to_vec(),
        other => panic!("{table}: {other:?}"),
    };
    let expected = Nodes::scattered(vec![0.0, 2.0], vec![1.0, 1.0], vec![-5e-3, 7.0], None).unwrap();
    assert_eq!(read("u,v,z\n0,1,-5e-3\r\n1,1,\n 2 , 1 ,7\n").unwrap(), expected);
    let expected = Nodes::curve(vec![1.0], vec![2.0], Some(vec![0.5])).unwrap();
    assert_eq!(read("\u{feff}x,y,weight\n1,2,0.5").unwrap(), expected);
    let found = faults("u,v,z,weight\n1,2,3,4\nx,2,n/a,\n1,2\n");
    let pointers: Vec<_> = found.iter().map(|fault| fault.pointer.as_str()).collect();
    assert_eq!(pointers, ["/nodes/u/1", "/nodes/z/1", "/nodes/weight/1", "/nodes"]);
    assert!(found[1].detail.contains("line 3, column 3 (z)"), "{found:?}");
    assert!(found[3].detail.contains("line 4"), "{found:?}");
    for (word, column) in [("nan", 3), ("NaN", 3), ("-inf", 3), ("+Infinity", 3)] {
        let Err(ReadError::Malformed { detail }) = read(&format!("u,v,z\n1,x,3\n1,2,{word}\n")) else {
            panic!("{word}")
        };
        assert!(detail.starts_with(&format!("Line 3, column {column}: NaN and Infinity")), "{detail}");
    }
    for table in ["", "a,b\n1,2\n", "x\n1\n", "u,v,z,w\n", "1,2\n", "x;y\n1;2\n"] {
        assert_eq!(faults(table)[0].pointer, "/nodes", "{table}");
    }
    assert_eq!(faults("x,y\n")[0].pointer, "/nodes/x");
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
