//! k of ridge by restricted likelihood, compared with scipy's and mgcv's.

use crate::folder::{number, numbers, reference};
use flankfit_engine::estimation::{
    FitSpec, Nodes, fit,
    spec::{Criterion, Model, Parameter, Regularization},
};

#[test]
fn hald() {
    let (data, file) = (reference("ridge_hald"), reference("reml_hald"));
    let y = numbers(&data["data"]["y"]);
    let columns: Vec<Vec<f64>> = (1..=4).map(|j| numbers(&data["data"][format!("x{j}")])).collect();
    let rows: Vec<f64> = (0..y.len()).flat_map(|k| columns.iter().map(move |c| c[k])).collect();
    let nodes = Nodes::matrix(rows, 4, y, None, None).unwrap();
    let regularization = Regularization::Ridge { parameter: Parameter::Criterion(Criterion::Reml) };
    for (sigma, truth) in [(None, &file["k"]), (Some(number(&file["sigma"])), &file["k_with_sigma"])] {
        let spec =
            FitSpec { regularization: regularization.clone(), noise_sigma: sigma, ..FitSpec::new(Model::Linear) };
        let k = fit(&nodes, &spec).unwrap().regularization.lambda_star.unwrap();
        // the reference minimises without derivatives
        assert!((k / number(truth) - 1.0).abs() < 1e-6, "{sigma:?}: {k}, in the reference {truth}");
    }
}
