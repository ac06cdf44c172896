//! Errors that are not normal, and how often intervals about estimates hold with them.

use std::ops::Range;

use flankfit_engine::estimation::{
    FitSpec, Nodes, fit,
    inference::ConformityVerdict,
    spec::{
        Contamination, Distribution, Estimator, Kinds, LEstimator, Loss, MEstimator, Model, Places, Predict,
        QuantileWeights, Regularization,
    },
};

use super::{checked::Checked, random::Random};

/// Distributions of errors.
#[derive(Clone, Copy, Debug)]
pub enum Errors {
    Normal,
    /// Student's, three degrees of freedom.
    Student3,
    Laplace,
    /// Normal, every tenth with five times the deviation.
    Contaminated,
    /// Normal, every tenth off by 10 to 20 deviations.
    Gross,
}

pub const ERRORS: [Errors; 4] = [Errors::Normal, Errors::Student3, Errors::Laplace, Errors::Contaminated];

impl Errors {
    fn draw(self, random: &mut Random) -> f64 {
        match self {
            Errors::Normal => random.normal(),
            Errors::Student3 => {
                let squares: f64 = (0..3).map(|_| random.normal().powi(2)).sum();
                random.normal() / (squares / 3.0).sqrt()
            }
            Errors::Laplace => {
                let u = random.between(-1.0, 1.0);
                -u.signum() * (1.0 - u.abs()).ln()
            }
            Errors::Contaminated => {
                let gross = random.unit() < 0.1;
                random.normal() * if gross { 5.0 } else { 1.0 }
            }
            Errors::Gross if random.unit() < 0.1 => {
                random.between(10.0, 20.0) * if random.unit() < 0.5 { -1.0 } else { 1.0 }
            }
            Errors::Gross => random.normal(),
        }
    }
}

/// Estimators of the table.
pub fn estimators() -> Vec<(&'static str, Estimator)> {
    let weights = QuantileWeights::new(&[[0.25, 0.3], [0.5, 0.4], [0.75, 0.3]]).unwrap();
    let likelihood = Estimator::Likelihood;
    vec![
        ("least squares", Estimator::LeastSquares),
        ("Huber, k = 1.345", Estimator::M(MEstimator::new(Loss::HUBER))),
        ("Huber, ε = 0.1", Estimator::M(MEstimator::minimax(Contamination::Share(0.1)))),
        ("Huber, ε estimated", Estimator::M(MEstimator::minimax(Contamination::Estimated))),
        ("trimmed, 0.1", Estimator::L(LEstimator::Trimmed { share: 0.1 })),
        ("winsorized, 0.1", Estimator::L(LEstimator::Winsorized { share: 0.1 })),
        ("quantiles", Estimator::L(LEstimator::Quantiles(weights))),
        ("rank, Wilcoxon", Estimator::Rank),
        ("rank, normal scores", Estimator::NormalScores),
        ("likelihood, Student, ν = 3", likelihood(Distribution::Student { freedom: Some(3.0) })),
        ("likelihood, Student, ν estimated", likelihood(Distribution::Student { freedom: None })),
        ("likelihood, Laplace", likelihood(Distribution::Laplace)),
        ("likelihood, generalised normal, p estimated", likelihood(Distribution::GeneralizedNormal { exponent: None })),
    ]
}

/// Estimators whose intervals are wider, or that give up nodes.
pub fn more_estimators() -> Vec<(&'static str, Estimator)> {
    let m = |loss| Estimator::M(MEstimator::new(loss));
    let trimmed = |coverage| Estimator::LeastTrimmed { coverage, seed: 1 };
    vec![
        ("Tukey", m(Loss::TUKEY)),
        ("Hampel", m(Loss::HAMPEL)),
        ("Andrews", m(Loss::ANDREWS)),
        ("least absolute deviations", Estimator::LeastAbsolute),
        ("Lp, p = 1.5", Estimator::Lp { p: 1.5 }),
        ("least trimmed squares, 0.75", trimmed(0.75)),
        ("least trimmed squares, 0.5", trimmed(0.5)),
    ]
}

/// Coverage and width of intervals.
pub struct Coverage {
    /// Mean over the coefficients.
    pub mean: f64,
    /// Coverage of the coefficient that is covered least often.
    pub worst: f64,
    /// Mean width over that of least squares on the same heights.
    pub width: f64,
    /// Share of parts at their limit that conform.
    pub at_limit: f64,
    /// Share of intervals that there are.
    pub given: f64,
}

const TRUTH: [f64; 4] = [1.0, -2.0, 0.5, 3.0];

/// A cubic's row at t in [-1, 1].
fn row(t: f64) -> [f64; 4] {
    [1.0, t, 1.5 * t * t - 0.5, 2.5 * t * t * t - 1.5 * t]
}

