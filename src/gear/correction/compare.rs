//! Whether the machine answered as predicted.
//!
//! Before the correction d was measured, `p = d + JΔ` predicted, and afterwards d' is measured. With independent noise of both measurements
//! (σ each) and entries of J uncertain by η, `d' − p` has at node k the variance `s_k² = 2σ² + u_k²`, `u_k² = η² Σ_j (J_kj Δ_j)²`, if the
//! machine is what J says. Then
//!
//! * `χ² = Σ ((d' − p)/s)²` has as many degrees of freedom as nodes: below its quantile nothing speaks against J;
//! * the predicted change c = JΔ is scaled: `β = Σ c (d' − d)/s² / Σ c²/s²` is how much of it came, with the standard error
//!   `e² = 1/Σ (c/s)² + η² + Σu²/Σc²`. The first part is what independent errors leave, the second is a common error of all of J, and the
//!   third is the most that errors of η can do that whole columns have: β is off by `Σ_j η_j ⟨c, J_j Δ_j⟩/‖c‖²` then, and
//!   `⟨c, J_j Δ_j⟩² ≤ ‖c‖² ‖J_j Δ_j‖²`. Settings that undo each other (‖JΔ‖ far below their single effects) make it great.
//!
//! β c explains what was measured where χ² itself, or that of the rest with a degree of freedom less, is below its quantile, or where at
//! least nine tenths of the misfit are gone.
//!
//! *What a measurement can tell.* The answer of a machine is told from no answer at all (β = 0, everything stays as it was) only where the
//! quantile times e is below 1. Where it is not, a small χ² says nothing: any flank between the one before and one much worse would have
//! been expected.
//!
//! | β c | β | verdict |
//! |---|---|---|
//! | explains | away from 1 by more than e allows | *weaker* (β < 1), *stronger* (β > 1) or, where β is clearly below 0, *different* |
//! | explains | as near to 1 as e allows, told from 0 | *as predicted* |
//! | explains | as near to 1 as e allows, not told from 0 | *undecided* |
//! | does not | any | *different*: another setting, another tool, another workpiece |
//!
//! Quantiles are of probability 0.999, so a machine that is what J says is called something else once or twice in a thousand corrections.
//! A ratio that is not told from 0 is not answered.

use crate::estimation::{
    Faults, FitError, FitSpec, Nodes, fit,
    spec::{Model, Regularization, Scaling},
    words::{Shown, counted, entries},
};

/// 0.999 quantile of the standard normal distribution, one-sided (of χ²), and two-sided (of β).
const ONE_SIDED: f64 = 3.090_232_306_167_813;
const TWO_SIDED: f64 = 3.290_526_731_491_894;
/// Share of the misfit that a scaled prediction must explain where it does not explain all of it.
const EXPLAINED: f64 = 0.9;
/// Numbers are no better than this, relative to the largest deviation.
const ARITHMETIC: f64 = 1e-12;

/// What is compared. Lists have an entry for each node, µm, NaN where undefined.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// d.
    pub before: Vec<f64>,
    /// p.
    pub predicted: Vec<f64>,
    /// d'.
    pub measured: Vec<f64>,
    /// σ, µm.
    pub noise_sigma: f64,
    /// η √Σ (J_kj Δ_j)², as [`super::Predicted::uncertainty`] has it; none by default.
    pub uncertainty: Option<Vec<f64>>,
    /// η, by which all of J may be off together.
    pub response_uncertainty: f64,
}

/// How the machine answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    AsPredicted,
    Weaker,
    Stronger,
    Different,
    /// Noise and the uncertainty of J are so great against the predicted change that no answer could have been told from it.
    Undecided,
}

/// Predicted beside measured, over the nodes that are defined in all three lists.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Nodes compared.
    pub nodes: usize,
    /// Root mean squares, µm.
    pub before_rms: f64,
    pub predicted_rms: f64,
    pub measured_rms: f64,
    /// Of p − d.
    pub predicted_change_rms: f64,
    /// Of d' − p.
    pub difference_rms: f64,
    /// What `difference_rms` is expected to be: √(mean s²).
    pub expected_difference_rms: f64,
    /// β; `None` where it is not told from 0.
    pub response_ratio: Option<f64>,
    /// e.
    pub response_ratio_std_error: Option<f64>,
    pub chi_squared: f64,
    /// The 0.999 quantile that it is held against.
    pub chi_squared_limit: f64,
    pub verdict: Verdict,
    pub sentence: String,
}

