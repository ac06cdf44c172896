//! Whether the machine answered as predicted.
//!
//! Before the correction d was measured, `p = d + JΔ` predicted, and afterwards d' is measured,
//! with independent noise of both (σ at weight 1). A machine answers with β JΔ, and J itself is
//! uncertain by η. Two questions are asked; docs/mathematics-notes.md derives what stands here.
//!
//! **How much of it came?** With `c = JΔ` and sums over nodes weighted with w, `β̂ = (⟨c, d' − d⟩ −
//! σ² h)/⟨c, c⟩`. Δ was computed from d, so c follows the noise of d: `∂c/∂d = −H`, and `⟨c, d' −
//! d⟩` is too large by `σ² tr H` on average. h is that trace, the sum of the nodes' leverages. The
//! standard error e of β̂ is `e² = (2σ²⟨c, c⟩ + σ⁴ h)/⟨c, c⟩² + η² + η² Σ_j (Σ_k w |c_k J_kj
//! Δ_j|)²/⟨c, c⟩²`: noise of both measurements with the part of it that c carries, a common error
//! of all of J, and the most that errors of η can do in each setting's column however they hang
//! together there.
//!
//! **Is what came a multiple of c at all?** `χ² = rᵀ S⁻¹ r` of `r = d' − p` with `S = diag(2σ²/w +
//! u²) + η² (Σ_j C_j C_jᵀ + c cᵀ)`, `C_kj = J_kj Δ_j`, `u_k² = η² Σ_j C_kj²`, which is no less than
//! the covariance of r whether errors of J are single, of whole columns, or common. β c explains
//! what was measured where χ² of r, or that of `d' − d − β̂c` with a degree of freedom less, is
//! below its quantile, or where at least nine tenths of the misfit are gone.
//!
//! *What a measurement can tell.* The answer of a machine is told from no answer at all (β = 0,
//! everything stays as it was) only where the quantile times e is below 1. Where it is not, a small
//! χ² says nothing, and a β̂ far from 1 says no more than that it is uncertain.
//!
//! | β c | β̂ | verdict |
//! |---|---|---|
//! | explains | e too great to tell an answer from none | *undecided* |
//! | explains | away from 1 by more than e allows | *weaker* (β̂ < 1), *stronger* (β̂ > 1) or, where β̂ is clearly below 0, *different* |
//! | explains | as near to 1 as e allows | *as predicted* |
//! | does not | any | *different*: another setting, another tool, another workpiece |
//!
//! Quantiles are of probability 0.999, so a machine that is what J says is called something else
//! once or twice in a thousand corrections. Where σ was estimated from the residuals of the
//! correction they are those of Student's t and Fisher's F, and *weaker* asks that β̂ be too small
//! without the correction by σ² h as well: such a σ holds form that both measurements share, and
//! which biases nothing. A ratio that is not told from 0 is not answered.

use std::collections::BTreeMap;

use nalgebra::{Cholesky, DMatrix, DVector};

use super::{
    fault::{ComparisonFaults, ComparisonField, ComparisonReason, ComparisonRefused, NodeList},
    problem::Correction,
    solution::Noise,
};
use crate::{
    estimation::{FitError, Unconverged},
    fault::Common,
    numerics::fisher,
};

/// 0.999 quantile of the standard normal distribution, one-sided (of χ²), and two-sided (of β).
const ONE_SIDED: f64 = 3.090_232_306_167_813;
const TWO_SIDED: f64 = 3.290_526_731_491_894;
/// What the quantiles leave.
const TAIL: f64 = 0.001;
/// Share of the misfit that a scaled prediction must explain where it does not explain all of it.
const EXPLAINED: f64 = 0.9;
/// Numbers are no better than this, relative to the largest deviation.
const ARITHMETIC: f64 = 1e-12;

/// What is compared. Lists have an entry for each node, µm, NaN where undefined.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// d.
    pub before: Vec<f64>,
    /// d'.
    pub measured: Vec<f64>,
    /// Relative 1/σ² of both measurements; nodes of weight 0 take no part. 1 by default.
    pub weight: Option<Vec<f64>>,
    /// How many settings there are.
    pub settings: usize,
    /// What each setting does to each node, J_kj Δ_j, row by row; their sum is the predicted change
    /// c (about its mean, without a datum).
    pub contributions: Vec<f64>,
    /// −∂c_k/∂d_k, as [`super::Solution::leverage`] has it; none where c was not computed from d.
    pub leverage: Option<Vec<f64>>,
    /// σ of both measurements, and how well it is known.
    pub noise: Noise,
    /// η.
    pub response_uncertainty: f64,
    /// Whether deviations have a datum; if not, all lists are compared about their means.
    pub absolute: bool,
    /// Without a datum: the trace of each node, where every trace has a zero of its own.
    pub traces: Option<Vec<usize>>,
}

