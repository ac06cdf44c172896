//! JSON that cannot be accepted: 422 with pointers.

use crate::harness::{Answer, TestApp};

/// A fit request around nodes and model.
fn request(nodes: &str, rest: &str) -> String {
    format!(r#"{{"nodes":{nodes},{rest}}}"#)
}

const LINE: &str = r#""model":{"type":"polynomial","degree":1}"#;

async fn refused(app: &TestApp, nodes: &str, rest: &str) -> Answer {
    app.fit(&request(nodes, rest)).await
}

#[tokio::test]
async fn bad_nodes_are_pointed_at() {
    let app = TestApp::start().await;
    for (nodes, expected) in [
        (r#"{"type":"grid","u":[0,1],"v":[0,1],"z":[[1,2],[3]]}"#, &["/nodes/z/1"][..]),
        (r#"{"type":"grid","u":[0,1],"v":[0,1],"z":[[1,2]]}"#, &["/nodes/z"]),
        (r#"{"type":"grid","u":[0,1],"v":[0,1],"z":[1,2]}"#, &["/nodes/z"]),
        (r#"{"type":"grid","u":[0,1],"v":[0,1],"z":[]}"#, &["/nodes/z"]),
        (r#"{"type":"grid","u":[0,1],"v":[0,1],"z":[[1,2],7]}"#, &["/nodes/z/1"]),
        (r#"{"type":"grid","u":[0,0],"v":[1,0],"z":[[1,2],[3,4]]}"#, &["/nodes/u/1", "/nodes/v/1"]),
        (r#"{"type":"grid","u":[0,1],"v":[0],"z":[[1],[1e999]]}"#, &["/nodes/z/1/0"]),
        (
            r#"{"type":"grid","u":[0,1],"v":[0],"z":[[1],[2]],"weight":[[null],[-1]]}"#,
            &["/nodes/weight/0/0", "/nodes/weight/1/0"],
        ),
        (r#"{"type":"grid","u":[0,1],"v":[0],"z":[[1],[2]],"valid":[[true],[1]]}"#, &["/nodes/valid/1/0"]),
        (r#"{"type":"grid","u":[0,1],"v":[0],"z":[[1],[2]],"valid":[[true]]}"#, &["/nodes/valid"]),
        (r#"{"type":"grid","u":[],"v":[0],"z":[]}"#, &["/nodes/u"]),
        (r#"{"type":"curve","x":[],"y":[]}"#, &["/nodes/x"]),
        (r#"{"type":"curve","x":[1,2],"y":[1]}"#, &["/nodes/y"]),
        (r#"{"type":"curve","x":[1]}"#, &["/nodes/y"]),
        (r#"{"type":"curve","x":"1","y":[1]}"#, &["/nodes/x"]),
        (r#"{"type":"curve","x":[[1]],"y":[1]}"#, &["/nodes/x"]),
        (r#"{"type":"curve","x":[1],"y":[1],"z":[1]}"#, &["/nodes/z"]),
        (r#"{"type":"curve","x":[1],"y":[1],"a/b~":[1]}"#, &["/nodes/a~1b~0"]),
        (r#"{"type":"curve","x":[1],"x":[1],"y":[1]}"#, &["/nodes/x"]),
        (r#"{"type":"circle","x":[1],"y":[1]}"#, &["/nodes/type"]),
        (r#"{"type":3,"x":[1],"y":[1]}"#, &["/nodes/type"]),
        (r#"{"x":[1],"y":[1]}"#, &["/nodes/type"]),
        ("[]", &["/nodes"]),
        ("null", &["/nodes"]),
        (r#"{"type":"matrix","x":[[1,2],[3]],"y":[1,2]}"#, &["/nodes/x/1"]),
        (r#"{"type":"matrix","x":[1,2],"y":[1,2]}"#, &["/nodes/x"]),
        (r#"{"type":"matrix","x":[[1,null]],"y":[1]}"#, &["/nodes/x/0/1"]),
        (r#"{"type":"matrix","x":[[1,2]],"y":[1],"names":["a",2]}"#, &["/nodes/names/1"]),
        (r#"{"type":"matrix","x":[[1,2]],"y":[1],"names":["a","a"]}"#, &["/nodes/names/1"]),
        (r#"{"type":"matrix","x":[],"y":[]}"#, &["/nodes/x"]),
        (r#"{"type":"matrix","x":[[]],"y":[1]}"#, &["/nodes/x", "/nodes/y"]),
        (
            r#"{"type":"scattered","u":[0,"a",2,1e400],"v":[0,1,null,[3]],"z":[true,1,2,{"a":[]}],"weight":[1,-1,1,1]}"#,
            &["/nodes/u/1", "/nodes/u/3", "/nodes/v/3", "/nodes/v/2", "/nodes/z/0", "/nodes/z/3", "/nodes/weight/1"],
        ),
        (r#"{"type":"curve","x":[1,2,3],"y":[1,2]}"#, &["/nodes/y"]),
        (r#"{"type":"curve","x":[1,2,3],"y":[1,1e400,2]}"#, &["/nodes/y/1"]),
        (r#"{"type":"curve","x":[1,2,3],"y":[1,null,2]}"#, &["/nodes/y/1"]),
        (r#"{"type":"curve","x":[1,2,3],"y":[1,"2",2]}"#, &["/nodes/y/1"]),
        (r#"{"type":"curve","x":[1,2,3],"y":[1,2,2],"weight":[1,-1,1]}"#, &["/nodes/weight/1"]),
        (r#"{"type":"curve","x":[1,2,3],"y":[1,2,2],"colour":1}"#, &["/nodes/colour"]),
        (r#"{"type":"grid","u":[0,0],"v":[0,1],"z":[[1,2],[3,4]]}"#, &["/nodes/u/1"]),
        (r#"{"type":"grid","u":[0,1],"v":[1,0],"z":[[1,2],[3,4]]}"#, &["/nodes/v/1"]),
        (r#"{"type":"grid","u":[0,1],"v":5,"z":[[1,2],[3,4]]}"#, &["/nodes/v"]),
        (r#"{"type":"grid","u":5,"v":[0,1],"z":[[1,2],[3,4]]}"#, &["/nodes/u"]),
        (r#"{"type":"grid","u":[0,1],"v":[0,1],"z":5}"#, &["/nodes/z"]),
        (r#"{"type":"grid","u":[0,1,2],"v":[0,1],"z":[5,[1,2],[3,4]]}"#, &["/nodes/z/0"]),
        (r#"{"type":"grid","u":[0,1,2],"v":[0,1],"z":[[1,2],5,[3,4]]}"#, &["/nodes/z/1"]),
        (r#"{"type":"sphere"}"#, &["/nodes/type"]),
    ] {
        assert_eq!(refused(&app, nodes, LINE).await.pointers(), expected, "{nodes}");
    }
}

#[tokio::test]
async fn the_first_hundred_of_many_bad_nodes_are_listed() {
    let app = TestApp::start().await;
    let x = vec!["1e999"; 250].join(",");
    let answer = refused(&app, &format!(r#"{{"type":"curve","x":[{x}],"y":[1]}}"#), LINE).await;
    assert_eq!(answer.pointers().len(), 100);
    assert!(answer.text.contains("250 errors"), "{}", answer.text);
}

#[tokio::test]
async fn bad_specs_are_pointed_at() {
    let app = TestApp::start().await;
    let nodes = r#"{"type":"curve","x":[0,1,2],"y":[0,1,4]}"#;
    let model = |text: &str| format!(r#""model":{text}"#);
    let with = |text: &str| format!("{LINE},{text}");
    for (rest, expected) in [
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
        (with(r#""scaling":"paper""#), "/scaling"),
        (with(r#""regularization":{"type":"lasso"}"#), "/regularization/type"),
        (with(r#""regularization":{"type":"none","count":1}"#), "/regularization/count"),
        (with(r#""regularization":{"type":"spectral","count":"all"}"#), "/regularization/count"),
        (with(r#""regularization":{"type":"spectral","count":-1}"#), "/regularization/count"),
        (with(r#""regularization":{"type":"spectral","condition_limit":1}"#), "/regularization/condition_limit"),
        (
            with(r#""regularization":{"type":"spectral","lambda_star":{"criterion":"luck"}}"#),
            "/regularization/lambda_star/criterion",
        ),
        (
            with(r#""regularization":{"type":"spectral","lambda_star":{"criterion":"fixed"}}"#),
            "/regularization/lambda_star/value",
        ),
        (
            with(r#""regularization":{"type":"spectral","lambda_star":{"criterion":"gcv","value":1}}"#),
            "/regularization/lambda_star/value",
        ),
        (
            with(r#""regularization":{"type":"ridge","parameter":{"criterion":"fixed","value":0}}"#),
            "/regularization/parameter/value",
        ),
        (with(r#""regularization":{"type":"ridge","lambda_star":{}}"#), "/regularization/lambda_star"),
        (with(r#""domain":{"u":[0]}"#), "/domain/u"),
        (with(r#""domain":{"u":[1,0]}"#), "/domain/u"),
        (with(r#""domain":{"w":[1,0]}"#), "/domain/w"),
        (with(r#""coefficient_norm_limit":0"#), "/coefficient_norm_limit"),
        (with(r#""coefficient_norm_limit":"1""#), "/coefficient_norm_limit"),
        (with(r#""noise_sigma":-1"#), "/noise_sigma"),
        (with(r#""noise_sigma":1e400"#), "/noise_sigma"),
        (with(r#""node_uncertainty":{"position":0}"#), "/node_uncertainty/height"),
        (with(r#""node_uncertainty":{"position":-1,"height":0}"#), "/node_uncertainty/position"),
        (with(r#""include":["everything"]"#), "/include/0"),
        (with(r#""include":"residuals""#), "/include"),
        (with(r#""filter":[]"#), "/filter"),
        (with(r#""scaling":"none","scaling":"none""#), "/scaling"),
        (model(r#"{"type":"polynomial","degree":"2"}"#), "/model/degree"),
        (model(r#"{"type":"polynomial","degree":2},"estimator":{"type":"least_trimmed_squares"}"#), "/estimator/type"),
        (with(r#""noise_sigma":0"#), "/noise_sigma"),
        (with(r#""smoothing":0"#), "/smoothing"),
        (r#""scaling":"none""#.to_owned(), "/model"),
    ] {
        assert_eq!(refused(&app, nodes, &rest).await.pointers(), [expected], "{rest}");
    }
    assert_eq!(app.fit("{}").await.pointers(), ["/nodes", "/model"]);
    let both = r#"{"nodes":{"type":"curve","x":[1,null],"y":[1,2]},"model":{"type":"fourier"},"noise":1}"#;
    assert_eq!(app.fit(both).await.pointers(), ["/noise", "/nodes/x/1", "/model/type"]);
}

#[tokio::test]
async fn bad_estimators_are_pointed_at() {
    let app = TestApp::start().await;
    let nodes = r#"{"type":"curve","x":[0,1,2],"y":[0,1,4]}"#;
    for (estimator, expected) in [
        (r#"{"type":"huber"}"#, "/estimator/type"),
        (r#"{"type":"m_estimator"}"#, "/estimator/loss"),
        (r#"{"type":"m_estimator","loss":"huber","tuning":[0]}"#, "/estimator/tuning/0"),
        (r#"{"type":"m_estimator","loss":"hampel","tuning":[2]}"#, "/estimator/tuning"),
        (r#"{"type":"m_estimator","loss":"hampel","tuning":[2,8,4]}"#, "/estimator/tuning"),
        (r#"{"type":"m_estimator","loss":"huber","scale":{"rule":"fixed"}}"#, "/estimator/scale/value"),
        (r#"{"type":"m_estimator","loss":"huber","scale":{"rule":"mad","value":1}}"#, "/estimator/scale/value"),
        (r#"{"type":"m_estimator","loss":"huber","scale":{"rule":"proposal2","value":0}}"#, "/estimator/scale/value"),
        (r#"{"type":"m_estimator","loss":"huber","tolerance":0}"#, "/estimator/tolerance"),
        (r#"{"type":"m_estimator","loss":"huber","max_iterations":0}"#, "/estimator/max_iterations"),
        (r#"{"type":"m_estimator","loss":"huber","start":"zero"}"#, "/estimator/start"),
        (r#"{"type":"lp","p":2.5}"#, "/estimator/p"),
        (r#"{"type":"lp"}"#, "/estimator/p"),
        (r#"{"type":"quantile","tau":1}"#, "/estimator/tau"),
        (r#"{"type":"least_trimmed_squares","coverage":0.4}"#, "/estimator/coverage"),
        (r#"{"type":"least_trimmed_squares","seed":-1}"#, "/estimator/seed"),
        (r#"{"type":"rank","scores":"savage"}"#, "/estimator/scores"),
        (r#"{"type":"least_squares","tuning":1}"#, "/estimator/tuning"),
        (r#"{"type":"m_estimator","loss":"huber","tuning":[-1]}"#, "/estimator/tuning/0"),
        (r#"{"type":"m_estimator","loss":"tukey","scale":{"rule":"fixed","value":1e-9}}"#, "/estimator/scale/value"),
        (r#"{"type":"m_estimator","loss":"tukey","tuning":[1e-6]}"#, "/estimator/tuning"),
    ] {
        let rest = format!(r#"{LINE},"estimator":{estimator}"#);
        assert_eq!(refused(&app, nodes, &rest).await.pointers(), [expected], "{rest}");
    }
}

#[tokio::test]
async fn errors_found_by_the_fit_are_refused_too() {
    let app = TestApp::start().await;
    let three = r#"{"type":"curve","x":[0,1,2],"y":[0,1,4]}"#;
    let grid = r#"{"type":"grid","u":[0,1,2],"v":[0,1,2],"z":[[1,2,3],[4,5,6],[7,8,9.5]]}"#;
    for (nodes, rest) in [
        (three, r#""model":{"type":"polynomial","degree":3}"#),
        (three, r#""model":{"type":"polynomial","degree":1000000000}"#),
        (three, r#""model":{"type":"polynomial","degree":18446744073709551615}"#),
        (grid, r#""model":{"type":"polynomial","degree":[4294967296,4294967296]}"#),
        (grid, r#""model":{"type":"polynomial","degree":[1,2],"terms":"total"}"#),
        (grid, r#""model":{"type":"linear"}"#),
        (three, r#""model":{"type":"linear"}"#),
        (three, r#""model":{"type":"b_spline","degree":3,"knots":[0,1,0,2]}"#),
        (three, r#""model":{"type":"b_spline","degree":3,"spans":1000000000000}"#),
        (three, r#""model":{"type":"polynomial","degree":1},"domain":{"u":[0,1]}"#),
        (r#"{"type":"grid","u":[0,1],"v":[0,1],"z":[[null,null],[null,null]]}"#, LINE),
        (r#"{"type":"curve","x":[0,1,2],"y":[0,1,4],"weight":[0,0,0]}"#, LINE),
    ] {
        let answer = refused(&app, nodes, rest).await;
        assert!(!answer.pointers().is_empty(), "{rest}: {}", answer.text);
    }
}

#[tokio::test]
async fn dependent_columns_are_named_or_regularised() {
    let app = TestApp::start().await;
    let equal = r#"{"type":"curve","x":[2,2,2,2],"y":[1,1.1,0.9,1]}"#;
    let answer = refused(&app, equal, LINE).await;
    let body = answer.problem(422, "rank_deficient");
    assert!(body["detail"].as_str().unwrap().contains('x'), "{body}");
    let ridge = r#""model":{"type":"polynomial","degree":1},"regularization":{"type":"ridge"}"#;
    let answer = refused(&app, equal, ridge).await;
    assert_eq!(answer.status, 200, "{}", answer.text);
    let body = answer.json();
    assert_eq!(body["spectrum"]["rank"], 1);
    assert!(body["spectrum"].get("condition").is_none());
    assert!(!body["warnings"].as_array().unwrap().is_empty());
}

#[tokio::test]
async fn numbers_that_overflow_inside_are_refused_not_answered_with_null() {
    let app = TestApp::start().await;
    for scale in ["1e150", "1e200", "1e300", "1e-150", "1e-200", "1e-300", "5e-324"] {
        let x: Vec<String> = (1..=5).map(|i| scale.replacen(['1', '5'], &i.to_string(), 1)).collect();
        for nodes in [
            format!(r#"{{"type":"curve","x":[{}],"y":[1,2,3,4,6]}}"#, x.join(",")),
            format!(r#"{{"type":"curve","x":[1,2,3,4,6],"y":[{}]}}"#, x.join(",")),
        ] {
            for regularization in ["none", "spectral", "ridge"] {
                let rest = format!(
                    r#""model":{{"type":"polynomial","degree":3}},"regularization":{{"type":"{regularization}"}}"#
                );
                let answer = refused(&app, &nodes, &rest).await;
                assert!(matches!(answer.status.as_u16(), 200 | 422), "{nodes}: {}", answer.text);
                assert!(!answer.text.contains("null"), "{nodes}: {}", answer.text);
            }
        }
    }
}
