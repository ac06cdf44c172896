//! How good the chain of earlier iterations is, and how often its intervals hold: the table of
//! docs/prior.md.
//!
//! Sets of iterations over the same nodes, between which the coefficients move at random by so many
//! standard errors (of least squares of one iteration): all of them alike, the first third alone,
//! or one of them at a time. `cargo run --release -p flankfit-engine --example prior_iterations --
//! 1000` draws 1,000 sets of six each.

#[expect(dead_code, reason = "the oracle is shared with the tests, which use all of it")]
#[path = "../tests/oracle/mod.rs"]
mod oracle;

use std::{f64::consts::PI, sync::Arc};

use flankfit_engine::estimation::{
    FitSpec, Nodes, fit,
    spec::{Chain, Earlier, Kinds, Model, Moves, Places, Predict, Prior, Regularization, Which},
};
use oracle::random::Random;

/// Which coefficients move.
#[derive(Clone, Copy)]
enum Moving {
    All,
    FirstThird,
    OneAtATime,
}

/// What came of the sets.
#[derive(Default)]
struct Found {
    ours: f64,
    theirs: f64,
    hits: Vec<usize>,
    width: f64,
    let_go: usize,
    /// Sets whose simultaneous band holds the heights at all nodes.
    bands: usize,
}

/// Columns of length 1 at right angles: standard errors are σ, and every other basis of the same
/// functions gives the same heights.
fn design(m: usize, n: usize) -> Vec<Vec<f64>> {
    let wave = |k: usize, j: usize| (PI * (k as f64 + 0.5) * j as f64 / m as f64).cos();
    let length = |j: usize| if j == 0 { (m as f64).sqrt() } else { (m as f64 / 2.0).sqrt() };
    (0..m).map(|k| (0..n).map(|j| wave(k, j) / length(j)).collect()).collect()
}

/// The next move of the coefficients, of `step` root mean square over all of them.
fn moved(truth: &mut [f64], moving: Moving, step: f64, random: &mut Random) {
    let n = truth.len();
    let some = match moving {
        Moving::All => 0..n,
        Moving::FirstThird => 0..(n / 3).max(1),
        Moving::OneAtATime => {
            let j = random.below(n);
            j..j + 1
        }
    };
    let size = step * (n as f64 / some.len() as f64).sqrt();
    truth[some].iter_mut().for_each(|a| *a += size * random.normal());
}

fn run(x: &[Vec<f64>], iterations: u32, moving: Moving, step: f64, sets: usize) -> Found {
    let n = x[0].len();
    let mut found = Found { hits: vec![0; n], ..Found::default() };
    let mut random = Random::new(7);
    for _ in 0..sets {
        let mut truth: Vec<f64> = random.normals(n).iter().map(|a| 10.0 * a).collect();
        let mut all = Vec::new();
        for number in 1..=iterations {
            if number > 1 {
                moved(&mut truth, moving, step, &mut random);
            }
            let y = x.iter().map(|row| row.iter().zip(&truth).map(|(x, a)| x * a).sum::<f64>() + random.normal());
            let nodes = Nodes::matrix(x.concat(), n, y.collect(), None, None).expect("finite numbers");
            all.push(Earlier { number, fit_id: String::new(), nodes: Arc::new(nodes), corrections: vec![] });
        }
        let now = all.pop().expect("at least one");
        let chain =
            Chain { which: Which::Previous, moves: Moves::Estimated, correction: true, earlier: Some(all.into()) };
        let kinds = Kinds { simultaneous: true, ..Kinds::default() };
        let spec = FitSpec {
            regularization: Regularization::None,
            predict: Some(Predict { at: Places::Rows(x.to_vec()), level: None, kinds, slopes: false }),
            prior: Some(Prior::Iterations(chain)),
            ..FitSpec::new(Model::Linear)
        };
        let result = fit(&now.nodes, &spec).expect("a fit");
        for (j, (c, a)) in result.coefficients.iter().zip(&truth).enumerate() {
            found.ours += (c.value - a).powi(2);
            found.theirs += (c.least_squares - a).powi(2);
            let interval = c.interval.expect("there is noise");
            found.hits[j] += usize::from(interval.ends[0] <= *a && *a <= interval.ends[1]);
            found.width += interval.gain.unwrap_or(1.0);
        }
        let band = result.predictions.and_then(|bands| bands.simultaneous).expect("there is noise").band;
        let height = |row: &[f64]| row.iter().zip(&truth).map(|(x, a)| x * a).sum::<f64>();
        let holds = |([low, high], row): (&[f64; 2], &Vec<f64>)| (*low..=*high).contains(&height(row));
        found.bands += usize::from(band.iter().zip(x).all(holds));
        found.let_go += usize::from(result.prior.and_then(|prior| prior.conflict).is_some_and(|c| c.let_go));
    }
    found
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sets: usize = std::env::args().nth(1).map_or(Ok(1000), |text| text.parse())?;
    println!("{sets} sets each; mean squared error over least squares' / mean coverage / that of the worst");
    println!("coefficient / coverage of the simultaneous band / width over least squares' / share of sets in which");
    println!("the prior was let go\n");
    println!("| coefficients, iterations, what moves | 0 σ | 0.1 σ | 0.3 σ | 0.7 σ | 1 σ | 3 σ | 10 σ |");
    println!("|---|---|---|---|---|---|---|---|");
    for (n, iterations, moving, name) in [
        (4, 6, Moving::All, "4, 6, all"),
        (9, 6, Moving::All, "9, 6, all"),
        (16, 6, Moving::All, "16, 6, all"),
        (9, 2, Moving::All, "9, 2, all"),
        (9, 6, Moving::FirstThird, "9, 6, three of them"),
        (9, 6, Moving::OneAtATime, "9, 6, one at a time"),
    ] {
        let x = design(45, n);
        print!("| {name} ");
        for step in [0.0, 0.1, 0.3, 0.7, 1.0, 3.0, 10.0] {
            let found = run(&x, iterations, moving, step, sets);
            let shares: Vec<f64> = found.hits.iter().map(|&h| h as f64 / sets as f64).collect();
            let count = n as f64;
            print!(
                "| {:.2} / {:.3} / {:.3} / {:.3} / {:.2} / {:.3} ",
                found.ours / found.theirs,
                shares.iter().sum::<f64>() / count,
                shares.iter().fold(1.0f64, |least, s| least.min(*s)),
                found.bands as f64 / sets as f64,
                found.width / (count * sets as f64),
                found.let_go as f64 / sets as f64
            );
        }
        println!("|");
    }
    Ok(())
}
