//! Noise of a trace, separated from what is systematic.
//!
//! Crowning, reliefs and waviness are the flank's: measured again they come again. Noise is
//! autoregressive, `e_i = ρ e_{i−1} + ε_i`, with the spectrum `σ²/(1 − 2ρ cos ω + ρ²)`; what the
//! flank has in addition is smooth, and shows in the lowest modes of a cosine transform. The
//! parabola is taken off first. Holes, and corners, steps and outliers, where second differences
//! are above four times what is usual, divide the trace into segments with a transform each.
//!
//! How many modes are the flank's and how large ρ is, is not known. Each of them has a level of its
//! own with a prior proportional to its inverse, at the price [`PRICE`]; the others are normal with
//! the spectrum of noise. The likelihood of each number of modes and each ρ weighs the variance
//! that follows for a slope. The result is the inverse χ² whose logarithm has the weighted mean and
//! spread, so that its degrees of freedom hold what the candidates differ by. ρ = 0 has the prior
//! probability [`INDEPENDENT`].
//!
//! Long traces are averaged over blocks first ([`BLOCKS`]): noise that filters leave is independent
//! from block to block. An error that is the same all along a trace (alignment, drift, temperature)
//! cannot be separated from the flank and is not in this number; nor can noise that is correlated
//! over a good part of the trace, so that few samples are left ([`FEWEST_EFFECTIVE`]) and a warning
//! says so.
//!
//! A cosine transform continues a segment by its mirror image. The slopes of a smooth flank at the
//! ends are then corners, whose powers fall as `1/sin⁴(ω/2)`; with many segments they are as great
//! as correlated noise, whose powers fall as `1/sin²(ω/2)`. Where they fall like corners there is
//! no warning; the intervals stay as wide.

use std::f64::consts::PI;

use super::{mean_curve::MeanCurves, spacing::Spacing, warning::TraceWarning};
use flankfit_estimation::inference::{Doubts, Inferred};
use flankfit_numerics::{
    cancel,
    distribution::{Student, normal},
    quantiles::median,
};

/// Fewest modes that determine the noise.
const FEWEST_MODES: usize = 8;
/// Blocks of the trace at least.
const BLOCKS: usize = 128;
/// Median of squares of a standard normal variable.
const MEDIAN_SQUARE: f64 = 0.454_936_423_119_572_8;
/// Greater second differences are no noise, in standard deviations.
const CUT: f64 = 4.0;
/// Corners are looked for over this share of the samples, too.
const CORNERS: usize = 24;
/// Modes that the parabola has taken.
const OF_PARABOLA: usize = 3;
/// Samples of a segment at least.
const SHORTEST: usize = 8;
/// Step of (1 + ρ)/(1 − ρ), the variance of a long mean over that of independent noise.
const STEP: f64 = 1.5;
/// The greatest of them, as a share of the samples.
const MOST: f64 = 0.22;
/// Prior probability of independent noise.
const INDEPENDENT: f64 = 0.75;
/// Logarithm of the range that the level of a mode of the flank may be in, against that of noise.
const PRICE: f64 = 2.2;
/// Probability of independent noise below which a correlation is significant.
const SIGNIFICANT: f64 = 0.05;
/// Share of the mean square of form and noise below which noise is in no doubt.
const NEGLIGIBLE: f64 = 1e-3;
/// Levels of independent noise in the ends of smooth segments, relative to their spectrum.
const FLOORS: [f64; 9] = [0.0, 1e-3, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0];
/// Logarithm of the odds from which on samples with holes show a smooth flank, not correlated
/// noise: 20.
const SMOOTH: f64 = 2.996;
/// Samples without correlation that determine a slope as well, below which intervals may not hold.
const FEWEST_EFFECTIVE: f64 = 24.0;

/// A variance that was estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct EstimatedVariance {
    pub value: f64,
    /// Degrees of freedom of the χ² that is spread about its mean as much (Satterthwaite).
    pub freedom: f64,
    /// Warnings that it may be greater.
    pub doubts: Doubts,
}

