//! Influence of each observation of Hald's cement, compared with statsmodels' and R's.

use crate::folder::{number, numbers, reference};
use flankfit_engine::estimation::{
    FitSpec, Nodes, fit,
    spec::{Include, Model, Regularization},
};

#[track_caller]
fn near(what: &str, got: impl IntoIterator<Item = Option<f64>>, want: &[f64], slack: f64) {
    let got: Vec<f64> = got.into_iter().map(|x| x.unwrap_or_else(|| panic!("{what}: there is none"))).collect();
    assert_eq!(got.len(), want.len(), "{what}");
    for (got, want) in got.iter().zip(want) {
        assert!((got - want).abs() <= slack * want.abs().max(1.0), "{what}: {got:e}, in the reference {want:e}");
    }
}

#[test]
fn hald() {
    let (data, file) = (reference("ridge_hald"), reference("influence_hald"));
    let y = numbers(&data["data"]["y"]);
    let columns: Vec<Vec<f64>> = (1..=4).map(|j| numbers(&data["data"][format!("x{j}")])).collect();
    let rows: Vec<f64> =
        (0..y.len()).flat_map(|k| std::iter::once(1.0).chain(columns.iter().map(move |c| c[k]))).collect();
    for (name, weight) in [("plain", None), ("weighted", Some(numbers(&file["weight"])))] {
        let nodes = Nodes::matrix(rows.clone(), 5, y.clone(), None, weight).unwrap();
        let spec = FitSpec {
            regularization: Regularization::None,
            include: Include { influence: true, ..Include::default() },
            ..FitSpec::new(Model::Linear)
        };
        let found = fit(&nodes, &spec).unwrap().influence.unwrap();
        let truth = &file[name];
        near("leverage", found.leverage.iter().map(|&h| Some(h)), &numbers(&truth["leverage"]), 1e-13);
        for (what, got) in [
            ("internally_studentized", found.internally_studentized.unwrap()),
            ("externally_studentized", found.externally_studentized.unwrap()),
            ("cooks_distance", found.cooks_distance.unwrap()),
            ("dffits", found.dffits.unwrap()),
            ("press_residual", found.press_residual),
        ] {
            near(what, got, &numbers(&truth[what]), 1e-11);
        }
        near("press", [found.press], &[number(&truth["press"])], 1e-11);
    }
}
