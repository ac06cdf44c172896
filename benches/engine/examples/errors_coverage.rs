//! Coverage of intervals where errors are not white: the tables of docs/explanation/errors.md.
//!
//! A cubic at 60 nodes whose coefficients are all 0. `cargo run --release -p engine-benches
//! --example errors_coverage -- 2000` draws 2,000 times each; `-- 2000 powers` and `-- 2000 along`
//! make the last tables alone.

#[expect(dead_code, reason = "the oracle is shared with the tests, which use all of it")]
#[path = "../../../engine/tests/oracle/mod.rs"]
mod oracle;

use flankfit_engine::estimation::{
    FitResult, FitSpec, Nodes, fit,
    spec::{
        Along, Correlation, Degree, Errors, Kinds, Model, Places, PolynomialBasis, Predict, Regularization, Terms,
        Variance,
    },
};
use oracle::{checked::Checked, random::Random};

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
    match std::env::args().nth(2).as_deref() {
        Some("powers") => return powers(draws),
        Some("along") => return directions(draws),
        _ => {}
    }
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
    few_noisy(&plain, draws)?;
    small_groups(&plain, draws)?;
    powers(draws)?;
    directions(draws)
}

/// Directions of correlated errors on grids, left out and both: coverage of the coefficients, and
/// the share of fits along u, along v and along both.
fn directions(draws: usize) -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "\n| grid | ρ along u, v | along | coverage, mean | worst | width over plain | u, v, both | coverage of plain |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    let [a, b, ..] = Checked::all();
    for design in [a, b] {
        for rho in [[0.0, 0.0], [0.6, 0.0], [0.0, 0.6], [0.6, 0.6]] {
            for along in [Along::Order, Along::Both] {
                let errors = Some(Errors { correlation: Correlation::Ar1 { rho: None }, along, lines: None });
                let spec = FitSpec { errors, ..design.spec.clone() };
                let mut random = Random::new(730_119);
                let (mut hits, mut usual, mut widths, mut chosen) = (Vec::new(), 0, [0.0; 2], [0; 3]);
                for _ in 0..draws {
                    let nodes = design.correlated_both(&mut random, rho)?;
                    let (found, plain) = (fit(&nodes, &spec)?, fit(&nodes, &design.spec)?);
                    hits.resize(found.coefficients.len(), 0usize);
                    for ((c, plain), hits) in found.coefficients.iter().zip(&plain.coefficients).zip(&mut hits) {
                        let [own, plain] = [c, plain].map(|c| c.interval.map_or([f64::NAN; 2], |one| one.ends));
                        let holds = |ends: [f64; 2]| usize::from(ends[0] <= 0.0 && 0.0 <= ends[1]);
                        *hits += holds(own);
                        usual += holds(plain);
                        widths[0] += own[1] - own[0];
                        widths[1] += plain[1] - plain[0];
                    }
                    let place = match found.errors.as_ref().map(|errors| errors.along) {
                        Some(Along::U) => 0,
                        Some(Along::V) => 1,
                        _ => 2,
                    };
                    chosen[place] += 1;
                }
                let share = |hits: usize| hits as f64 / draws as f64;
                let size = hits.len() as f64;
                let mean = hits.iter().map(|&hits| share(hits)).sum::<f64>() / size;
                let worst = hits.iter().map(|&hits| share(hits)).fold(1.0, f64::min);
                let [u, v, both] = chosen.map(share);
                println!(
                    "| {} | {}, {} | {} | {mean:.3} | {worst:.3} | {:.2} | {u:.2}, {v:.2}, {both:.2} | {:.3} |",
                    design.name,
                    rho[0],
                    rho[1],
                    if along == Along::Both { "both" } else { "left out" },
                    widths[0] / widths[1],
                    share(usual) / size
                );
            }
        }
    }
    Ok(())
}

/// Powers of the standard deviation, estimated from so many nodes: coefficients, heights at nine
/// places and the band; also polynomials of other degrees with as few degrees of freedom.
fn powers(draws: usize) -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "\n| coefficients | m | p | coefficients, least | most | heights, least | most | band | warned | refused |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    let few = [2, 3, 4, 6].into_iter().flat_map(|n| [4, 6, 7, 8, 10].map(|freedom| (n, n + freedom)));
    for (n, count) in few.chain([(4, 20), (4, 30), (4, 60)]) {
        let x: Vec<f64> = (0..count).map(|k| 1.0 + 9.0 * k as f64 / (count - 1) as f64).collect();
        let at = Places::Curve((0..9).map(|k| 1.0 + 1.125 * f64::from(k)).collect());
        let kinds = Kinds { confidence: true, prediction: false, simultaneous: true };
        let model =
            Model::Polynomial { degree: Degree::Both(n - 1), basis: PolynomialBasis::Legendre, terms: Terms::Tensor };
        let spec = FitSpec {
            regularization: Regularization::None,
            predict: Some(Predict { at, level: None, kinds, slopes: false }),
            variance: Variance::Power { of: Along::U, exponent: None },
            ..FitSpec::new(model)
        };
        for power in [0.0, 0.5, 1.0, 2.0] {
            let mut random = Random::new(13);
            let (mut held, mut refused) = (Held::new(n, 9), 0);
            for _ in 0..draws {
                let y = x.iter().map(|x| x.powf(power) * random.normal()).collect();
                match fit(&Nodes::curve(x.clone(), y, None)?, &spec) {
                    Ok(found) => held.add(&found, "power_uncertain").ok_or("no bands")?,
                    Err(_) => refused += 1,
                }
            }
            println!("| {n} | {count} | {power} | {held} | {:.2} |", refused as f64 / draws as f64);
        }
    }
    Ok(())
}

