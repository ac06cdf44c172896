//! A chain of iterations against a Kalman filter in covariance form with 50 digits.

use std::sync::Arc;

use crate::answers::{answer, at_least, curve, monomials, plain, values};
use crate::folder::{decimals, number, numbers, reference, table};
use flankfit_engine::estimation::{
    FitResult, FitSpec,
    result::PriorReport,
    spec::{Chain, Corrected, Earlier, Include, Moves, Prior, Which},
};
use serde_json::Value;

fn chained(file: &Value, moves: Moves) -> FitResult {
    let of = |k: usize, heights: &str| {
        let one = &file["iterations"][k];
        Arc::new(curve(&numbers(&one["x"]), &numbers(&one[heights])))
    };
    let earlier = |k: usize| {
        let correction =
            || Corrected { iteration: 2, record_id: "record".to_owned(), entered: None, change: of(k, "change") };
        Earlier {
            number: k as u32 + 1,
            fit_id: format!("fit {k}"),
            nodes: of(k, "y"),
            corrections: if k == 1 { vec![correction()] } else { vec![] },
        }
    };
    let earlier = Some((0..3).map(earlier).collect());
    let chain = Chain { which: Which::Previous, moves, correction: true, earlier };
    let include = Include { covariance: true, ..Include::default() };
    answer(&of(3, "y"), &FitSpec { prior: Some(Prior::Iterations(chain)), include, ..plain(monomials(3)) })
}

#[track_caller]
fn near(what: &str, got: f64, truth: f64) {
    assert!((got - truth).abs() <= 1e-10 * truth.abs(), "{what}: {got:e}, in the reference {truth:e}");
}

fn agrees(file: &Value, truth: &Value, result: &FitResult) -> PriorReport {
    let prior = result.prior.clone().expect("there is one");
    near("sigma", prior.sigma.expect("estimated"), number(&file["sigma"]));
    assert_eq!(prior.degrees_of_freedom.map(|f| f as f64), Some(number(&file["degrees_of_freedom"])));
    at_least("value", &values(result), &decimals(&truth["value_dec"]), 11.0);
    let errors = result.coefficients.iter().map(|c| c.std_error.expect("an error"));
    let listed = |name: &str| numbers(&truth[name]);
    errors.zip(listed("std_error")).for_each(|(got, truth)| near("std_error", got, truth));
    prior.share.iter().zip(listed("share")).for_each(|(&got, truth)| near("share", got, truth));
    let covariance = result.covariance.as_ref().expect("included").coefficients.concat();
    let slack = 1e-10 * covariance.iter().fold(0.0f64, |most, c| most.max(c.abs()));
    for (got, truth) in covariance.iter().zip(table(&truth["covariance"]).concat()) {
        assert!((got - truth).abs() < slack, "{got:e} {truth:e}");
    }
    let conflict = prior.conflict.expect("judged from the third iteration on");
    near("statistic", conflict.statistic, number(&truth["statistic"]));
    near("p", conflict.p, number(&truth["p"]));
    assert!(!conflict.dropped);
    prior
}

#[test]
fn a_chain_with_moves_that_it_estimates() {
    let file = reference("prior_chain");
    let result = chained(&file, Moves::Estimated);
    let prior = agrees(&file, &file["estimated"], &result);
    // parts of less than a millionth are left out
    for (c, truth) in result.coefficients.iter().zip(table(&file["estimated"]["intervals"])) {
        let ends = c.interval.expect("there is noise").ends;
        let slack = 1e-5 * (truth[1] - truth[0]);
        assert!(ends.iter().zip(&truth).all(|(got, truth)| (got - truth).abs() < slack), "{ends:?} {truth:?}");
    }
    near("ratio", prior.move_ratio.expect("estimated"), number(&file["estimated"]["move_ratio"]));
    assert_eq!((prior.iterations, prior.corrections.len()), (Some(vec![1, 2, 3]), 1));
}

#[test]
fn a_chain_with_given_moves() {
    let file = reference("prior_chain");
    let deviations = numbers(&file["move_std_error"]);
    let prior = agrees(&file, &file["given"], &chained(&file, Moves::StdError(deviations.clone())));
    assert_eq!((prior.move_std_error, prior.move_ratio), (Some(deviations), None));
}
