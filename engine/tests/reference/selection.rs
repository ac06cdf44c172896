//! Terms of a linear model, compared with R's leaps, step and glmnet.

use crate::folder::{number, numbers, reference, table};
use flankfit_engine::estimation::{
    FitResult, FitSpec, Nodes, fit,
    result::Selection,
    spec::{Candidates, Folds, FoldsBy, Model, ModelCriterion, Regularization, Select, TermSearch},
};
use serde_json::Value;

fn nodes(file: &Value) -> Nodes {
    let rows: Vec<f64> = table(&file["x"]).into_iter().flat_map(|row| std::iter::once(1.0).chain(row)).collect();
    let y = numbers(&file["y"]);
    Nodes::matrix(rows, 6, y, None, None).unwrap()
}

fn select(nodes: &Nodes, search: TermSearch, criterion: ModelCriterion, folds: usize) -> FitResult {
    let spec = FitSpec {
        regularization: Regularization::None,
        select: Some(Select::new(Candidates::Terms(search), criterion)),
        folds: Some(Folds { by: FoldsBy::Rows, count: Some(folds) }),
        ..FitSpec::new(Model::Linear)
    };
    fit(nodes, &spec).unwrap()
}

fn selection(result: FitResult) -> Selection {
    result.selection.unwrap()
}

/// The names of columns, of which the first is the constant.
fn terms(columns: &Value) -> Vec<String> {
    let columns = columns.as_array().unwrap().iter().map(|column| column.as_u64().unwrap());
    std::iter::once(0).chain(columns).map(|column| format!("x{column}")).collect()
}

#[track_caller]
fn close(what: &str, found: f64, truth: &Value, tolerance: f64) {
    let truth = number(truth);
    assert!((found - truth).abs() <= tolerance * truth.abs(), "{what}: {found}, in the reference {truth}");
}

#[test]
fn backward_elimination() {
    let file = reference("selection_swiss");
    let found = selection(select(&nodes(&file), TermSearch::Backward, ModelCriterion::Bic, 47));
    let models = file["backward"].as_array().unwrap();
    assert_eq!(found.candidates.len(), models.len());
    for (candidate, model) in found.candidates.iter().zip(models) {
        assert_eq!(candidate.terms, Some(terms(&model["columns"])));
        close("rss", candidate.rss, &model["rss"], 1e-12);
        close("aic", candidate.aic.unwrap(), &model["aic"], 1e-12);
        close("bic", candidate.bic.unwrap(), &model["bic"], 1e-12);
        close("press", candidate.press.unwrap(), &model["press"], 1e-12);
        // blocks of single rows
        close("blocked_cv", candidate.blocked_cv.unwrap(), &model["press"], 1e-12);
    }
    assert_eq!(found.candidates[found.chosen].terms, Some(terms(&file["step_bic"])));
}

#[test]
fn elastic_net() {
    let file = reference("selection_swiss");
    let nodes = nodes(&file);
    for net in file["nets"].as_array().unwrap() {
        let search = TermSearch::ElasticNet { alpha: number(&net["alpha"]) };
        let result = select(&nodes, search, ModelCriterion::BlockedCv, 10);
        let fitted: Vec<String> = result.coefficients.iter().map(|c| c.term.clone()).collect();
        let found = selection(result);
        let (lambda, error) = (numbers(&net["lambda"]), numbers(&net["error"]));
        let kept: Vec<Vec<String>> = net["kept"].as_array().unwrap().iter().map(terms).collect();
        let mut met = Vec::new();
        for terms in &kept {
            if !met.contains(terms) {
                met.push(terms.clone());
            }
        }
        let candidates: Vec<Vec<String>> = found.candidates.iter().map(|c| c.terms.clone().unwrap()).collect();
        assert_eq!(candidates, met);
        for candidate in &found.candidates {
            // the best λ of those that keep these terms
            let best = (0..lambda.len())
                .filter(|&k| Some(&kept[k]) == candidate.terms.as_ref())
                .min_by(|&i, &j| error[i].total_cmp(&error[j]))
                .unwrap();
            assert!((candidate.lambda.unwrap() / lambda[best] - 1.0).abs() < 1e-9);
            assert!((candidate.blocked_cv.unwrap() / error[best] - 1.0).abs() < 1e-8);
        }
        let least = (0..lambda.len()).min_by(|&i, &j| error[i].total_cmp(&error[j])).unwrap();
        assert_eq!(fitted, kept[least]);
    }
}
