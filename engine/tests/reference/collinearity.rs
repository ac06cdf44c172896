//! Belsley, Kuh and Welsch on Longley's data.

use crate::answers::{answer, matrix, plain};
use crate::folder::{numbers, reference, table};
use flankfit_engine::estimation::spec::{FitSpec, Include, Model};

#[test]
fn longley() {
    let (file, heights) = (reference("collinearity_longley"), reference("nist_longley"));
    let columns: Vec<Vec<f64>> = (1..=6).map(|j| numbers(&file["data"][format!("x{j}")])).collect();
    let y = numbers(&heights["data"]["y"]);
    let x: Vec<Vec<f64>> =
        (0..y.len()).map(|k| std::iter::once(1.0).chain(columns.iter().map(|c| c[k])).collect()).collect();
    let include = Include { collinearity: true, ..Include::default() };
    let result = answer(&matrix(&x, &y), &FitSpec { include, ..plain(Model::Linear) });
    let report = &result.collinearity;
    let near = |a: f64, b: f64, slack: f64| (a - b).abs() <= slack * b.abs();

    let singular = numbers(&file["singular_values"]);
    let indices = numbers(&file["condition_indices"]);
    let n = singular.len();
    for (i, eigenvalue) in result.spectrum.eigenvalues.iter().enumerate() {
        // The file lists the largest first.
        let k = n - 1 - i;
        assert!(near(*eigenvalue, singular[k] * singular[k], 1e-10), "{eigenvalue:e} {:e}", singular[k]);
        let index = (result.spectrum.eigenvalues[n - 1] / eigenvalue).sqrt();
        assert!(near(index, indices[k], 1e-10));
    }
    let per_eigenvalue = table(&file["variance_proportions"]);
    let per_term = report.variance_proportions.as_ref().expect("asked for");
    for j in 0..n {
        for i in 0..n {
            let (got, truth) = (per_term[j][i], per_eigenvalue[n - 1 - i][j]);
            assert!((got - truth).abs() <= 1e-9 * truth + 1e-12, "term {j}, eigenvalue {i}: {got:e} {truth:e}");
        }
    }
    assert_eq!(report.columns[0].vif, None, "the constant has no vif");
    for (column, truth) in report.columns[1..].iter().zip(numbers(&file["vif"])) {
        assert!(near(column.vif.expect("a vif"), truth, 1e-9), "{}: {:?} {truth}", column.term, column.vif);
    }
    // Indices 43275, 6280, 1049, 228 and so on: those above 30 are near dependencies, the worst
    // first.
    let beyond: Vec<f64> = indices.iter().rev().copied().filter(|index| *index > 30.0).collect();
    assert!(report.near_dependencies.len() >= beyond.len());
    for (found, index) in report.near_dependencies.iter().zip(&beyond) {
        assert!(near(found.condition_index.expect("an index"), *index, 1e-9), "{:?} {index}", found.condition_index);
    }
}
