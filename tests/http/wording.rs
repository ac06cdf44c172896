//! Wording of refusals: readable numbers, no words of Rust, parts of the URL by their names.

use serde_json::json;

use crate::harness::{Answer, TestApp, send};

const LINE: &str = r#""model":{"type":"polynomial","degree":1}"#;

/// The detail of every fault.
fn details(answer: &Answer) -> Vec<String> {
    let body = answer.problem(422, "invalid_request");
    body["errors"].as_array().unwrap().iter().map(|error| error["detail"].as_str().unwrap().to_owned()).collect()
}

#[tokio::test]
async fn tiny_and_huge_numbers_are_written_with_an_exponent() {
    let app = TestApp::start().await;
    let curve = r#""nodes":{"type":"curve","x":[0,1,2,3],"y":[1,3.1,4.9,7.2]}"#;
    let grid = |u: &str| format!(r#""nodes":{{"type":"grid","u":{u},"v":[0,1],"z":[[1,2],[3,4]]}},{LINE}"#);
    let with = |part: &str| format!("{curve},{LINE},{part}");
    for request in [
        with(r#""noise_sigma":-1e-300"#),
        with(r#""coefficient_norm_limit":-1e300"#),
        with(r#""domain":{"u":[1e300,-1e-300]}"#),
        with(r#""domain":{"u":[1e299,1e300]}"#),
        with(r#""node_uncertainty":{"position":-1e300,"height":-1e-300}"#),
        with(r#""regularization":{"type":"spectral","condition_limit":1e-300}"#),
        with(r#""regularization":{"type":"ridge","parameter":{"criterion":"fixed","value":-1e300}}"#),
        with(r#""regularization":{"type":"tikhonov","order":1,"weights":[-1e300]}"#),
        with(r#""estimator":{"type":"lp","p":1e300}"#),
        with(r#""estimator":{"type":"quantile","tau":1e300}"#),
        with(r#""estimator":{"type":"least_trimmed_squares","coverage":1e-300}"#),
        with(r#""estimator":{"type":"m_estimator","loss":"huber","tuning":[-1e-300]}"#),
        with(r#""estimator":{"type":"m_estimator","loss":"hampel","tuning":[1e300,1e299,1e298]}"#),
        with(r#""estimator":{"type":"m_estimator","loss":"huber","tolerance":1e300}"#),
        with(r#""estimator":{"type":"m_estimator","loss":"huber","scale":{"rule":"proposal2","value":1e300}}"#),
        with(r#""filters":[{"type":"spline","cutoff":-1e300}]"#),
        with(r#""filters":[{"type":"gaussian","cutoff":1e-300}]"#),
        with(r#""filters":[{"type":"hampel","threshold":-1e-300}]"#),
        format!(r#"{curve},"model":{{"type":"b_spline","degree":1,"knots":[0,0,1e300,1e-300]}}"#),
        format!(r#"{curve},"model":{{"type":"polynomial","degree":1e300}}"#),
        grid("[1e300,1e-300]"),
        format!(r#""nodes":{{"type":"curve","x":[0,1],"y":[0,1],"weight":[1,-1e-300]}},{LINE}"#),
    ] {
        for detail in details(&app.fit(&format!("{{{request}}}")).await) {
            assert!(!detail.contains("0000000"), "{request}: {detail}");
            assert!(
                detail.contains("e300") || detail.contains("e-300") || detail.contains("e299"),
                "{request}: {detail}"
            );
        }
    }
    let stream = json!({"model": {"type": "polynomial", "degree": 1}, "forgetting_factor": 1e300});
    let job = send(app.post("/v1/jobs", r#"{"name":"w"}"#)).await.header("location").to_owned();
    let answer = send(app.post(&format!("{job}/streams"), stream.to_string())).await;
    assert!(answer.text.contains("expected a number of at most 1, found 1e300"), "{}", answer.text);
    let gear = r#"{"name":"w","gear":{"teeth":9,"normal_module_mm":-1e300}}"#;
    assert_eq!(
        details(&send(app.post("/v1/jobs", gear)).await),
        ["expected a number from 0.001 to 1000000, found -1e300"]
    );
    let huge = format!(r#"{{{curve},"model":{{"type":"polynomial","degree":18446744073709551615}}}}"#);
    let message = "a fit has at most 600 coefficients, this model has more: use fewer";
    assert_eq!(details(&app.fit(&huge).await), [message]);
}

#[tokio::test]
async fn the_detail_alone_identifies_the_error() {
    let app = TestApp::start().await;
    let curve = r#""nodes":{"type":"curve","x":[0,1,2,3],"y":[1,3.1,4.9,7.2]}"#;
    for (request, detail) in [
        (
            format!(r#"{curve},{LINE},"regularisation":{{}}"#),
            "/regularisation: there is no such field; did you mean `regularization`?",
        ),
        (format!(r#"{curve},"modle":{{}},{LINE}"#), "/modle: there is no such field; did you mean `model`?"),
        (
            format!(r#""nodes":{{"type":"curve","x":[0,1],"y":[0,1],"wieght":[1,1]}},{LINE}"#),
            "/nodes/wieght: there is no such field; did you mean `weight`?",
        ),
        (
            format!(r#"{curve},{LINE},"scaling":"unit_lenght""#),
            "/scaling: `unit_lenght` is not known; expected one of `unit_length`, `none`, `standardized`; did you mean \
             `unit_length`?",
        ),
        (
            format!(r#"{curve},{LINE},"regularisation":{{}},"scaling":"big""#),
            "/regularisation: there is no such field; did you mean `regularization`? And 1 more error, see `errors`.",
        ),
    ] {
        let problem = app.fit(&format!("{{{request}}}")).await.problem(422, "invalid_request");
        assert_eq!(problem["detail"], detail, "{problem}");
        assert_eq!(problem["title"], "The request is invalid");
    }
    let answer = send(app.post("/v1/jobs", r#"{"name":""}"#)).await.problem(422, "invalid_request");
    assert_eq!(answer["detail"], "/name: expected a string of 1 to 200 characters, found 0 characters.");
    let gear = r#"{"gear":{"teeth":20,"normal_module_mm":1,"helix_angel_deg":1},"class":12}"#;
    let answer = send(app.post("/v1/gears/tolerances", gear)).await.problem(422, "invalid_request");
    let detail = answer["detail"].as_str().unwrap();
    assert!(
        detail.starts_with("/gear/helix_angel_deg: there is no such field; did you mean `helix_angle_deg`?"),
        "{detail}"
    );
    let answer = send(app.get("/v1/jobs?limt=3")).await.problem(422, "invalid_request");
    assert_eq!(
        answer["detail"],
        "/limt: there is no such query parameter; expected `q`, `status`, `machine`, \
         `part_number`, `class`, `tag`, `from`, `to`, `sort`, `limit` or `cursor`."
    );
    app.stop().await;
}

/// Numbers that no computation survives are named where they were sent, with what to do.
#[tokio::test]
async fn values_that_exceed_double_precision_have_pointers() {
    let app = TestApp::start().await;
    let post = async |path: &str, body: &serde_json::Value| {
        let problem = send(app.post(path, body.to_string())).await.problem(422, "invalid_request");
        let fault = problem["errors"][0].clone();
        (fault["pointer"].as_str().unwrap().to_owned(), fault["detail"].as_str().unwrap().to_owned())
    };
    let example = |name: &str| -> serde_json::Value {
        let found = flankfit::api::examples::REQUEST_EXAMPLES.iter().find(|example| example.name == name).unwrap();
        serde_json::from_str(found.text).unwrap()
    };
    let piece = "/regularization/piece";
    for (place, value) in [("/lambda_star", 1e300), ("/scale/0", 5e-324)] {
        let mut body = example("fit_representative");
        *body.pointer_mut(&format!("{piece}{place}")).unwrap() = json!(value);
        let (pointer, detail) = post("/v1/fits", &body).await;
        assert_eq!(pointer, format!("{piece}{place}"), "{detail}");
        assert!(detail.contains("the range of double precision"), "{detail}");
    }
    let mut study = example("study_matrix");
    study["x"][0][0] = json!(1e300);
    let (pointer, detail) = post("/v1/studies/randomization", &study).await;
    assert_eq!(pointer, "/x", "{detail}");
    let mut mesh = example("gear_solid_mesh");
    mesh["elements"]["involute"] = json!(1u64 << 40);
    mesh["elements"]["width"] = json!(1u64 << 62);
    let (pointer, detail) = post("/v1/gears/solid-mesh", &mesh).await;
    assert_eq!(pointer, "/elements", "{detail}");
    assert!(detail.starts_with("more nodes than can be counted are requested"), "{detail}");
}

#[tokio::test]
async fn invalid_lists_of_lines_have_distinct_errors() {
    let app = TestApp::start().await;
    let fit = |line: serde_json::Value| {
        json!({"nodes": {"type": "curve", "x": [0, 1, 2, 3], "y": [1, 3.1, 4.9, 7.2]},
            "model": {"type": "polynomial", "degree": 1}, "folds": {"by": "lines", "line": line},
            "regularization": {"type": "ridge", "parameter": {"criterion": "blocked_cv"}}})
        .to_string()
    };
    assert_eq!(
        details(&app.fit(&fit(json!([1, 1, 1, 1]))).await),
        ["the counted nodes lie in fewer than two lines: cross-validation needs at least two"]
    );
    let message = "expected a whole number from -9223372036854775808 to 9223372036854775807, found 9223372036854775808";
    assert_eq!(details(&app.fit(&fit(json!([1u64 << 63, 1, 2, 3]))).await), [message]);
}

/// Too many coefficients are too many spans where spans were sent.
#[tokio::test]
async fn too_many_spans_are_spans() {
    let app = TestApp::start().await;
    let places: Vec<f64> = (0..50).map(f64::from).collect();
    for (spans, pointer) in [(json!([37, 37]), "/model/spans"), (json!(37), "/model/spans")] {
        let body = json!({"nodes": {"type": "grid", "u": places, "v": places, "z": vec![places.clone(); 50]},
            "model": {"type": "b_spline", "degree": 3, "spans": spans}});
        let problem = app.fit(&body.to_string()).await.problem(422, "invalid_request");
        assert_eq!(problem["errors"][0]["pointer"], pointer, "{problem}");
    }
}

#[tokio::test]
async fn one_is_one_and_no_type_of_rust_is_named() {
    let app = TestApp::start().await;
    let curve = r#""nodes":{"type":"curve","x":[0,1,2,3],"y":[1,3.1,4.9,7.2]}"#;
    let with = |part: &str| format!("{curve},{LINE},{part}");
    for (request, said) in [
        (format!(r#""nodes":{{"type":"curve","x":[0,1],"y":[1]}},{LINE}"#), "1 entry, but 2 would match x".to_owned()),
        (
            format!(r#""nodes":{{"type":"grid","u":[0,1],"v":[5],"z":[[1],[1,2]]}},{LINE}"#),
            "2 entries, but v has 1 position".to_owned(),
        ),
        (
            with(r#""regularization":{"type":"attraction","target":[1]}"#),
            "1 entry; the model has 2 coefficients, in the order of the result".to_owned(),
        ),
        (
            format!(
                r#""nodes":{{"type":"grid","u":[0,1],"v":[0,1],"z":[[1,2],[3,4]]}},{LINE},"regularization":{{"type":"tikhonov","order":1,"weights":[1]}}"#
            ),
            "1 weight; a surface takes two, [w_u, w_v]".to_owned(),
        ),
        (
            with(r#""estimator":{"type":"m_estimator","loss":"hampel","tuning":[1]}"#),
            "1 constant; hampel has three, a ≤ b < c".to_owned(),
        ),
        (
            with(r#""regularization":{"type":"truncated_svd","rank":-3}"#),
            "expected a whole number of at least 1, found -3".to_owned(),
        ),
        (
            with(r#""regularization":{"type":"truncated_svd","rank":"2"}"#),
            r#"expected a whole number of at least 1, found the string "2""#.to_owned(),
        ),
        (with(r#""noise_sigma":"x""#), r#"expected a number, found the string "x""#.to_owned()),
        (with(r#""include":"residuals""#), r#"expected an array, found the string "residuals""#.to_owned()),
        (with(r#""domain":{"u":[1]}"#), "expected an array of 2 entries, found 1 entry".to_owned()),
        (with(r#""domain":[[0,1]]"#), "expected an object, found an array".to_owned()),
        (with(r#""regularization":["none"]"#), "expected an object, found an array".to_owned()),
        (
            with(r#""scaling":5"#),
            "expected one of `unit_length`, `none`, `standardized` in quotes, found a number".to_owned(),
        ),
        (
            with(r#""scaling":"big""#),
            "`big` is not known; expected one of `unit_length`, `none`, `standardized`".to_owned(),
        ),
    ] {
        assert_eq!(details(&app.fit(&format!("{{{request}}}")).await), [said], "{request}");
    }
    let study = r#"{"x":[[1],[2]],"coefficients":[1],"noise_sigma":1,"levels":[0],"repetitions":1.5}"#;
    let answer = send(app.post("/v1/studies/randomization", study)).await;
    let wanted = "expected a whole number of at least 1 without decimal point and exponent, found 1.5";
    assert_eq!(details(&answer), [wanted]);
    // an array is no object, whatever it holds
    assert_eq!(send(app.post("/v1/jobs", r#"["wheel"]"#)).await.pointers(), [""]);
}

#[tokio::test]
async fn parts_of_the_url_are_called_by_their_names() {
    let app = TestApp::start().await;
    let id = "0190b0de-0000-7000-8000-000000000000";
    for (path, said) in [
        ("/v1/jobs/5".to_owned(), "its segment `5`, job_id, must be a UUID such as"),
        ("/v1/streams/x".to_owned(), "its segment `x`, stream_id, must be a UUID such as"),
        ("/v1/jobs/x/iterations/1".to_owned(), "its segment `x`, job_id, must be a UUID such as"),
        (format!("/v1/jobs/{id}/iterations/one"), "its segment `one` must be a whole number of at least 1"),
        (format!("/v1/jobs/{id}/iterations/01"), "write its segment `01` (number) as `1`"),
        (format!("/v1/jobs/{}/iterations/1", id.replace('-', "")), "(job_id) as `"),
        (format!("/v1/jobs/{id}/iterations/-1"), "its segment `-1` must be a whole number of at least 1"),
        (format!("/v1/jobs/{id}/iterations/99999999999"), "its segment `99999999999` must be a whole number"),
    ] {
        let body = send(app.get(&path)).await.problem(404, "not_found");
        assert!(body["detail"].as_str().unwrap().contains(said), "{path}: {body}");
    }
    for (query, pointer) in [
        ("limit=many", "/limit"),
        ("limit=-1", "/limit"),
        ("limit=2.0", "/limit"),
        ("limit=", "/limit"),
        ("limit=1&limit=2", "/limit"),
        ("offset=3", "/offset"),
        ("cursor=x", "/cursor"),
    ] {
        let answer = send(app.get(&format!("/v1/jobs?{query}"))).await;
        assert_eq!(answer.pointers(), [pointer], "{query}: {}", answer.text);
        assert!(!answer.text.contains("deserialize"), "{}", answer.text);
    }
    assert_eq!(send(app.get("/v1/jobs?limit=2")).await.status, 200);
    assert_eq!(send(app.get(&format!("/v1/jobs/{id}/events?since=1"))).await.pointers(), ["/since"]);
}

#[tokio::test]
async fn all_errors_of_a_gear_are_listed_and_names_are_clean() {
    let app = TestApp::start().await;
    let job = json!({"name": "w", "gear": {
        "teeth": 0, "normal_module_mm": -1, "helix_angle_deg": 120, "hand": "up", "colour": 1,
        "tool": {"tip_radius_mm": -1}
    }});
    let mut found = send(app.post("/v1/jobs", job.to_string())).await.pointers();
    found.sort_unstable();
    let colour = ["/gear/colour", "/gear/hand", "/gear/helix_angle_deg", "/gear/normal_module_mm", "/gear/teeth"];
    assert_eq!(found, [&colour[..], &["/gear/tool/tip_radius_mm"]].concat());
    for (body, pointer) in [
        (json!({"name": "a\u{0}b"}), "/name"),
        (json!({"name": "a\nb"}), "/name"),
        (json!({"name": "a\u{202e}b"}), "/name"),
        (json!({"name": "w", "machine": "\u{1b}[31m"}), "/machine"),
        (json!({"name": "w", "tags": {"a": "\u{7f}"}}), "/tags/a"),
        (json!({"name": "w", "tags": {"a\u{1}": "x"}}), "/tags"),
        (json!({"name": "w", "tags": (0..51).map(|i| (i.to_string(), "a")).collect::<serde_json::Value>()}), "/tags"),
    ] {
        assert_eq!(send(app.post("/v1/jobs", body.to_string())).await.pointers(), [pointer], "{body}");
    }
    let matrix = json!({
        "nodes": {"type": "matrix", "x": [[1, 2], [1, 3], [1, 5]], "y": [1, 2, 3], "names": ["one", "a\u{0}"]},
        "model": {"type": "linear"}
    });
    assert_eq!(app.fit(&matrix.to_string()).await.pointers(), ["/nodes/names/1"]);
}

#[tokio::test]
async fn numbers_near_1_have_no_exponent_and_others_have_one() {
    let app = TestApp::start().await;
    let spline = |weights: &str, at: &str| {
        format!(
            r#"{{"curve":{{"type":"nurbs","degree":1,"knots":[0,0,1,1],"control_points":[[0,0],[1,1]],"weights":{weights}}},"at":{at}}}"#
        )
    };
    let smoothing = r#"{"points":{"x":[0,1,1e300,27.2,30],"y":[0,1,2,1,0]},"method":{"type":"smoothing_spline","parameter":{"criterion":"gcv"}}}"#;
    for (path, request, said) in [
        ("evaluate", spline("[1,1]", "[1.5]"), "1.5 is not within the domain [0, 1]"),
        ("evaluate", spline("[1,-1]", "[0.5]"), "weight 1 (-1) is not a finite number ≥ 0"),
        ("", smoothing.to_owned(), "abscissa 3 (27.2) lies below the one before it (1e300)"),
    ] {
        let path = format!("/v1/curves/{path}");
        let answer = send(app.post(path.trim_end_matches('/'), request)).await;
        let details = details(&answer);
        assert!(details[0].starts_with(said), "{details:?}");
    }
    app.stop().await;
}
