//! Our side of `tools/compare_peers.py`: one whole fit of a grid, as often as asked.
//!
//! Run: `cargo run --release -p engine-benches --example compare_peers -- FOLDER WORK REPEATS`. The
//! folder holds little-endian doubles: `u`, `v`, `z` (v running fastest). Written are the
//! `coefficients`; printed are the seconds of each repetition as JSON.

mod timing;

use std::{path::Path, time::Instant};

use flankfit_engine::estimation::{
    FitSpec, Nodes, fit,
    spec::{
        Criterion, Degree, Estimator, Filter, FilterAxis, Gaussian, Knots, Model, Order, Parameter, PolynomialBasis,
        Regularization, Terms, Tikhonov,
    },
};
use serde_json::json;
use timing::{Outcome, read, timed, write};

/// Allocator of the HTTP service.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Seconds of one measurement at least.
const LEAST: f64 = 0.05;

/// Specification for a name: `tikhonov_gcv_12` is a surface of 12 + 3 bicubic B-splines each way.
fn spec(work: &str) -> Option<FitSpec> {
    let chebyshev = || {
        let (degree, basis, terms) = (Degree::Both(3), PolynomialBasis::Chebyshev, Terms::Tensor);
        FitSpec::new(Model::Polynomial { degree, basis, terms })
    };
    let smooth = |spans: &str, parameter| {
        let knots = Knots::Spans(spans.parse().ok()?);
        let regularization = Regularization::Tikhonov(Tikhonov { order: 2, weights: None, parameter });
        let model = Model::BSpline { degree: Degree::Both(3), knots, weights: None };
        Some(FitSpec { regularization, ..FitSpec::new(model) })
    };
    if let Some(spans) = work.strip_prefix("tikhonov_gcv_") {
        return smooth(spans, Parameter::Criterion(Criterion::Gcv));
    }
    if let Some(spans) = work.strip_prefix("tikhonov_given_") {
        return smooth(spans, Parameter::Fixed(1e-3));
    }
    Some(match work {
        "rank" => FitSpec { estimator: Estimator::Rank, ..chebyshev() },
        "least_absolute_deviations" => FitSpec { estimator: Estimator::LeastAbsolute, ..chebyshev() },
        "least_trimmed_squares" => {
            FitSpec { estimator: Estimator::LeastTrimmed { coverage: 0.5, seed: 0 }, ..chebyshev() }
        }
        "robust_gaussian" => {
            let gaussian = Gaussian { axis: Some(FilterAxis::V), cutoff: 3.0, robust: Some(Order::Two) };
            FitSpec { filters: vec![Filter::Gaussian(gaussian)], ..chebyshev() }
        }
        _ => return None,
    })
}

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, work, repeats] = &arguments[..] else { return Err("three arguments: FOLDER WORK REPEATS".into()) };
    let folder = Path::new(folder);
    let nodes = Nodes::grid(read(folder, "u")?, read(folder, "v")?, read(folder, "z")?, None, None)?;
    let spec = spec(work).ok_or("no such work")?;
    // the system counts processor time in steps of some milliseconds: short work is done more often
    let start = Instant::now();
    fit(&nodes, &spec)?;
    let batch = (LEAST / start.elapsed().as_secs_f64()).ceil().clamp(1.0, 1000.0) as usize;
    let (found, seconds) = timed(repeats.parse()?, batch, || Ok(fit(&nodes, &spec)?))?;
    let coefficients: Vec<f64> = found.coefficients.iter().map(|c| c.value).collect();
    write(folder, "coefficients", &coefficients)?;
    println!(
        "{}",
        json!({"seconds": seconds, "robust": found.robust.map(|r| json!({
        "iterations": r.iterations, "certificate": r.certificate, "objective": r.objective}))})
    );
    Ok(())
}
