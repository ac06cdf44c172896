//! Every estimator as a stored fit: iteration, refits, replay in another process.

use super::app::{TestApp, iteration};
use flankfit::api::{examples::REQUEST_EXAMPLES, jobs::iterations::IterationFitBody};
use serde_json::{Value, json};

/// The estimators of the documented examples.
fn estimators() -> Vec<Value> {
    REQUEST_EXAMPLES
        .iter()
        .map(|example| serde_json::from_str::<Value>(example.text).unwrap()["estimator"].clone())
        .filter(|estimator| estimator.is_object() && estimator["type"] != "least_squares")
        .collect()
}

#[tokio::test]
async fn every_estimator_is_stored_and_replayed_bit_by_bit() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let mut request = iteration();
    request["estimator"] = json!({"type": "m_estimator", "loss": "huber"});
    let added = app.post(&format!("{job}/iterations"), &request).await.expect(201);
    let place = added.header("location").unwrap().to_owned();
    let first = added.json()["fits"][0].clone();
    let mut fits = vec![first["id"].as_str().unwrap().to_owned()];
    let (mut digests, estimators) = (vec![first["result"]["provenance"]["input_sha256"].clone()], estimators());
    let kinds: std::collections::BTreeSet<_> = estimators.iter().map(|e| e["type"].as_str().unwrap()).collect();
    assert_eq!(
        Vec::from_iter(kinds),
        [
            "l_estimator",
            "least_absolute_deviations",
            "least_trimmed_squares",
            "lp",
            "m_estimator",
            "maximum_likelihood",
            "quantile",
            "rank"
        ]
    );
    for estimator in &estimators {
        let body = json!({"model": request["model"], "estimator": estimator, "include": ["robust_weights"],
            "reason": "peaks"});
        let refit = app.post(&format!("{place}/fits"), &body).await.expect(201);
        let documented: IterationFitBody = serde_json::from_str(&refit.text).unwrap();
        let refit = refit.json();
        // every field of the answer is documented
        assert_eq!(serde_json::to_value(documented).unwrap(), refit);
        let (result, robust) = (&refit["result"], &refit["result"]["robust"]);
        assert_eq!(robust["converged"], true, "{estimator}: {robust}");
        assert_eq!(
            robust["weights"].as_array().unwrap().len(),
            result["residuals"]["count"].as_u64().unwrap() as usize
        );
        assert_eq!(robust["coefficients"].as_array().unwrap().len(), result["coefficients"].as_array().unwrap().len());
        // −ln L has either sign
        let likely = estimator["type"] == "maximum_likelihood";
        assert!(likely || robust["objective"].as_f64().unwrap() > 0.0, "{robust}");
        assert!(robust["scale"].as_f64().unwrap() > 0.0, "{robust}");
        assert!(result["coefficients"][0]["std_error"].as_f64().unwrap() > 0.0, "{estimator}");
        if let Some(certificate) = robust["certificate"].as_f64() {
            assert!(certificate <= 1.0 + 1e-9, "{estimator}: {certificate}");
        }
        fits.push(refit["id"].as_str().unwrap().to_owned());
        digests.push(result["provenance"]["input_sha256"].clone());
    }
    assert!((1..digests.len()).all(|i| !digests[..i].contains(&digests[i])), "each is another input");
    app.restart().await;
    for fit in fits {
        let replay = app.post(&format!("{place}/fits/{fit}/replay"), &json!({})).await.expect(200);
        assert_eq!(replay.text, r#"{"identical":true}"#);
    }
    app.stop().await;
}

#[tokio::test]
async fn gross_peaks_are_rejected_and_named() {
    let mut app = TestApp::start().await;
    let example = REQUEST_EXAMPLES.iter().find(|example| example.name == "fit_m_estimator").unwrap();
    let answer = app.post("/v1/fits", &serde_json::from_str(example.text).unwrap()).await.expect(200).json();
    let robust = &answer["robust"];
    assert_eq!(robust["rejected"], json!([8, 10]));
    assert_eq!(robust["start"], "least_trimmed_squares");
    assert_eq!(robust["solution"], "from_start");
    // plain least squares is reported as well, and its residuals are the larger ones
    let both = |name: &str| answer["coefficients"][0][name].as_f64().unwrap();
    assert!((both("value") - both("least_squares")).abs() > 1e-6);
    let rss = |name: &str| answer["residuals"][name].as_f64().unwrap();
    assert!(rss("rss") > rss("least_squares_rss"));
    app.stop().await;
}