impl Correction {
    /// What is compared when the settings were changed by `change` and the flank then measured as
    /// `measured`.
    pub fn comparison(&self, change: &[f64], leverage: Vec<f64>, noise: Noise, measured: Vec<f64>) -> Comparison {
        let asked = self.asked();
        Comparison {
            before: asked.deviation.clone(),
            measured,
            weight: asked.weight.clone(),
            settings: change.len(),
            contributions: (0..asked.deviation.len())
                .flat_map(|k| self.told_row(k).iter().zip(change).map(|(j, c)| j * c))
                .collect(),
            leverage: Some(leverage),
            noise,
            response_uncertainty: asked.response_uncertainty,
            absolute: asked.absolute,
            traces: asked.traces.clone(),
        }
    }
}

/// How the machine answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// β̂ is as near to 1 as its error allows.
    AsPredicted,
    /// β̂ is below 1 by more than its error allows.
    Weaker,
    /// β̂ is above 1 by more than its error allows.
    Stronger,
    /// What came is no multiple of the predicted change, or has its opposite sign: another setting,
    /// another tool, another workpiece.
    Different,
    /// Noise and the uncertainty of J are so great against the predicted change that no answer
    /// could have been told from it.
    Undecided,
}

/// Predicted beside measured, over the nodes that are defined before and after and have a weight
/// above 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Nodes compared.
    pub nodes: usize,
    /// Root mean squares, µm, each node counting alike; about the means where deviations have no
    /// datum.
    pub before_rms: f64,
    /// Of p.
    pub predicted_rms: f64,
    /// Of d'.
    pub measured_rms: f64,
    /// Of p − d.
    pub predicted_change_rms: f64,
    /// Of d' − p.
    pub difference_rms: f64,
    /// What `difference_rms` is expected to be: √(mean (2σ²/w + u²)).
    pub expected_difference_rms: f64,
    /// β̂; `None` where it is not told from 0.
    pub response_ratio: Option<f64>,
    /// e.
    pub response_ratio_std_error: Option<f64>,
    /// χ² = rᵀ S⁻¹ r of r = d' − p.
    pub chi_squared: f64,
    /// The 0.999 quantile that it is held against; where σ was estimated, that of F times the
    /// number of nodes.
    pub chi_squared_limit: f64,
    /// What follows from these figures.
    pub verdict: Verdict,
    /// The verdict in words, with the figures that it rests on.
    pub sentence: String,
}

/// Compares.
pub fn compare(comparison: &Comparison) -> Result<Answer, ComparisonRefused> {
    check(comparison)?;
    let nodes = Counted::of(comparison);
    if nodes.before.is_empty() {
        let field = ComparisonField::List(NodeList::Measured);
        return Err(ComparisonFaults::one(field, ComparisonReason::NoNodes).into());
    }
    let m = nodes.before.len();
    let freedom = comparison.noise.freedom;
    let rms = |x: &dyn Fn(usize) -> f64| ((0..m).map(|i| x(i) * x(i)).sum::<f64>() / m as f64).sqrt();
    let predicted = |i: usize| nodes.before[i] + nodes.change[i];
    let left = |beta: f64| -> Vec<f64> { (0..m).map(|i| nodes.came[i] - beta * nodes.change[i]).collect() };
    let eta = comparison.response_uncertainty;
    let covariance = Covariance::of(&nodes, eta, eta).ok_or(NOT_DEFINITE)?;
    let chi_squared = covariance.square(&left(1.0));
    let alone = |r: &[f64]| r.iter().zip(&nodes.variance).map(|(r, s)| r * r / s).sum::<f64>();
    // what all nodes (of a trace) have in common is left aside
    let free = m.saturating_sub(nodes.means).max(1);
    let chi_squared_limit = quantile(free, freedom);
    let scaled = Scaled::of(&nodes, comparison);
    let within = chi_squared <= chi_squared_limit;
    let multiple = |scaled: &Scaled| {
        let rest = left(scaled.ratio);
        // a machine that answers more strongly has greater errors too
        let greater = Covariance::of(&nodes, eta, eta * scaled.ratio.abs().max(1.0));
        greater.is_some_and(|greater| greater.square(&rest) <= quantile(free.max(2) - 1, freedom))
            || alone(&rest) <= (1.0 - EXPLAINED) * alone(&left(1.0))
    };
    let explained = within || scaled.as_ref().is_some_and(multiple);
    let verdict = match &scaled {
        _ if !explained => Verdict::Different,
        Some(scaled) => scaled.verdict(),
        None => Verdict::Undecided,
    };
    let told = scaled.filter(Scaled::told);
    let mut answer = Answer {
        nodes: m,
        before_rms: rms(&|i| nodes.before[i]),
        predicted_rms: rms(&predicted),
        measured_rms: rms(&|i| nodes.before[i] + nodes.came[i]),
        predicted_change_rms: rms(&|i| nodes.change[i]),
        difference_rms: rms(&|i| nodes.came[i] - nodes.change[i]),
        expected_difference_rms: (nodes.variance.iter().sum::<f64>() / m as f64).sqrt(),
        response_ratio: told.as_ref().map(|told| told.ratio),
        response_ratio_std_error: told.map(|told| told.std_error),
        chi_squared,
        chi_squared_limit,
        verdict,
        sentence: String::new(),
    };
    answer.sentence = sentence(&answer);
    Ok(answer)
}

