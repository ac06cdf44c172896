//! James–Stein: the batting averages of Efron and Morris, and Hald's cement; ridge by closed forms.

use crate::answers::{answer, at_least, matrix, values};
use crate::folder::{decimals, number, numbers, reference};
use flankfit_engine::estimation::FitResult;
use flankfit_engine::estimation::spec::{
    ChosenBy, Criterion, FitSpec, JamesStein, Model, Parameter, Regularization, Scaling, ShrinkageFactor,
};

fn james_stein(factor: ShrinkageFactor, target: Option<Vec<f64>>, scaling: Scaling) -> FitSpec {
    let regularization = Regularization::JamesStein(JamesStein { factor, positive_part: true, target });
    FitSpec { scaling, regularization, ..FitSpec::new(Model::Linear) }
}

fn hald() -> (Vec<Vec<f64>>, Vec<f64>) {
    let data = reference("ridge_hald")["data"].clone();
    let columns: Vec<Vec<f64>> = (1..=4).map(|j| numbers(&data[format!("x{j}")])).collect();
    let y = numbers(&data["y"]);
    let row = |k: usize| std::iter::once(1.0).chain(columns.iter().map(move |c| c[k])).collect();
    ((0..y.len()).map(row).collect(), y)
}

#[track_caller]
fn near(what: &str, got: f64, truth: f64, slack: f64) {
    assert!((got - truth).abs() <= slack * truth.abs(), "{what}: {got:e}, in the reference {truth:e}");
}

fn factor(result: &FitResult) -> f64 {
    result.regularization.shrinkage_factor.expect("a factor")
}

/// Slopes toward 0 with the constant free, by both factors, and the whole vector toward 0.
#[test]
fn hald_toward_zero() {
    let (file, (x, y)) = (reference("james_stein_regression_hald"), hald());
    let nodes = matrix(&x, &y);
    for (name, shrinkage) in
        [("factor_stein", ShrinkageFactor::JamesStein), ("factor_s2", ShrinkageFactor::HoerlKennard)]
    {
        let truth = &file[name];
        let result = answer(&nodes, &james_stein(shrinkage, None, Scaling::Standardized));
        near(name, factor(&result), number(&truth["factor"]), 1e-13);
        at_least(name, &values(&result)[1..], &decimals(&truth["slopes_dec"]), 11.0);
        near("intercept", values(&result)[0], number(&truth["intercept"]), 1e-12);
    }
    // the grand mean as the target of unscaled columns is the same estimate
    let truth = &file["factor_stein"];
    for scaling in [Scaling::UnitLength, Scaling::None] {
        let result = answer(&nodes, &james_stein(ShrinkageFactor::EfronMorris, None, scaling));
        near("Efron–Morris", factor(&result), number(&truth["factor"]), 1e-12);
        at_least("Efron–Morris", &values(&result)[1..], &decimals(&truth["slopes_dec"]), 11.0);
        near("intercept", values(&result)[0], number(&truth["intercept"]), 1e-11);
    }
    let truth = &file["factor_full_vector"];
    for target in [None, Some(vec![0.0; 5])] {
        let result = answer(&nodes, &james_stein(ShrinkageFactor::JamesStein, target, Scaling::UnitLength));
        near("full vector", factor(&result), number(&truth["factor"]), 1e-13);
        at_least("full vector", &values(&result), &decimals(&truth["coef_dec"]), 11.0);
    }
}

/// Eighteen players, one node each: σ is known, the target is their mean.
#[test]
fn batting_averages() {
    let file = reference("james_stein_baseball");
    let players = 18;
    let identity: Vec<Vec<f64>> =
        (0..players).map(|i| (0..players).map(|j| f64::from(u8::from(i == j))).collect()).collect();
    let hits: Vec<f64> = numbers(&file["data"]["hits_in_45"]).iter().map(|h| h / 45.0).collect();
    let rounded = numbers(&file["data"]["y_printed_3_decimals"]);
    let cases = [
        ("binomial_exact_hits/45", hits, "sigma2=ybar(1-ybar)/45", "shrink_factor_c=1-(k-3)sigma2/S", "estimates_dec"),
        ("binomial_3_decimal_y", rounded, "sigma2=ybar(1-ybar)/45", "shrink_factor_c=1-(k-3)sigma2/S", "estimates_dec"),
        ("arcsine_exact", numbers(&file["arcsine_exact"]["x"]), "", "shrink_factor", "estimates_x_dec"),
    ];
    for (name, y, variance, shrink, estimates) in cases {
        let truth = &file[name];
        let noise = if variance.is_empty() { 1.0 } else { number(&truth[variance]).sqrt() };
        let spec = FitSpec {
            noise_sigma: Some(noise),
            ..james_stein(ShrinkageFactor::EfronMorris, None, Scaling::UnitLength)
        };
        let result = answer(&matrix(&identity, &y), &spec);
        near(name, factor(&result), number(&truth[shrink]), 1e-12);
        at_least(name, &values(&result), &decimals(&truth[estimates]), 13.0);
        // the constant as a column of its own, left unpenalised: mean and differences from the last
        // player
        let coded: Vec<Vec<f64>> =
            identity.iter().map(|row| [vec![1.0], row[..players - 1].to_vec()].concat()).collect();
        let spec = FitSpec { scaling: Scaling::Standardized, ..spec };
        let coded = answer(&matrix(&coded, &y), &spec);
        near(name, factor(&coded), number(&truth[shrink]), 1e-11);
        let fitted: Vec<f64> = values(&coded);
        let players: Vec<f64> = fitted[1..].iter().map(|b| fitted[0] + b).chain(std::iter::once(fitted[0])).collect();
        at_least(name, &players, &decimals(&truth[estimates]), 11.0);
    }
}