impl EstimatedVariance {
    /// Returns the variance of the sum of independent variables.
    pub(crate) fn sum(parts: impl Iterator<Item = EstimatedVariance> + Clone) -> Self {
        let value: f64 = parts.clone().map(|part| part.value).sum();
        let spread: f64 = parts.clone().map(|part| part.value * part.value / part.freedom).sum();
        // without noise all that is known is how much there was to tell it by
        let freedom = if spread > 0.0 { value * value / spread } else { parts.clone().map(|part| part.freedom).sum() };
        let doubts = parts.fold(Doubts::default(), |doubts, part| doubts.or(part.doubts));
        EstimatedVariance { value, freedom, doubts }
    }

    /// An estimate whose variance this is.
    pub(crate) fn about(&self, value: f64) -> Inferred {
        let student = Student::new(self.freedom.max(1.0));
        Inferred { value, std_error: self.value.sqrt(), student, doubts: self.doubts, ..Inferred::default() }
    }
}

/// Noise of a trace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TraceNoise {
    /// Variance of independent samples whose slope would be as uncertain.
    pub variance: EstimatedVariance,
    /// Correlation that leaves intervals in doubt.
    pub correlation: Option<Correlation>,
}

/// Correlation of the noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Correlation {
    /// Samples without correlation that would determine a slope as well.
    pub effective: f64,
    /// Factor of the standard error by the strongest correlation that is not excluded at 0.95.
    pub factor: f64,
}

impl Correlation {
    /// Returns the warning of a trace of `count` samples.
    pub(crate) fn warning(&self, count: usize) -> TraceWarning {
        TraceWarning::CorrelatedNoise { count, effective: self.effective, factor: self.factor }
    }
}

/// A number of modes of the flank and a correlation.
struct Candidate {
    log_likelihood: f64,
    correlated: bool,
    /// (1 + ρ)/(1 − ρ), less what a short trace takes from it.
    inflation: f64,
    /// Mean of the logarithm of the variance for a slope.
    log_variance: f64,
    freedom: f64,
}

/// Returns the noise; `None` where the samples are too few.
pub(crate) fn noise(u: &[f64], deviation: &[f64], spacing: &Spacing) -> Option<TraceNoise> {
    let block = (u.len() / BLOCKS).max(1);
    let parabola = MeanCurves::of(u, deviation, &spacing.weight);
    let each: Vec<f64> = u.iter().zip(deviation).map(|(&u, deviation)| deviation - parabola.parabola(u)).collect();
    let means: Vec<f64> = each.chunks_exact(block).map(|chunk| chunk.iter().sum::<f64>() / block as f64).collect();
    let crosses = |i: usize| spacing.crosses(u[i * block], u[(i + 3) * block - 1]);
    // cuts that leave less than half are chance among few samples
    let modes = |cut: f64| Some(modes(&means, cut, crosses)).filter(|(modes, _)| modes.len() >= FEWEST_MODES);
    let (modes, segments) =
        modes(CUT).filter(|(modes, _)| modes.len() >= means.len() / 2).or_else(|| modes(f64::INFINITY))?;
    let mean = modes.iter().map(|[_, power]| power).sum::<f64>() / modes.len() as f64;
    if !mean.is_finite() {
        return None;
    }
    if mean == 0.0 {
        let variance = EstimatedVariance { freedom: modes.len() as f64, ..EstimatedVariance::default() };
        return Some(TraceNoise { variance, correlation: None });
    }
    let candidates = candidates(&modes, mean, means.len());
    let most = candidates.iter().map(|one| one.log_likelihood).fold(f64::NEG_INFINITY, f64::max);
    let weight = |one: &Candidate| (one.log_likelihood - most).exp();
    let total: f64 = candidates.iter().map(weight).sum();
    let expected =
        |of: &dyn Fn(&Candidate) -> f64| candidates.iter().map(|one| weight(one) * of(one)).sum::<f64>() / total;
    let log = expected(&|one| one.log_variance);
    let between = expected(&|one| (one.log_variance - log).powi(2));
    let spread = expected(&|one| 2.0 / one.freedom) + between;
    // ψ'(x) ≈ 1/x + 1/(2x²) is the spread, ψ(x) − ln x ≈ −1/(2x) − 1/(12x²) that of the mean
    let x = (1.0 + (1.0 + 2.0 * spread).sqrt()) / (2.0 * spread);
    let log = log - 0.5 / x - 1.0 / (12.0 * x * x);
    let independent = expected(&|one| f64::from(u8::from(!one.correlated)));
    let effective = u.len() as f64 / (block as f64 * expected(&|one| one.inflation.ln()).exp());
    let value = mean * block as f64 * log.exp();
    let square = |list: &[f64]| list.iter().map(|d| d * d).sum::<f64>() / u.len() as f64;
    let negligible = NEGLIGIBLE * square(&each) + f64::EPSILON * square(deviation);
    let is_divided = segments > 1 || !spacing.missing.is_empty();
    let doubtful = independent < SIGNIFICANT
        && effective < FEWEST_EFFECTIVE
        && value > negligible
        && !(is_divided && is_smooth(&modes, mean, means.len(), &candidates));
    let doubts = doubtful.then_some("correlated_noise").into_iter().collect();
    let factor = (0.5 * normal::upper_quantile(0.05) * spread.sqrt()).exp();
    Some(TraceNoise {
        variance: EstimatedVariance { value, freedom: 2.0 * x, doubts },
        correlation: doubtful.then_some(Correlation { effective, factor }),
    })
}