const NOT_DEFINITE: FitError = FitError::NotConverged(Unconverged::Comparison);

/// The nodes that are compared.
struct Counted {
    before: Vec<f64>,
    /// d' − d.
    came: Vec<f64>,
    /// c.
    change: Vec<f64>,
    weight: Vec<f64>,
    /// C, a row for each node.
    contributions: Vec<Vec<f64>>,
    /// 2σ²/w + u², and what rounding leaves.
    variance: Vec<f64>,
    /// u²/η².
    single: Vec<f64>,
    /// Σ of the leverages.
    leverage: f64,
    /// How many means were taken off.
    means: usize,
}

impl Counted {
    fn of(comparison: &Comparison) -> Self {
        let Comparison { before, measured, contributions, settings, noise, .. } = comparison;
        let weight = |k: usize| comparison.weight.as_ref().map_or(1.0, |weight| weight[k]);
        let counted: Vec<usize> =
            (0..before.len()).filter(|&k| !(before[k].is_nan() || measured[k].is_nan()) && weight(k) > 0.0).collect();
        let list = |of: &dyn Fn(usize) -> f64| counted.iter().map(|&k| of(k)).collect::<Vec<f64>>();
        let group = |k: usize| comparison.traces.as_ref().map_or(0, |traces| traces[k]);
        // mean of each trace, or of all nodes
        let mean = |of: &dyn Fn(usize) -> f64| -> BTreeMap<usize, f64> {
            let mut sums: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
            for &k in counted.iter().filter(|_| !comparison.absolute) {
                let [sum, whole] = sums.entry(group(k)).or_default();
                (*sum, *whole) = (*sum + weight(k) * of(k), *whole + weight(k));
            }
            sums.into_iter().map(|(group, [sum, whole])| (group, sum / whole)).collect()
        };
        let about = |means: &BTreeMap<usize, f64>, k: usize| means.get(&group(k)).copied().unwrap_or(0.0);
        let means: Vec<_> = (0..*settings).map(|j| mean(&|k| contributions[k * settings + j])).collect();
        let row = |k: usize| -> Vec<f64> {
            let row = &contributions[k * settings..(k + 1) * settings];
            row.iter().zip(&means).map(|(c, means)| c - about(means, k)).collect()
        };
        let (level, moved) = (mean(&|k| before[k]), mean(&|k| measured[k] - before[k]));
        let change = list(&|k| row(k).iter().sum());
        let largest = counted
            .iter()
            .zip(&change)
            .fold(0.0f64, |most, (&k, c)| most.max(before[k].abs()).max(measured[k].abs()).max((before[k] + c).abs()));
        let floor = (ARITHMETIC * largest).max(f64::MIN_POSITIVE.sqrt());
        let eta = comparison.response_uncertainty;
        let single = list(&|k| contributions[k * settings..(k + 1) * settings].iter().map(|c| c * c).sum());
        let variance = counted
            .iter()
            .zip(&single)
            .map(|(&k, u)| 2.0 * noise.sigma * noise.sigma / weight(k) + eta * eta * u + floor * floor)
            .collect();
        Counted {
            before: list(&|k| before[k] - about(&level, k)),
            came: list(&|k| measured[k] - before[k] - about(&moved, k)),
            means: level.len(),
            change,
            weight: list(&weight),
            contributions: counted.iter().map(|&k| row(k)).collect(),
            variance,
            single,
            leverage: comparison.leverage.as_ref().map_or(0.0, |leverage| counted.iter().map(|&k| leverage[k]).sum()),
        }
    }
}

