//! `flankfit study` as a user runs it, and the committed figures.

use std::{
    path::Path,
    process::{Command, Output},
};

fn study(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_flankfit")).arg("study").args(arguments).output().unwrap()
}

#[test]
fn the_committed_figures_are_what_the_command_makes() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().unwrap();
    let output = study(&["--svg", folder.path().to_str().unwrap()]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{text}\n{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stderr.is_empty(), "where there is no terminal there is no progress bar");
    for name in ["fig4.svg", "fig5.svg"] {
        let made = std::fs::read_to_string(folder.path().join(name)).unwrap();
        let committed = std::fs::read_to_string(root.join("docs/figures").join(name)).unwrap();
        assert!(made == committed, "docs/figures/{name} differs; run flankfit study --svg docs/figures");
        assert!(!made.contains("NaN") && !made.contains("inf"), "{name}");
    }
    // what the tables say stands in the document
    let document = std::fs::read_to_string(root.join("docs/paper-figures.md")).unwrap();
    let mut said = 0;
    for line in text.lines().skip_while(|line| !line.contains("B of level k")).filter(|line| !line.contains("─")) {
        assert!(document.contains(line.trim()), "{line}");
        said += usize::from(!line.is_empty());
    }
    assert_eq!(said, 1 + 18 + 3, "heads, levels, the best one, the plateau, the least condition on it");
}

/// Section 6.3: about 5 times more accurate, a condition about 1e9 times less.
#[test]
fn the_default_study_reaches_the_papers_figures() {
    let body: serde_json::Value = serde_json::from_slice(&study(&["--json"]).stdout).unwrap();
    let level = body["levels"].as_array().unwrap().iter().find(|level| level["level"] == 2e-5).unwrap();
    let reference = &body["references"]["least_squares"];
    let ratio = |field: &str| reference[field]["median"].as_f64().unwrap() / level[field]["median"].as_f64().unwrap();
    assert!((4.2..5.5).contains(&ratio("bias_norm_squared").sqrt()), "{}", ratio("bias_norm_squared").sqrt());
    assert!((8e8..9e8).contains(&ratio("condition")), "{}", ratio("condition"));
    assert!((1.25..1.4).contains(&ratio("rss").recip()), "{}", ratio("rss"));
    // and the caveat: A lies along V₁, the error is A itself
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    assert!((number(&body["along_smallest"]) - 0.9998).abs() < 5e-5);
    let left = number(&level["bias_norm_squared"]["median"]) / number(&body["coefficient_norm_squared"]);
    assert!((left - 1.0).abs() < 1e-3, "{left}");
    // the plateau holds that level, and B of a level has less error than noise of the same
    let [low, high] = [0, 1].map(|at| number(&body["optimum"]["plateau"][at]));
    assert!(low < 2e-5 && 2e-5 < high);
    let calm = &body["optimum"]["least_condition"];
    assert!(number(&calm["condition_ratio"]) >= ratio("condition") && number(&calm["level"]) == high);
    let small = body["levels"].as_array().unwrap().iter().find(|level| level["level"] == 3e-9).unwrap();
    let error = |figures: &serde_json::Value| number(&figures["bias_norm_squared"]["median"]);
    assert!(error(&small["matrix_b"]) < error(small));
}

#[test]
fn a_study_of_ones_own() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/requests/study_matrix.json");
    let output = study(&[file.to_str().unwrap(), "--json"]);
    let body: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(body["levels"].as_array().unwrap().len(), 5);
    let folder = tempfile::tempdir().unwrap();
    let broken = folder.path().join("broken.json");
    std::fs::write(&broken, r#"{"x":[[1]],"levels":[0.1],"repetitions":1}"#).unwrap();
    let output = study(&[broken.to_str().unwrap()]);
    assert!(!output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("/coefficients"));
    assert!(!study(&["/no/such/file.json"]).status.success());
}
