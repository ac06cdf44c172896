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
    for name in ["fig4.svg", "fig5.svg"] {
        let made = std::fs::read_to_string(folder.path().join(name)).unwrap();
        let committed = std::fs::read_to_string(root.join("docs/figures").join(name)).unwrap();
        assert!(made == committed, "docs/figures/{name} differs; run flankfit study --svg docs/figures");
        assert!(!made.contains("NaN") && !made.contains("inf"), "{name}");
    }
    // what the table says stands in the document
    let best = text.lines().find(|line| line.starts_with("best level")).unwrap();
    let document = std::fs::read_to_string(root.join("docs/paper-figures.md")).unwrap();
    assert!(document.contains(best), "{best}");
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