/// Frequencies and powers of the modes of all segments, the lowest first, and how many segments.
fn modes(left: &[f64], cut: f64, crosses: impl Fn(usize) -> bool) -> (Vec<[f64; 2]>, usize) {
    let mut smooth: Vec<bool> = sharp(left, 1, cut).iter().enumerate().map(|(i, bend)| !bend && !crosses(i)).collect();
    // a corner bends distant samples more than neighbours, and lies in the middle of them
    let (lag, mut from) = (left.len() / CORNERS, 0);
    if lag > 1 {
        for run in sharp(left, lag, cut).chunk_by(|a, b| a == b) {
            if run[0] {
                smooth[from + run.len() / 2 + lag - 1] = false;
            }
            from += run.len();
        }
    }
    let (mut modes, mut segments, mut from) = (Vec::new(), 0, 0);
    for run in smooth.chunk_by(|a, b| a == b) {
        let to = from + run.len();
        if run[0] && run.len() + 2 >= SHORTEST {
            modes.extend(transformed(&left[from..to + 2]));
            segments += 1;
        }
        from = to;
    }
    modes.sort_by(|a, b| a[0].total_cmp(&b[0]));
    (modes, segments)
}

/// Which second differences of samples `lag` apart are above `cut` usual ones.
fn sharp(left: &[f64], lag: usize, cut: f64) -> Vec<bool> {
    let bends: Vec<f64> = left.windows(2 * lag + 1).map(|w| (w[0] - 2.0 * w[lag] + w[2 * lag]).powi(2)).collect();
    let usual = if bends.is_empty() { 0.0 } else { median(&mut bends.clone()) / MEDIAN_SQUARE };
    // of rounded numbers more than half may be 0
    let limit = if usual > 0.0 { cut * cut * usual } else { f64::INFINITY };
    bends.iter().map(|bend| *bend > limit).collect()
}

/// Cosine transform of what the parabola of a segment leaves.
fn transformed(segment: &[f64]) -> impl Iterator<Item = [f64; 2]> {
    let n = segment.len();
    let u: Vec<f64> = (0..n).map(|i| (2 * i + 1) as f64 / n as f64 - 1.0).collect();
    let parabola = MeanCurves::of(&u, segment, &vec![1.0; n]);
    let left: Vec<f64> = u.iter().zip(segment).map(|(&u, x)| x - parabola.parabola(u)).collect();
    let cosines: Vec<f64> = (0..4 * n).map(|j| (PI * j as f64 / (2 * n) as f64).cos()).collect();
    (OF_PARABOLA..n).map(move |k| {
        cancel::checkpoint();
        let sum: f64 = left.iter().enumerate().map(|(i, x)| x * cosines[k * (2 * i + 1) % (4 * n)]).sum();
        [PI * k as f64 / n as f64, 2.0 / n as f64 * sum * sum]
    })
}

/// Numbers of modes that may belong to the flank.
fn cuts(modes: &[[f64; 2]], n: usize) -> Vec<usize> {
    let cuts = (1..).map(|j| 1usize << j).take_while(|cut| 2 * cut <= n);
    cuts.map(|cut| modes.partition_point(|[at, _]| *at < PI * (cut as f64 + 0.5) / n as f64)).collect()
}