/// S for errors of J of the size `eta`, by what Woodbury's identity needs of it: with N its
/// diagonal and B the columns η C_j and η c, `rᵀ S⁻¹ r = rᵀN⁻¹r − ‖L⁻¹ BᵀN⁻¹r‖²`, `L Lᵀ = I +
/// BᵀN⁻¹B`.
struct Covariance {
    diagonal: Vec<f64>,
    /// N^(-1/2) B.
    columns: DMatrix<f64>,
    inner: Cholesky<f64, nalgebra::Dyn>,
}

impl Covariance {
    fn of(nodes: &Counted, told: f64, eta: f64) -> Option<Self> {
        let settings = nodes.contributions.first()?.len();
        let more = eta * eta - told * told;
        let diagonal: Vec<f64> = nodes.variance.iter().zip(&nodes.single).map(|(s, u)| s + more * u).collect();
        let columns = DMatrix::from_fn(nodes.before.len(), settings + 1, |i, j| {
            let entry = nodes.contributions[i].get(j).copied().unwrap_or(nodes.change[i]);
            eta * entry / diagonal[i].sqrt()
        });
        let inner = Cholesky::new(DMatrix::identity(settings + 1, settings + 1) + columns.tr_mul(&columns))?;
        Some(Covariance { diagonal, columns, inner })
    }

    fn square(&self, r: &[f64]) -> f64 {
        let r = DVector::from_iterator(r.len(), r.iter().zip(&self.diagonal).map(|(r, s)| r / s.sqrt()));
        let along = self.columns.tr_mul(&r);
        (r.norm_squared() - along.dot(&self.inner.solve(&along))).max(0.0)
    }
}

/// The measured change as a multiple of the predicted one.
struct Scaled {
    /// β̂.
    ratio: f64,
    /// The same with the least correction for noise that is possible.
    largest: f64,
    std_error: f64,
    /// Quantile that differences are held against.
    quantile: f64,
}

impl Scaled {
    /// `None` where no change was predicted.
    fn of(nodes: &Counted, comparison: &Comparison) -> Option<Self> {
        let Comparison { noise: Noise { sigma, freedom }, response_uncertainty: eta, settings, .. } = comparison;
        let m = nodes.change.len();
        // relative to the largest change, which squares of small ones would not be
        let unit = nodes.change.iter().fold(0.0f64, |most, c| most.max(c.abs()));
        let c: Vec<f64> = nodes.change.iter().map(|c| c / unit).collect();
        let square: f64 = (0..m).map(|i| nodes.weight[i] * c[i] * c[i]).sum();
        if !(square > 0.0) {
            return None;
        }
        let sigma = sigma / unit;
        let noise = sigma * sigma / square;
        let raw = (0..m).map(|i| nodes.weight[i] * c[i] * nodes.came[i]).sum::<f64>() / (unit * square);
        let ratio = raw - noise * nodes.leverage;
        let columns: f64 = (0..*settings)
            .map(|j| {
                (0..m).map(|i| nodes.weight[i] * (c[i] * nodes.contributions[i][j] / unit).abs()).sum::<f64>() / square
            })
            .map(|most| most * most)
            .sum();
        // of σ²h, where σ is estimated
        let uncertain = freedom.map_or(0.0, |freedom| 2.0 / freedom.max(1) as f64 * nodes.leverage * nodes.leverage);
        let variance = 2.0 * noise + noise * noise * (nodes.leverage + uncertain) + eta * eta * (1.0 + columns);
        let quantile = freedom.map_or(TWO_SIDED, |freedom| fisher::student_two_sided(TAIL, freedom.max(1) as f64));
        let largest = if freedom.is_some() { raw } else { ratio };
        Some(Scaled { ratio, largest, std_error: variance.sqrt(), quantile })
    }