/// k of Hoerl, Kennard and Baldwin and of Lawless and Wang, in both forms of scaling.
#[test]
fn closed_forms_for_ridge() {
    let (file, (x, y)) = (reference("ridge_hald"), hald());
    let truth = &file["exact"];
    let nodes = matrix(&x, &y);
    let by = |criterion| Regularization::Ridge { parameter: Parameter::Criterion(criterion) };
    let cases = [
        (Criterion::Hkb, "hkb_mass_(p-2)s2/b'b"),
        (Criterion::LawlessWang, "lw_mass_(p-2)s2 n/|fit|^2"),
        (Criterion::Hkb1975, "hkb_1975_lambda_p s2/b'b"),
    ];
    for (criterion, name) in cases {
        let spec =
            FitSpec { scaling: Scaling::Standardized, regularization: by(criterion), ..FitSpec::new(Model::Linear) };
        let result = answer(&nodes, &spec);
        let k = result.regularization.lambda_star.expect("a parameter");
        near(name, k, number(&truth[name]), 1e-10);
        assert_eq!(result.regularization.criterion, Some(ChosenBy::Criterion(criterion)));
        let choice = result.regularization.choices.iter().find(|c| c.criterion == ChosenBy::Criterion(criterion));
        assert_eq!(choice.and_then(|c| c.lambda_star), Some(k));
    }
    // centred columns of unit length: the correlation form, k smaller by the number of nodes
    let m = y.len() as f64;
    let means: Vec<f64> = (0..5).map(|j| x.iter().map(|row| row[j]).sum::<f64>() / m).collect();
    let height = y.iter().sum::<f64>() / m;
    let centred: Vec<Vec<f64>> = x.iter().map(|row| (1..5).map(|j| row[j] - means[j]).collect()).collect();
    let nodes = matrix(&centred, &y.iter().map(|y| y - height).collect::<Vec<f64>>());
    let sigma = number(&truth["ols_residual_sd"]);
    let spec =
        FitSpec { regularization: by(Criterion::Hkb1975), noise_sigma: Some(sigma), ..FitSpec::new(Model::Linear) };
    let k = answer(&nodes, &spec).regularization.lambda_star.expect("a parameter");
    near("correlation form", k, number(&truth["hkb_1975_k_correlation_form"]), 1e-10);
}

/// Every point of the trace is the fit with that k; the path of the reference lies on it.
#[test]
fn the_trace_runs_through_the_fits() {
    let (file, (x, y)) = (reference("ridge_hald"), hald());
    let nodes = matrix(&x, &y);
    let fixed = |k: f64| {
        let mut spec = FitSpec {
            scaling: Scaling::Standardized,
            regularization: Regularization::Ridge { parameter: Parameter::Fixed(k) },
            ..FitSpec::new(Model::Linear)
        };
        spec.include.ridge_trace = true;
        spec
    };
    for step in file["path"].as_array().expect("a path") {
        let lambda = number(&step["lambda"]);
        let trace = answer(&nodes, &fixed(lambda.max(1e-9))).ridge_trace.expect("a trace");
        assert_eq!(trace[0].k, 0.0);
        assert!(trace.windows(2).all(|pair| pair[0].k < pair[1].k) && trace.len() > 50);
        let point = trace.iter().find(|point| point.k == lambda).expect("the k asked for");
        at_least(&format!("k = {lambda}"), &point.coefficients, &decimals(&step["coef_dec"]), 9.0);
    }
}