fn height(row: &[f64; 4]) -> f64 {
    row.iter().zip(&TRUTH).map(|(x, a)| x * a).sum()
}

fn rows(m: usize) -> Vec<[f64; 4]> {
    (0..m).map(|k| row(2.0 * k as f64 / (m - 1) as f64 - 1.0)).collect()
}

/// Coverage of a further measurement by its band, at ten places for each set of `m` nodes.
pub fn further(estimator: Estimator, errors: Errors, repetitions: u64, m: usize) -> f64 {
    let (x, mut hits, mut all) = (rows(m), 0u64, 0u64);
    for seed in 0..repetitions {
        let mut random = Random::new(700_000 + seed);
        let heights = x.iter().map(|row| height(row) + errors.draw(&mut random)).collect();
        let nodes = Nodes::matrix(x.concat(), 4, heights, None, None).unwrap();
        let at: Vec<[f64; 4]> = (0..10).map(|_| row(random.between(-1.0, 1.0))).collect();
        let kinds = Kinds { confidence: false, prediction: true, simultaneous: false };
        let places = Places::Rows(at.iter().map(|row| row.to_vec()).collect());
        let predict = Some(Predict { at: places, level: None, kinds, slopes: false });
        let spec = FitSpec { estimator, predict, regularization: Regularization::None, ..FitSpec::new(Model::Linear) };
        let band = fit(&nodes, &spec).unwrap().predictions.unwrap().prediction.unwrap();
        for (row, [low, high]) in at.iter().zip(band) {
            let measured = height(row) + errors.draw(&mut random);
            hits += u64::from(low <= measured && measured <= high);
            all += 1;
        }
    }
    hits as f64 / all as f64
}

/// Intervals of a cubic on `m` nodes.
pub fn coverage(estimator: Estimator, errors: Errors, repetitions: u64, m: usize) -> Coverage {
    let x = rows(m);
    let spec = FitSpec { estimator, regularization: Regularization::None, ..FitSpec::new(Model::Linear) };
    coverage_of(&spec, &TRUTH, 0..repetitions, |seed| {
        let mut random = Random::new(90_000 + seed);
        let heights = x.iter().map(|row| height(row) + errors.draw(&mut random)).collect();
        Nodes::matrix(x.concat(), 4, heights, None, None).unwrap()
    })
}

/// Intervals of a surface whose coefficients are all 0.
pub fn coverage_on(design: &Checked, estimator: Estimator, errors: Errors, seeds: Range<u64>) -> Coverage {
    let spec = FitSpec { estimator, ..design.spec.clone() };
    let size = fit(&design.nodes(|_, _| 1.0).unwrap(), &design.spec).unwrap().coefficients.len();
    coverage_of(&spec, &vec![0.0; size], seeds, |seed| {
        let mut random = Random::new(410_000 + seed);
        design.nodes(|_, _| errors.draw(&mut random)).unwrap()
    })
}

fn coverage_of(spec: &FitSpec, truth: &[f64], seeds: Range<u64>, nodes: impl Fn(u64) -> Nodes) -> Coverage {
    let repetitions = (seeds.end - seeds.start) as f64;
    let (mut hits, mut given) = (vec![0u64; truth.len()], vec![0u64; truth.len()]);
    let (mut width, mut plain, mut conform) = (0.0, 0.0, 0);
    for seed in seeds {
        let nodes = nodes(seed);
        let found = fit(&nodes, spec).unwrap();
        let least = fit(&nodes, &FitSpec { estimator: Estimator::LeastSquares, ..spec.clone() }).unwrap();
        for (j, (c, least)) in found.coefficients.iter().zip(least.coefficients).enumerate() {
            let Some(interval) = &c.interval else { continue };
            let ([low, high], [from, to]) = (interval.ends, least.interval.unwrap().ends);
            given[j] += 1;
            hits[j] += u64::from(low <= truth[j] && truth[j] <= high);
            width += high - low;
            plain += to - from;
            let far = 1e9 * (1.0 + truth[j].abs());
            let limits = [[truth[j] - far, truth[j]], [truth[j], truth[j] + far]];
            let conforms = |limits| interval.about.conformity(limits).verdict == ConformityVerdict::Conforms;
            conform += limits.into_iter().filter(|limits| conforms(*limits)).count();
        }
    }
    let share: Vec<f64> = hits.iter().zip(&given).map(|(hits, given)| *hits as f64 / *given as f64).collect();
    let all = given.iter().sum::<u64>() as f64;
    Coverage {
        mean: hits.iter().sum::<u64>() as f64 / all,
        worst: share.into_iter().fold(1.0, f64::min),
        width: width / plain,
        at_limit: conform as f64 / (2.0 * all),
        given: all / (repetitions * truth.len() as f64),
    }
}