/// Counts of how often 0, the truth, lies in the intervals and bands of fits, and of warnings.
struct Held {
    coefficients: Vec<usize>,
    heights: Vec<usize>,
    band: usize,
    warned: usize,
    fits: usize,
}

impl Held {
    fn new(coefficients: usize, heights: usize) -> Self {
        Held { coefficients: vec![0; coefficients], heights: vec![0; heights], band: 0, warned: 0, fits: 0 }
    }

    /// `None` where the fit has no bands.
    fn add(&mut self, found: &FitResult, warning: &str) -> Option<()> {
        let holds = |ends: &[f64; 2]| ends[0] <= 0.0 && 0.0 <= ends[1];
        for (c, hits) in found.coefficients.iter().zip(&mut self.coefficients) {
            *hits += usize::from(c.interval.is_some_and(|interval| holds(&interval.ends)));
        }
        let bands = found.predictions.as_ref()?;
        for (ends, hits) in bands.confidence.as_ref()?.iter().zip(&mut self.heights) {
            *hits += usize::from(holds(ends));
        }
        self.band += usize::from(bands.simultaneous.as_ref()?.band.iter().all(holds));
        self.warned += usize::from(found.warnings.iter().any(|w| w.code() == warning));
        self.fits += 1;
        Some(())
    }
}

/// Least and greatest coverage of the coefficients and of the heights, the band's, the share that
/// is warned of.
impl std::fmt::Display for Held {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let share = |hits: usize| hits as f64 / self.fits as f64;
        let ends = |hits: &[usize]| {
            let all = hits.iter().map(|&h| share(h));
            (all.clone().fold(1.0, f64::min), all.fold(0.0, f64::max))
        };
        let ((a, b), (c, d)) = (ends(&self.coefficients), ends(&self.heights));
        write!(f, "{a:.3} | {b:.3} | {c:.3} | {d:.3} | {:.3} | {:.2}", share(self.band), share(self.warned))
    }
}

/// A few nodes that are ten times as noisy as the others, without being declared: intervals of the
/// coefficients and of the heights at every seventh node (second of twenty), and the band over
/// them.
fn few_noisy(plain: &FitSpec, draws: usize) -> Result<(), Box<dyn std::error::Error>> {
    println!("\n| nodes | σ ten times as great | coefficients, least | most | heights, least | most | band | warned |");
    println!("|---|---|---|---|---|---|---|---|");
    for (count, step) in [(60usize, 7), (20, 2)] {
        let x: Vec<f64> = (0..count).map(|i| i as f64).collect();
        let at: Vec<f64> = x.iter().copied().step_by(step).collect();
        let heights = at.len();
        let kinds = Kinds { confidence: true, prediction: false, simultaneous: true };
        let predict = Some(Predict { at: Places::Curve(at), level: None, kinds, slopes: false });
        let spec = FitSpec { variance: Variance::Hc3, predict, ..plain.clone() };
        let middle = count / 2;
        let cases = [
            ("nowhere", vec![]),
            ("at the first", vec![0]),
            ("in the middle", vec![middle]),
            ("at the last two", vec![count - 2, count - 1]),
            ("at the last three", (count - 3..count).collect()),
            ("at the last five", (count - 5..count).collect()),
            ("at three all along", vec![count / 6, middle, 5 * count / 6]),
        ];
        for (name, noisy) in cases {
            let mut random = Random::new(12);
            let mut held = Held::new(4, heights);
            for _ in 0..draws {
                let y = (0..count).map(|k| if noisy.contains(&k) { 10.0 } else { 1.0 } * random.normal()).collect();
                held.add(&fit(&Nodes::curve(x.clone(), y, None)?, &spec)?, "").ok_or("no bands")?;
            }
            println!("| {count} | {name} | {held} |");
        }
    }
    Ok(())
}

/// Groups of which one is small and as precise as the other or more so: intervals of the heights at
/// all nodes, and the band over the whole.
fn small_groups(plain: &FitSpec, draws: usize) -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "\n| small group | its nodes | its σ | coefficients, least | most | heights, least | most | band | warned |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let x: Vec<f64> = (0..COUNT).map(|i| i as f64).collect();
    let kinds = Kinds { confidence: true, prediction: false, simultaneous: true };
    for (small, along) in [5, 6, 8, 10, 30].into_iter().flat_map(|small| [(small, false), (small, true)]) {
        let member = |k: usize| if along { (0..small).any(|i| i * (COUNT - 1) / (small - 1) == k) } else { k < small };
        let group: Vec<i64> = (0..COUNT).map(|k| i64::from(!member(k))).collect();
        let predict = Some(Predict { at: Places::Curve(x.clone()), level: None, kinds, slopes: false });
        let spec = FitSpec { variance: Variance::Groups(group.clone()), predict, ..plain.clone() };
        for sigma in [1.0, 0.3, 0.1] {
            let mut random = Random::new(11);
            let mut held = Held::new(4, COUNT);
            for _ in 0..draws {
                let y = group.iter().map(|g| if *g == 0 { sigma } else { 1.0 } * random.normal()).collect();
                let found = fit(&Nodes::curve(x.clone(), y, None)?, &spec)?;
                held.add(&found, "group_variance_uncertain").ok_or("no bands")?;
            }
            let place = if along { "all along" } else { "at one end" };
            println!("| {small} of 60 | {place} | {sigma} | {held} |");
        }
    }
    Ok(())
}
