//! Coverage of intervals of constrained fits, and the gain by the constraint: the table of
//! docs/explanation/constraints.md.
//!
//! 25 nodes over [0, 1], noise 0.2; a cubic or a cubic spline of four spans has to rise. `cargo run
//! --release -p engine-benches --example constraint_coverage -- 4000` draws 4000 times each.

#[expect(dead_code, reason = "the oracle is shared with the tests, which use all of it")]
#[path = "../../../engine/tests/oracle/mod.rs"]
mod oracle;

use flankfit_engine::estimation::{
    FitSpec, Nodes, fit,
    spec::{
        Constraint, ConstraintKind, Degree, Domain, Kinds, Knots, Model, Places, PolynomialBasis, Predict,
        Regularization, Terms,
    },
};
use oracle::random::Random;

const NODES: usize = 25;
const NOISE: f64 = 0.2;

fn place(k: usize) -> f64 {
    k as f64 / (NODES - 1) as f64
}

/// A true height, by its abscissa.
type Truth = fn(f64) -> f64;

const TRUTHS: [(&str, Truth); 4] = [
    ("a level", |_| 1.0),
    ("level, then rising", |x| 2.0 * (x - 0.5).max(0.0).powi(2)),
    ("rising by 5 noises", |x| x),
    ("rising by 25 noises", |x| 5.0 * x),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let draws: usize = std::env::args().nth(1).map_or(Ok(1000), |text| text.parse())?;
    let cubic = Model::Polynomial { degree: Degree::Both(3), basis: PolynomialBasis::Chebyshev, terms: Terms::Tensor };
    let spline = Model::BSpline { degree: Degree::Both(3), knots: Knots::Spans(4), weights: None };
    println!("{draws} draws; heights at the nodes\n");
    println!(
        "| truth | model | active | `confidence` holds: mean, worst | value ± t · std_error: mean, worst | squared \
         error over least squares' |"
    );
    println!("|---|---|---|---|---|---|");
    for (name, truth) in TRUTHS {
        for (kind, model) in [("cubic", &cubic), ("spline", &spline)] {
            row(draws, name, truth, kind, model)?;
        }
    }
    Ok(())
}

fn row(draws: usize, name: &str, truth: Truth, kind: &str, model: &Model) -> Result<(), Box<dyn std::error::Error>> {
    let x: Vec<f64> = (0..NODES).map(place).collect();
    let rising = Constraint { kind: ConstraintKind::Increasing, along: None, domain: None };
    let predict = Predict { at: Places::Curve(x.clone()), level: None, kinds: Kinds::default(), slopes: false };
    let plain = FitSpec {
        regularization: Regularization::None,
        domain: Some(Domain { u: Some([0.0, 1.0]), v: None }),
        predict: Some(predict),
        ..FitSpec::new(model.clone())
    };
    let held = FitSpec { constraints: vec![rising], ..plain.clone() };
    let mut random = Random::new(17);
    let (mut hits, mut naive) = (vec![0.0; NODES], vec![0.0; NODES]);
    let (mut error, mut plain_error, mut active) = (0.0, 0.0, 0);
    for _ in 0..draws {
        let y: Vec<f64> = x.iter().map(|&x| truth(x) + NOISE * random.normal()).collect();
        let nodes = Nodes::curve(x.clone(), y, None)?;
        let (least, found) = (fit(&nodes, &plain)?, fit(&nodes, &held)?);
        active += usize::from(found.constraints.ok_or("constrained")?.holds_back());
        let (least, found) = (least.predictions.ok_or("places")?, found.predictions.ok_or("places")?);
        let (bands, errors) = (found.confidence.ok_or("noise")?, found.std_error.ok_or("noise")?);
        let plain_errors = least.std_error.ok_or("noise")?;
        for k in 0..NODES {
            let (truth, [low, high]) = (truth(x[k]), bands[k]);
            hits[k] += f64::from(u8::from(low <= truth && truth <= high)) / draws as f64;
            let t = 0.5 * (high - low) / plain_errors[k];
            let inside = (found.value[k] - truth).abs() <= t * errors[k];
            naive[k] += f64::from(u8::from(inside)) / draws as f64;
            error += (found.value[k] - truth).powi(2);
            plain_error += (least.value[k] - truth).powi(2);
        }
    }
    let figures = |shares: &[f64]| {
        let least = shares.iter().copied().fold(1.0, f64::min);
        format!("{:.3}, {least:.3}", shares.iter().sum::<f64>() / NODES as f64)
    };
    let share = active as f64 / draws as f64;
    println!(
        "| {name} | {kind} | {share:.2} | {} | {} | {:.2} |",
        figures(&hits),
        figures(&naive),
        error / plain_error
    );
    Ok(())
}
