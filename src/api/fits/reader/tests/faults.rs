//! Errors of nodes and of the specification are all reported, each at its place.

use super::*;

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
fn of_many_errors_the_first_hundred_are_listed_and_all_counted() {
    let text = with_nodes(&format!(r#"{{"type":"curve","x":[{}],"y":[1]}}"#, vec!["null"; 1000].join(",")));
    let Err(ReadError::Invalid(faults)) = read(&text) else { panic!() };
    assert_eq!((faults.list().len(), faults.count()), (100, 1000));
    assert_eq!(faults.list()[99].pointer, "/nodes/x/99");
}

#[test]
fn errors_in_nodes_have_pointers() {
    for (nodes, expected) in [
        (r#"{"type":"grid","u":[0,1],"v":[0,1],"z":[[1,2],[3]]}"#, vec!["/nodes/z/1"]),
        (r#"{"type":"grid","u":[0,1],"v":[0,1],"z":[[1,2]]}"#, vec!["/nodes/z"]),
        (r#"{"type":"grid","u":[0,1],"v":[0,1],"z":[1,2]}"#, vec!["/nodes/z"]),
        (r#"{"type":"grid","u":[0,1],"v":[0,1],"z":[]}"#, vec!["/nodes/z"]),
        (r#"{"type":"grid","u":[0,1],"v":[0,1],"z":[[1,2],7]}"#, vec!["/nodes/z/1"]),
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
        (r#"{"type":"curve","x":"1","y":[1]}"#, vec!["/nodes/x"]),
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
fn errors_in_the_spec_have_pointers() {
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
fn errors_in_nodes_and_spec_are_reported_together() {
    let text = r#"{"nodes":{"type":"curve","x":[1,null],"y":[1,2]},"model":{"type":"fourier"},"noise":1}"#;
    assert_eq!(pointers(text), ["/noise", "/nodes/x/1", "/model/type"]);
}