/// Powers relative to their mean, and the logarithm by which each is less likely as the flank's.
fn powers(modes: &[[f64; 2]], mean: f64) -> (Vec<f64>, Vec<f64>) {
    let powers: Vec<f64> = modes.iter().map(|[_, power]| (power / mean).max(f64::EPSILON)).collect();
    let of_flank = powers.iter().map(|power| 0.5 * power.ln() + PRICE).collect();
    (powers, of_flank)
}

/// True if the modes are those of the ends of smooth segments with independent noise, rather than
/// of correlated noise.
fn is_smooth(modes: &[[f64; 2]], mean: f64, n: usize, candidates: &[Candidate]) -> bool {
    let (powers, of_flank) = powers(modes, mean);
    let corners: Vec<f64> = modes.iter().map(|[at, _]| (2.0 * (0.5 * at).sin()).powi(-4)).collect();
    let prior = ((1.0 - INDEPENDENT) / FLOORS.len() as f64).ln();
    let mut smooth = Vec::new();
    for floor in FLOORS {
        for cut in cuts(modes, n) {
            let shape = || corners[cut..].iter().map(|corner| corner + floor);
            let count = (modes.len() - cut) as f64;
            let level = shape().zip(&powers[cut..]).map(|(shape, power)| power / shape).sum::<f64>() / count;
            let of_noise = 0.5 * (count * (level.ln() + 1.0 + (2.0 * PI).ln()) + shape().map(f64::ln).sum::<f64>());
            smooth.push(prior - of_noise - of_flank[..cut].iter().sum::<f64>());
        }
    }
    let correlated: Vec<f64> = candidates.iter().filter(|one| one.correlated).map(|one| one.log_likelihood).collect();
    log_sum(&smooth) > log_sum(&correlated) + SMOOTH
}

/// ln Σ exp.
fn log_sum(logs: &[f64]) -> f64 {
    let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    most + logs.iter().map(|log| (log - most).exp()).sum::<f64>().ln()
}

/// All numbers of modes and correlations of `n` samples, powers relative to their mean.
fn candidates(modes: &[[f64; 2]], mean: f64, n: usize) -> Vec<Candidate> {
    let steps = ((MOST * n as f64).ln() / STEP.ln()).floor().max(1.0) as i32;
    let correlation = |k: i32| (STEP.powi(k) - 1.0) / (STEP.powi(k) + 1.0);
    // half-way to the neighbours on both sides
    let whole = correlation(steps + 1) + correlation(steps) - correlation(1);
    let share = |k: i32| match k {
        0 => INDEPENDENT,
        k => (1.0 - INDEPENDENT) * (correlation(k + 1) - correlation(k - 1)) / whole,
    };
    let cuts = cuts(modes, n);
    let (powers, of_flank) = powers(modes, mean);
    let cosines: Vec<f64> = modes.iter().map(|[frequency, _]| frequency.cos()).collect();
    let mut found = Vec::with_capacity(cuts.len() * (steps + 1) as usize);
    for k in 0..=steps {
        let rho = correlation(k);
        let inflation = inflation(n, rho);
        let inverse: Vec<f64> = cosines.iter().map(|cosine| 1.0 - 2.0 * rho * cosine + rho * rho).collect();
        let logs: Vec<f64> = inverse.iter().map(|inverse| inverse.ln()).collect();
        for &cut in &cuts {
            let count = (modes.len() - cut) as f64;
            let square: f64 = inverse[cut..].iter().zip(&powers[cut..]).map(|(inverse, power)| inverse * power).sum();
            let variance = square / count;
            let of_noise = 0.5 * (count * (variance.ln() + 1.0 + (2.0 * PI).ln()) - logs[cut..].iter().sum::<f64>());
            found.push(Candidate {
                log_likelihood: share(k).ln() - of_noise - of_flank[..cut].iter().sum::<f64>(),
                correlated: k > 0,
                inflation: inflation * (1.0 - rho * rho),
                log_variance: (variance * inflation).ln() + count.recip(),
                freedom: count,
            });
        }
    }
    found
}

/// Variance of the slope of `n` samples for σ = 1, over that of independent noise.
fn inflation(n: usize, rho: f64) -> f64 {
    let (mut square, mut across, mut carried) = (0.0, 0.0, 0.0);
    for i in 0..n {
        let factor = i as f64 - 0.5 * (n - 1) as f64;
        square += factor * factor;
        across += factor * carried;
        carried = rho * (carried + factor);
    }
    (1.0 + 2.0 * across / square) / (1.0 - rho * rho)
}
