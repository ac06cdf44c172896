//! Errors of the chain of earlier iterations, and coverage of its intervals: the table of
//! docs/explanation/prior.md.
//!
//! Sets of iterations over the same nodes, between which the coefficients move at random by so many
//! standard errors (of least squares of one iteration): all of them alike, the first third alone,
//! one of them at a time, or always the same one; then sets that are constant but for one step at
//! the last move. `cargo run --release -p engine-benches --example prior_iterations -- 1000` draws
//! 1,000 sets each; `-- 1000 bands` asks for the simultaneous band too, which takes five times as
//! long.

#[expect(dead_code, reason = "the oracle is shared with the tests, which use all of it")]
#[path = "../../../engine/tests/oracle/mod.rs"]
mod oracle;

use std::{f64::consts::PI, sync::Arc};

use flankfit_engine::estimation::{
    FitSpec, Nodes, fit,
    spec::{Chain, Earlier, Kinds, Model, Moves, Places, Predict, Prior, Regularization, Which},
};
use oracle::random::Random;

/// Coefficients that move.
#[derive(Clone, Copy)]
enum Moving {
    All,
    FirstThird,
    OneAtATime,
    AlwaysOne,
    /// Only the last move: of one coefficient, and of all.
    StepOfOne,
    StepOfAll,
}

/// Results of the sets.
#[derive(Default)]
struct Found {
    ours: f64,
    theirs: f64,
    hits: Vec<usize>,
    width: f64,
    /// Values outside of their intervals.
    outside: usize,
    dropped: usize,
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

/// The next move of the coefficients: of `step` root mean square over all of them, or `step` of
/// each that moves.
fn moved(truth: &mut [f64], moving: Moving, step: f64, last: bool, random: &mut Random) {
    let n = truth.len();
    let some = match moving {
        Moving::All | Moving::StepOfAll => 0..n,
        Moving::FirstThird => 0..(n / 3).max(1),
        Moving::OneAtATime => {
            let j = random.below(n);
            j..j + 1
        }
        Moving::AlwaysOne | Moving::StepOfOne => n / 2..n / 2 + 1,
    };
    match moving {
        Moving::StepOfOne | Moving::StepOfAll => {
            truth[some].iter_mut().for_each(|a| *a += if last { step } else { 0.0 });
        }
        _ => {
            let alone = matches!(moving, Moving::AlwaysOne);
            let size = if alone { step } else { step * (n as f64 / some.len() as f64).sqrt() };
            truth[some].iter_mut().for_each(|a| *a += size * random.normal());
        }
    }
}

fn run(x: &[Vec<f64>], iterations: u32, moving: Moving, step: f64, (sets, bands): (usize, bool)) -> Found {
    let n = x[0].len();
    let mut found = Found { hits: vec![0; n], ..Found::default() };
    let mut random = Random::new(7);
    for _ in 0..sets {
        let mut truth: Vec<f64> = random.normals(n).iter().map(|a| 10.0 * a).collect();
        let mut all = Vec::new();
        for number in 1..=iterations {
            if number > 1 {
                moved(&mut truth, moving, step, number == iterations, &mut random);
            }
            let y = x.iter().map(|row| row.iter().zip(&truth).map(|(x, a)| x * a).sum::<f64>() + random.normal());
            let nodes = Nodes::matrix(x.concat(), n, y.collect(), None, None).expect("finite numbers");
            all.push(Earlier { number, fit_id: String::new(), nodes: Arc::new(nodes), corrections: vec![] });
        }
        let now = all.pop().expect("at least one");
        let chain =
            Chain { which: Which::Previous, moves: Moves::Estimated, correction: true, earlier: Some(all.into()) };
        let kinds = Kinds { confidence: false, prediction: false, simultaneous: true };
        let spec = FitSpec {
            regularization: Regularization::None,
            predict: bands.then(|| Predict { at: Places::Rows(x.to_vec()), level: None, kinds, slopes: false }),
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
            found.outside += usize::from(c.value < interval.ends[0] || interval.ends[1] < c.value);
        }
        if let Some(simultaneous) = result.predictions.and_then(|bands| bands.simultaneous) {
            let height = |row: &[f64]| row.iter().zip(&truth).map(|(x, a)| x * a).sum::<f64>();
            let holds = |([low, high], row): (&[f64; 2], &Vec<f64>)| (*low..=*high).contains(&height(row));
            found.bands += usize::from(simultaneous.band.iter().zip(x).all(holds));
        }
        found.dropped += usize::from(result.prior.and_then(|prior| prior.conflict).is_some_and(|c| c.dropped));
    }
    found
}

type Row = (usize, u32, Moving, &'static str);

fn table(rows: &[Row], steps: &[f64], (sets, bands): (usize, bool)) {
    println!(
        "| coefficients, iterations, what moves |{}",
        steps.iter().map(|s| format!(" {s} σ |")).collect::<String>()
    );
    println!("|---|{}", "---|".repeat(steps.len()));
    for &(n, iterations, moving, name) in rows {
        let x = design(45, n);
        print!("| {n}, {iterations}, {name} ");
        for &step in steps {
            let found = run(&x, iterations, moving, step, (sets, bands));
            let shares: Vec<f64> = found.hits.iter().map(|&h| h as f64 / sets as f64).collect();
            let count = n as f64;
            let band = if bands { format!(" / {:.3}", found.bands as f64 / sets as f64) } else { String::new() };
            print!(
                "| {:.2} / {:.3} / {:.3} / {:.2} / {:.3}{band} ",
                found.ours / found.theirs,
                shares.iter().sum::<f64>() / count,
                shares.iter().fold(1.0f64, |least, s| least.min(*s)),
                found.width / (count * sets as f64),
                found.dropped as f64 / sets as f64
            );
            assert_eq!(found.outside, 0, "a value lies outside of its interval");
        }
        println!("|");
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sets: usize = std::env::args().nth(1).map_or(Ok(1000), |text| text.parse())?;
    let bands = std::env::args().nth(2).is_some_and(|asked| asked == "bands");
    println!("{sets} sets each; mean squared error over least squares' / mean coverage / that of the worst");
    println!("coefficient / width over least squares' / share of sets in which the prior was let go");
    println!("{}\n", if bands { "/ coverage of the simultaneous band" } else { "" });
    let sets = (sets, bands);
    let rows = [
        (4, 6, Moving::All, "all"),
        (9, 6, Moving::All, "all"),
        (9, 2, Moving::All, "all"),
        (9, 6, Moving::FirstThird, "three of them"),
        (9, 6, Moving::OneAtATime, "one at a time"),
        (9, 6, Moving::AlwaysOne, "always the same one"),
        (4, 6, Moving::AlwaysOne, "always the same one"),
    ];
    table(&rows, &[0.0, 0.1, 0.3, 0.6, 1.0, 3.0, 10.0], sets);
    println!("\nonly the last move, by so many standard errors\n");
    let rows = [
        (4, 6, Moving::StepOfOne, "one steps"),
        (4, 6, Moving::StepOfAll, "all step"),
        (4, 20, Moving::StepOfOne, "one steps"),
        (4, 20, Moving::StepOfAll, "all step"),
        (9, 20, Moving::StepOfOne, "one steps"),
    ];
    table(&rows, &[1.0, 2.0, 3.0, 5.0, 10.0, 30.0], sets);
    Ok(())
}
