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
        (r#"{"type":"curve","x":[],"y":[]}"#, "/nodes/x"),
        (r#"{"type":"curve","x":[1,2,3],"y":[1,2]}"#, "/nodes/y"),
        (r#"{"type":"curve","x":[1,2,3],"y":[1,1e400,2]}"#, "/nodes/y/1"),
        (r#"{"type":"curve","x":[1,2,3],"y":[1,null,2]}"#, "/nodes/y/1"),
        (r#"{"type":"curve","x":[1,2,3],"y":[1,"2",2]}"#, "/nodes/y/1"),
        (r#"{"type":"curve","x":[1,2,3],"y":[1,2,2],"weight":[1,-1,1]}"#, "/nodes/weight/1"),
        (r#"{"type":"curve","x":[1,2,3],"y":[1,2,2],"colour":1}"#, "/nodes/colour"),
        (r#"{"type":"grid","u":[0,1],"v":[0,1],"z":[[1,2],[3]]}"#, "/nodes/z/1"),
        (r#"{"type":"grid","u":[0,0],"v":[0,1],"z":[[1,2],[3,4]]}"#, "/nodes/u/1"),
        (r#"{"type":"grid","u":[0,1],"v":[1,0],"z":[[1,2],[3,4]]}"#, "/nodes/v/1"),
        (r#"{"type":"grid","u":[0,1],"v":5,"z":[[1,2],[3,4]]}"#, "/nodes/v"),
        (r#"{"type":"grid","u":5,"v":[0,1],"z":[[1,2],[3,4]]}"#, "/nodes/u"),
        (r#"{"type":"grid","u":[0,1],"v":[0,1],"z":5}"#, "/nodes/z"),
        (r#"{"type":"grid","u":[0,1,2],"v":[0,1],"z":[5,[1,2],[3,4]]}"#, "/nodes/z/0"),
        (r#"{"type":"grid","u":[0,1,2],"v":[0,1],"z":[[1,2],5,[3,4]]}"#, "/nodes/z/1"),
        (r#"{"type":"sphere"}"#, "/nodes/type"),
        ("[]", "/nodes"),
    ] {
        assert_eq!(refused(&app, nodes, LINE).await.pointers(), [expected], "{nodes}");
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
    for (rest, expected) in [
        (r#""model":{"type":"polynomial","degree":-1}"#, "/model/degree"),
        (r#""model":{"type":"polynomial","degree":"2"}"#, "/model/degree"),
        (r#""model":{"type":"spline","degree":2}"#, "/model/type"),
        (r#""model":{"type":"polynomial","degree":1},"estimator":{"type":"huber"}"#, "/estimator/type"),
        (
            r#""model":{"type":"polynomial","degree":1},"estimator":{"type":"m_estimator","loss":"huber","tuning":[-1]}"#,
            "/estimator/tuning/0",
        ),
        (r#""model":{"type":"polynomial","degree":1},"estimator":{"type":"quantile","tau":1.5}"#, "/estimator/tau"),
        (r#""model":{"type":"polynomial","degree":2},"estimator":{"type":"least_trimmed_squares"}"#, "/estimator/type"),
        (
            r#""model":{"type":"polynomial","degree":1},"estimator":{"type":"m_estimator","loss":"tukey","scale":{"rule":"fixed","value":1e-9}}"#,
            "/estimator/scale/value",
        ),
        (
            r#""model":{"type":"polynomial","degree":1},"estimator":{"type":"m_estimator","loss":"tukey","tuning":[1e-6]}"#,
            "/estimator/tuning",
        ),
        (r#""model":{"type":"polynomial","degree":1},"noise_sigma":0"#, "/noise_sigma"),
        (r#""model":{"type":"polynomial","degree":1},"smoothing":0"#, "/smoothing"),
        (r#""scaling":"none""#, "/model"),
    ] {
        assert_eq!(refused(&app, nodes, rest).await.pointers(), [expected], "{rest}");
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
