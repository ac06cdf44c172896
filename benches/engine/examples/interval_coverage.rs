//! Coverage of confidence intervals: the table of docs/explanation/intervals.md.
//!
//! For each design the true coefficients have norm 1 (in columns of unit length), along the worst
//! determined direction, the best, or all alike; the noise is a tenth, once and ten times what
//! makes the worst direction as uncertain as it is large. `cargo run --release -p engine-benches
//! --example interval_coverage -- 600` draws 600 times each.

#[expect(dead_code, reason = "the oracle is shared with the tests, which use all of it")]
#[path = "../../../engine/tests/oracle/mod.rs"]
mod oracle;

use flankfit_engine::estimation::{FitSpec, Nodes, fit, spec::Model};
use oracle::{
    coverage::{Truth, designs},
    random::Random,
};

/// Hits of one kind of interval: by coefficient, and the widths over those of least squares.
#[derive(Default)]
struct Kind {
    hits: Vec<usize>,
    width: f64,
}

impl Kind {
    fn count(&mut self, j: usize, [low, high]: [f64; 2], truth: f64, width: f64) {
        if self.hits.len() <= j {
            self.hits.resize(j + 1, 0);
        }
        self.hits[j] += usize::from(low <= truth && truth <= high);
        self.width += (high - low) / width;
    }

    fn shares(&self, repetitions: usize) -> impl Iterator<Item = f64> {
        self.hits.iter().map(move |&h| h as f64 / repetitions as f64)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let repetitions: usize = std::env::args().nth(1).map_or(Ok(600), |text| text.parse())?;
    println!(
        "{repetitions} draws of each of 9 cases; mean coverage / that of the worst coefficient / width over least squares'\n"
    );
    println!(
        "| design | ± t · conditional_std_error | … + bias_bound | interval, no limit told | interval, limit told |"
    );
    println!("|---|---|---|---|---|");
    let names = 4;
    for design in designs() {
        let (mut mean, mut least, mut width) = (vec![0.0; names], vec![1.0f64; names], vec![0.0; names]);
        let mut cases = 0.0;
        for truth in [Truth::Smallest, Truth::Largest, Truth::Every] {
            for noise in [0.1, 1.0, 10.0] {
                let (coefficients, sigma) = (design.truth(truth, 1.0), noise * design.directions[0].0);
                let mut kinds: Vec<Kind> = (0..names).map(|_| Kind::default()).collect();
                let mut random = Random::new(7);
                for _ in 0..repetitions {
                    let heights = design.x.iter().map(|row| {
                        row.iter().zip(&coefficients).map(|(x, a)| x * a).sum::<f64>() + sigma * random.normal()
                    });
                    let nodes = Nodes::matrix(design.x.concat(), coefficients.len(), heights.collect(), None, None)?;
                    let spec = FitSpec::new(Model::Linear);
                    let plain = fit(&nodes, &spec)?;
                    let told = fit(&nodes, &FitSpec { coefficient_norm_limit: Some(1.0), ..spec })?;
                    for (j, (c, told)) in plain.coefficients.iter().zip(&told.coefficients).enumerate() {
                        let (own, told) = (c.interval.ok_or("no interval")?, told.interval.ok_or("no interval")?);
                        let whole = own.ends[1] - own.ends[0];
                        let t = 0.5 * whole / c.least_squares_std_error.ok_or("no error")?;
                        let usual = t * c.error_given_lambda().ok_or("no error")?;
                        let wide = usual + c.bias_bound;
                        let ends =
                            [[c.value - usual, c.value + usual], [c.value - wide, c.value + wide], own.ends, told.ends];
                        for (kind, ends) in kinds.iter_mut().zip(ends) {
                            kind.count(j, ends, coefficients[j], whole);
                        }
                    }
                }
                let each = (repetitions * coefficients.len()) as f64;
                for (k, kind) in kinds.iter().enumerate() {
                    mean[k] += kind.shares(repetitions).sum::<f64>() / coefficients.len() as f64;
                    least[k] = kind.shares(repetitions).fold(least[k], f64::min);
                    width[k] += kind.width / each;
                }
                cases += 1.0;
            }
        }
        print!("| {} |", design.name);
        for k in 0..names {
            print!(" {:.3} / {:.3} / {:.2} |", mean[k] / cases, least[k], width[k] / cases);
        }
        println!();
    }
    Ok(())
}
