//! Coverage of intervals where the positions of the nodes are off: the table of
//! docs/explanation/errors.md.
//!
//! Sixty nodes over 10 mm, cubics in µm by Legendre polynomials, positions off by a given standard
//! deviation. `cargo run --release -p engine-benches --example positions_coverage -- 1000` draws
//! 1,000 times each.

#[expect(dead_code, reason = "the oracle is shared with the tests, which use all of it")]
#[path = "../../../engine/tests/oracle/mod.rs"]
mod oracle;

use flankfit_engine::estimation::{Nodes, fit, spec::PositionKind};
use oracle::{
    positions::{CUBICS, PLACES, coefficients, height, uncertain},
    random::Random,
};

/// Results of all draws of one case.
struct Coverage {
    mean: f64,
    worst: f64,
    warned: f64,
    /// Draws whose positions did not settle.
    unsettled: usize,
}

fn covered(cubic: [f64; 4], position: f64, sigma: f64, kind: PositionKind, draws: usize) -> Coverage {
    let spec = uncertain(position, sigma, Some(kind));
    let mut random = Random::new(61);
    let (mut hits, mut warned, mut unsettled) = ([0usize; 4], 0usize, 0usize);
    for _ in 0..draws {
        let even: Vec<f64> = (0..PLACES).map(|k| 10.0 * k as f64 / (PLACES - 1) as f64).collect();
        let off: Vec<f64> = even.iter().map(|x| x + position * random.normal()).collect();
        let (told, hit) = if kind == PositionKind::Measured { (&off, &even) } else { (&even, &off) };
        let y = hit.iter().map(|&x| height(cubic, x) + sigma * random.normal()).collect();
        let nodes = Nodes::curve(told.clone(), y, None).expect("finite numbers are nodes");
        let Ok(found) = fit(&nodes, &spec) else {
            unsettled += 1;
            continue;
        };
        warned += usize::from(found.warnings.iter().any(|warning| warning.code() == "positions_uncertain"));
        for ((hits, coefficient), a) in hits.iter_mut().zip(&found.coefficients).zip(coefficients(cubic)) {
            let [low, high] = coefficient.interval.as_ref().expect("sixty nodes leave an estimate of the noise").ends;
            *hits += usize::from((low..=high).contains(&a));
        }
    }
    let settled = (draws - unsettled) as f64;
    let share = hits.map(|hits| hits as f64 / settled);
    Coverage {
        mean: share.iter().sum::<f64>() / 4.0,
        worst: share.into_iter().fold(1.0, f64::min),
        warned: warned as f64 / settled,
        unsettled,
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let draws: usize = std::env::args().nth(1).map_or(Ok(300), |text| text.parse())?;
    println!("| kind | coefficients of P₁, P₂, P₃ | position, mm | σ, µm | mean | worst | warned | not settled |");
    println!("|---|---|---|---|---|---|---|---|");
    for kind in [PositionKind::Measured, PositionKind::Nominal] {
        for cubic in CUBICS {
            for position in [0.25, 0.5, 1.0] {
                for sigma in [0.5, 1.0, 2.0] {
                    let Coverage { mean, worst, warned, unsettled } = covered(cubic, position, sigma, kind, draws);
                    let [_, a, b, c] = cubic;
                    println!(
                        "| `{}` | {a}, {b}, {c} | {position} | {sigma} | {mean:.3} | {worst:.3} | {warned:.2} | {:.3} |",
                        if kind == PositionKind::Measured { "measured" } else { "nominal" },
                        unsettled as f64 / draws as f64
                    );
                }
            }
        }
    }
    Ok(())
}