/// Compares. Faults point into `{before, predicted, measured, noise_sigma_um, uncertainty}`.
pub fn compare(comparison: &Comparison) -> Result<Answer, FitError> {
    check(comparison)?;
    let Comparison { before, predicted, measured, noise_sigma, uncertainty, response_uncertainty } = comparison;
    let defined: Vec<usize> =
        (0..before.len()).filter(|&k| !(before[k].is_nan() || predicted[k].is_nan() || measured[k].is_nan())).collect();
    if defined.is_empty() {
        return Err(Faults::one("/measured", "no node is defined before, predicted and measured").into());
    }
    let of = |list: &[f64]| defined.iter().map(|&k| list[k]).collect::<Vec<f64>>();
    let (d, p, after) = (of(before), of(predicted), of(measured));
    let largest = d.iter().chain(&p).chain(&after).fold(0.0f64, |most, x| most.max(x.abs()));
    let floor = (ARITHMETIC * largest).max(f64::MIN_POSITIVE.sqrt());
    let u: Vec<f64> = defined.iter().map(|&k| uncertainty.as_ref().map_or(0.0, |u| u[k])).collect();
    let s: Vec<f64> = u.iter().map(|u| (2.0 * noise_sigma * noise_sigma + u * u + floor * floor).sqrt()).collect();
    let m = defined.len();
    let rms = |x: &dyn Fn(usize) -> f64| ((0..m).map(|i| x(i) * x(i)).sum::<f64>() / m as f64).sqrt();
    let chi_squared: f64 = (0..m).map(|i| ((after[i] - p[i]) / s[i]).powi(2)).sum();
    let chi_squared_limit = quantile(m);
    let predicted_change_rms = rms(&|i| p[i] - d[i]);
    let common = response_uncertainty.hypot(rms(&|i| u[i]) / predicted_change_rms);
    let scaled = Scaled::of(&d, &p, &after, &s, common)?;
    let within = chi_squared <= chi_squared_limit;
    let verdict = match &scaled {
        Some(scaled) => scaled.verdict(within, chi_squared, m),
        None if within => Verdict::Undecided,
        None => Verdict::Different,
    };
    let told = scaled.filter(Scaled::told);
    let mut answer = Answer {
        nodes: m,
        before_rms: rms(&|i| d[i]),
        predicted_rms: rms(&|i| p[i]),
        measured_rms: rms(&|i| after[i]),
        predicted_change_rms,
        difference_rms: rms(&|i| after[i] - p[i]),
        expected_difference_rms: rms(&|i| s[i]),
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

/// The measured change as a multiple of the predicted one.
struct Scaled {
    ratio: f64,
    std_error: f64,
    /// χ² of what the multiple leaves.
    left: f64,
}

impl Scaled {
    /// A weighted fit of one column; `None` where no change was predicted. `common` is the part of e that does not depend on s.
    fn of(before: &[f64], predicted: &[f64], after: &[f64], s: &[f64], common: f64) -> Result<Option<Self>, FitError> {
        let change: Vec<f64> = predicted.iter().zip(before).map(|(p, d)| p - d).collect();
        let square: f64 = change.iter().zip(s).map(|(c, s)| (c / s) * (c / s)).sum();
        if !(square > 0.0) {
            return Ok(None);
        }
        let came = after.iter().zip(before).map(|(a, d)| a - d).collect();
        // weights relative to the largest, which squares of small deviations would not be
        let least = s.iter().copied().fold(f64::INFINITY, f64::min);
        let weight = s.iter().map(|s| (least / s) * (least / s)).collect();
        let nodes = Nodes::matrix(change, 1, came, None, Some(weight))?;
        let spec = FitSpec {
            regularization: Regularization::None,
            scaling: Scaling::UnitLength,
            ..FitSpec::new(Model::Linear)
        };
        let fitted = fit(&nodes, &spec)?;
        let ratio = fitted.coefficients[0].value;
        let std_error = (1.0 / square.sqrt()).hypot(common);
        Ok(Some(Scaled { ratio, std_error, left: fitted.residuals.rss / (least * least) }))
    }

    /// Whether the answer could have been told from none.
    fn told(&self) -> bool {
        TWO_SIDED * self.std_error < 1.0
    }

    fn verdict(&self, within: bool, chi_squared: f64, nodes: usize) -> Verdict {
        let explained =
            within || self.left <= quantile(nodes.max(2) - 1) || self.left <= (1.0 - EXPLAINED) * chi_squared;
        let most = TWO_SIDED * self.std_error;
        match explained && (self.ratio - 1.0).abs() > most {
            // the machine went the other way: no multiple of what J says
            true if self.ratio < -most => Verdict::Different,
            true if self.ratio < 1.0 => Verdict::Weaker,
            true => Verdict::Stronger,
            false if explained && self.told() => Verdict::AsPredicted,
            false if explained => Verdict::Undecided,
            false => Verdict::Different,
        }
    }
}

/// 0.999 quantile of χ² (Wilson and Hilferty; within 3 % for one degree of freedom, 1.2 % from five, 0.2 % from thirty on).
fn quantile(freedom: usize) -> f64 {
    let nu = freedom as f64;
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
            "The measurement says nothing about the machine's answer: a change of {:.3} µm rms was predicted, noise and the uncertainty of \
             the sensitivity let measured and predicted differ by {expected:.3} µm, and they differ by {difference:.3} µm.",
            answer.predicted_change_rms
        ),
    }
}

fn check(comparison: &Comparison) -> Result<(), Faults> {
    let mut faults = Faults::default();
    let nodes = comparison.before.len();
    let lists = [
        ("/before", Some(&comparison.before)),
        ("/predicted", Some(&comparison.predicted)),
        ("/measured", Some(&comparison.measured)),
        ("/uncertainty", comparison.uncertainty.as_ref()),
    ];
    for (pointer, list) in lists {
        let Some(list) = list else { continue };
        if list.len() != nodes {
            faults.push(pointer, format!("{} for {}", entries(list.len()), counted(nodes, "node", "nodes")));
        }
        for (k, _) in list.iter().enumerate().filter(|(_, x)| x.is_infinite()) {
            faults.push(format!("{pointer}/{k}"), "the number is infinite");
        }
    }
    for (k, value) in comparison.uncertainty.iter().flatten().enumerate() {
        let undefined = comparison.predicted.get(k).is_none_or(|p| p.is_nan());
        if !(*value >= 0.0 || undefined) {
            faults.push(format!("/uncertainty/{k}"), format!("{value} is not a deviation of at least 0"));
        }
    }
    for (pointer, value) in
        [("/noise_sigma_um", comparison.noise_sigma), ("/response_uncertainty", comparison.response_uncertainty)]
    {
        if !(value.is_finite() && value >= 0.0) {
            faults.push(pointer, format!("{} is not a finite number of at least 0", Shown(value)));
        }
    }
    faults.into_result(())
}