    /// Whether the answer could have been told from none.
    fn told(&self) -> bool {
        self.quantile * self.std_error < 1.0
    }

    /// Of a change that is a multiple of the predicted one.
    fn verdict(&self) -> Verdict {
        let most = self.quantile * self.std_error;
        match () {
            () if !self.told() => Verdict::Undecided,
            // the machine went the other way: no multiple of what J says
            () if self.largest < -most => Verdict::Different,
            () if self.largest < 1.0 - most => Verdict::Weaker,
            () if self.ratio > 1.0 + most => Verdict::Stronger,
            () => Verdict::AsPredicted,
        }
    }
}

/// 0.999 quantile of χ² (Wilson and Hilferty; within 3 % for one degree of freedom, 1.2 % from
/// five, 0.2 % from thirty on), or of F times its degrees of freedom where σ was estimated from
/// some.
fn quantile(freedom: usize, of_sigma: Option<usize>) -> f64 {
    let nu = freedom as f64;
    if let Some(of_sigma) = of_sigma {
        return nu * fisher::upper_quantile(TAIL, nu, of_sigma.max(1) as f64);
    }
    let spread = 2.0 / (9.0 * nu);
    nu * (1.0 - spread + ONE_SIDED * spread.sqrt()).powi(3)
}

fn sentence(answer: &Answer) -> String {
    let Answer { difference_rms: difference, expected_difference_rms: expected, .. } = answer;
    let came = answer
        .response_ratio
        .map_or(String::new(), |ratio| format!(", {:.0} % of the predicted change came", 100.0 * ratio));
    let apart = format!("measured and predicted differ by {difference:.3} µm rms, {expected:.3} µm are expected{came}");
    match answer.verdict {
        Verdict::AsPredicted => format!("The machine answered as predicted: {apart}."),
        Verdict::Weaker => format!("The machine answered more weakly than predicted: {apart}."),
        Verdict::Stronger => format!("The machine answered more strongly than predicted: {apart}."),
        Verdict::Different => format!("The machine answered differently: {apart}."),
        Verdict::Undecided => format!(
            "The measurement says nothing about the machine's answer: a change of {:.3} µm rms was predicted, noise \
             and the uncertainty of \
             the sensitivity let measured and predicted differ by {expected:.3} µm, and they differ by {difference:.3} \
             µm.",
            answer.predicted_change_rms
        ),
    }
}

fn check(comparison: &Comparison) -> Result<(), ComparisonFaults> {
    let mut faults = ComparisonFaults::default();
    let nodes = comparison.before.len();
    let lists = [
        (NodeList::Measured, Some(&comparison.measured), true),
        (NodeList::Weight, comparison.weight.as_ref(), false),
        (NodeList::Leverage, comparison.leverage.as_ref(), false),
        (NodeList::Before, Some(&comparison.before), true),
    ];
    if let Some(traces) = comparison.traces.as_ref().filter(|traces| traces.len() != nodes) {
        faults.push(ComparisonField::Traces, Common::PerNode { given: traces.len(), nodes });
    }
    for (list, values, signed) in lists {
        let Some(values) = values else { continue };
        if values.len() != nodes {
            faults.push(ComparisonField::List(list), Common::PerNode { given: values.len(), nodes });
        }
        for (index, value) in values.iter().enumerate() {
            if value.is_infinite() {
                faults.push(ComparisonField::Entry { list, index }, ComparisonReason::Infinite);
            } else if !(signed || *value >= 0.0) {
                faults.push(ComparisonField::Entry { list, index }, ComparisonReason::Negative(*value));
            }
        }
    }
    let wanted = nodes.saturating_mul(comparison.settings);
    if comparison.contributions.len() != wanted {
        let given = comparison.contributions.len();
        faults.push(ComparisonField::Contributions, ComparisonReason::Contributions { given, wanted });
    }
    if let Some(index) = comparison.contributions.iter().position(|c| !c.is_finite()) {
        faults.push(ComparisonField::Contribution { index }, ComparisonReason::Contribution);
    }
    for (field, value) in [
        (ComparisonField::NoiseSigma, comparison.noise.sigma),
        (ComparisonField::ResponseUncertainty, comparison.response_uncertainty),
    ] {
        if !(value.is_finite() && value >= 0.0) {
            faults.push(field, Common::Negative { value });
        }
    }
    faults.into_result(())
}
