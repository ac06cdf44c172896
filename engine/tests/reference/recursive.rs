//! Recursive least squares node by node against exact prefixes.

use crate::answers::{at_least, curve, monomials, plain, values};
use crate::folder::{decimals, number, numbers, reference};
use flankfit_engine::estimation::spec::Model;
use flankfit_engine::estimation::{FitSpec, Nodes, Recursive};
use serde_json::Value;

/// Adds the nodes one by one and compares after each that is in the file.
fn prefixes(file: &Value, spec: &FitSpec, nodes: impl Fn(usize) -> Nodes) {
    let name = file["name"].as_str().expect("a name");
    let steps = file["steps"].as_array().expect("steps");
    let mut estimate = Recursive::new(spec, 1.0).expect("a spec for streams");
    let mut seen = 0;
    for step in steps {
        let k = number(&step["k"]) as usize;
        while seen < k {
            estimate.push(&nodes(seen)).expect("a node");
            seen += 1;
        }
        let result = estimate.result().expect("a fit").expect("enough nodes");
        let truth = decimals(&step["coef_dec"]);
        at_least(&format!("{name} after {k}"), &values(&result), &truth, 9.0);
        let rss = number(&step["rss"]);
        let heights = result.residuals.count as f64 * result.residuals.rms.max(1.0);
        assert!((result.residuals.rss - rss).abs() <= 1e-10 * rss.max(1e-10 * heights), "{name} after {k}: {rss}");
        assert_eq!(result.residuals.count, k);
    }
}

#[test]
fn longley_as_a_matrix() {
    let file = reference("rls_longley");
    let data = reference("nist_longley");
    let y = numbers(&data["data"]["y"]);
    let columns: Vec<Vec<f64>> = (1..=6).map(|j| numbers(&data["data"][format!("x{j}")])).collect();
    prefixes(&file, &plain(Model::Linear), |i| {
        let row: Vec<f64> = std::iter::once(1.0).chain(columns.iter().map(|column| column[i])).collect();
        Nodes::matrix(row.clone(), row.len(), vec![y[i]], None, None).expect("a row")
    });
}

#[test]
fn norris_as_a_curve_without_a_domain() {
    let file = reference("rls_norris");
    let data = reference("nist_norris");
    let (x, y) = (numbers(&data["data"]["x"]), numbers(&data["data"]["y"]));
    prefixes(&file, &plain(monomials(1)), |i| curve(&x[i..=i], &y[i..=i]));
}
