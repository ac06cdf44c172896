//! How often intervals hold where errors are not white: the table of docs/errors.md.
//!
//! A cubic at 60 nodes whose coefficients are all 0. `cargo run --release -p flankfit-engine
//! --example errors_coverage -- 2000` draws 2,000 times each.

#[expect(dead_code, reason = "the oracle is shared with the tests, which use all of it")]
#[path = "../tests/oracle/mod.rs"]
mod oracle;

use flankfit_engine::estimation::{
    FitSpec, Nodes, fit,
    spec::{Along, Correlation, Degree, Errors, Model, PolynomialBasis, Regularization, Terms, Variance},
};
use oracle::random::Random;

const COUNT: usize = 60;

/// Coverage of all intervals and of the worst coefficient's, and their mean width.
fn coverage(
    spec: &FitSpec,
    draws: usize,
    noise: &dyn Fn(&mut Random) -> Vec<f64>,
) -> Result<(f64, f64, f64), Box<dyn std::error::Error>> {
    let mut random = Random::new(2026);
    let x: Vec<f64> = (0..COUNT).map(|i| i as f64).collect();
    let (mut hits, mut width) = (vec![0usize; 4], 0.0);
    for _ in 0..draws {
        let found = fit(&Nodes::curve(x.clone(), noise(&mut random), None)?, spec)?;
        for (c, hits) in found.coefficients.iter().zip(&mut hits) {
            let [low, high] = c.interval.ok_or("no interval")?.ends;
            *hits += usize::from(low <= 0.0 && 0.0 <= high);
            width += (high - low) / (4 * draws) as f64;
        }
    }
    let share = |hits: usize| hits as f64 / draws as f64;
    let worst = hits.iter().map(|&h| share(h)).fold(1.0, f64::min);
    Ok((hits.iter().map(|&h| share(h)).sum::<f64>() / 4.0, worst, width))
}

fn autoregression(random: &mut Random, phi: [f64; 2]) -> Vec<f64> {
    let (mut y, mut before) = (0.0, 0.0);
    let mut next = || {
        (y, before) = (phi[0] * y + phi[1] * before + random.normal(), y);
        y
    };
    (0..500).for_each(|_| {
        next();
    });
    (0..COUNT).map(|_| next()).collect()
}

/// Matérn's process with smoothness 3/2 and a length in steps: white noise twice through the same
/// decay, in steps a hundred times as fine.
fn matern(random: &mut Random, length: f64) -> Vec<f64> {
    let decay = (-(3f64.sqrt()) / (100.0 * length)).exp();
    let (mut once, mut twice) = (0.0, 0.0);
    let mut next = || {
        for _ in 0..100 {
            once = decay * once + random.normal();
            twice = decay * twice + once;
        }
        twice
    };
    (0..50).for_each(|_| {
        next();
    });
    (0..COUNT).map(|_| next()).collect()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let draws: usize = std::env::args().nth(1).map_or(Ok(500), |text| text.parse())?;
    let model = Model::Polynomial { degree: Degree::Both(3), basis: PolynomialBasis::Legendre, terms: Terms::Tensor };
    let plain = FitSpec { regularization: Regularization::None, ..FitSpec::new(model) };
    let errors = |correlation| FitSpec {
        errors: Some(Errors { correlation, along: Along::Order, lines: None }),
        ..plain.clone()
    };
    let ar1 = errors(Correlation::Ar1 { rho: None });
    let ar2 = errors(Correlation::Ar2 { phi: None });
    let smooth = errors(Correlation::Matern { parameters: None });
    let variance = |variance| FitSpec { variance, ..plain.clone() };
    let growing =
        |random: &mut Random| (0..COUNT).map(|i| (1.0 + 3.0 * i as f64 / 59.0) * random.normal()).collect::<Vec<_>>();
    let stepped =
        |random: &mut Random| (0..COUNT).map(|i| if i < 30 { 1.0 } else { 4.0 } * random.normal()).collect::<Vec<_>>();
    let process = |a: f64, b: f64| move |random: &mut Random| autoregression(random, [a, b]);
    let halves = variance(Variance::Groups((0..60).map(|i| i / 30).collect()));
    type Noise<'a> = Box<dyn Fn(&mut Random) -> Vec<f64> + 'a>;
    let rows: [(&str, Noise, &str, &FitSpec); 10] = [
        ("independent", Box::new(process(0.0, 0.0)), "ar1", &ar1),
        ("AR(1), ρ = 0.5", Box::new(process(0.5, 0.0)), "ar1", &ar1),
        ("AR(1), ρ = 0.9", Box::new(process(0.9, 0.0)), "ar1", &ar1),
        ("AR(1), ρ = 0.95", Box::new(process(0.95, 0.0)), "ar1", &ar1),
        ("AR(2), φ = 1.1, -0.5", Box::new(process(1.1, -0.5)), "ar2", &ar2),
        ("AR(1), ρ = 0.5", Box::new(process(0.5, 0.0)), "ar2", &ar2),
        ("Matérn, length 4 steps", Box::new(|random: &mut Random| matern(random, 4.0)), "matern", &smooth),
        ("independent", Box::new(process(0.0, 0.0)), "matern", &smooth),
        ("σ from 1 to 4 over the width", Box::new(growing), "hc3", &variance(Variance::Hc3)),
        ("σ = 1 and 4 on the halves", Box::new(stepped), "groups", &halves),
    ];
    println!("| errors | model of the errors | coverage, mean | worst | width over plain | coverage of plain |");
    println!("|---|---|---|---|---|---|");
    for (name, noise, asked, spec) in rows {
        let (mean, worst, width) = coverage(spec, draws, &noise)?;
        let (usual, _, narrow) = coverage(&plain, draws, &noise)?;
        println!("| {name} | `{asked}` | {mean:.3} | {worst:.3} | {:.2} | {usual:.3} |", width / narrow);
    }
    Ok(())
}
