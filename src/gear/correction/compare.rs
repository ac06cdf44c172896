//! Whether the machine answered as predicted.
//!
//! Before the correction d was measured, `p = d + JΔ` predicted, and afterwards d' is measured. With independent noise of both measurements
//! (σ each) and entries of J uncertain by η, `d' − p` has at node k the variance `s_k² = 2σ² + η² Σ_j (J_kj Δ_j)²` if the machine is what J
//! says. Then
//!
//! * `χ² = Σ ((d' − p)/s)²` has as many degrees of freedom as nodes: below its quantile the answer is *as predicted*;
//! * else the predicted change c = JΔ is scaled: `β = Σ c (d' − d)/s² / Σ c²/s²`, with the standard error `1/√(Σ c²/s²)`. Where β c is what was
//!   measured (χ² of the rest, a degree of freedom less, below its quantile, or at least nine tenths of the misfit explained) and β is
//!   away from 1 by more than its error and a common error η of J allow, the machine answered *weaker* (β < 1) or *stronger* (β > 1);
//! * where β c explains what was measured and β is as near to 1 as those errors allow, the answer is *as predicted* too;
//! * else *different*: another setting, another tool, another workpiece.
//!
//! Quantiles are of probability 0.999, so a machine that is what J says is called something else once in a thousand corrections.

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
}

impl Verdict {
    /// As the interface writes it.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::AsPredicted => "as_predicted",
            Verdict::Weaker => "weaker",
            Verdict::Stronger => "stronger",
            Verdict::Different => "different",
        }
    }
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
    /// Of d' − p.
    pub difference_rms: f64,
    /// What `difference_rms` is expected to be: √(mean s²).
    pub expected_difference_rms: f64,
    /// β; `None` where no change was predicted.
    pub response_ratio: Option<f64>,
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
    let s: Vec<f64> = defined
        .iter()
        .map(|&k| {
            let model = uncertainty.as_ref().map_or(0.0, |u| u[k]);
            (2.0 * noise_sigma * noise_sigma + model * model + floor * floor).sqrt()
        })
        .collect();
    let m = defined.len();
    let rms = |x: &dyn Fn(usize) -> f64| ((0..m).map(|i| x(i) * x(i)).sum::<f64>() / m as f64).sqrt();
    let chi_squared: f64 = (0..m).map(|i| ((after[i] - p[i]) / s[i]).powi(2)).sum();
    let limit = quantile(m);
    let scaled = Scaled::of(&d, &p, &after, &s)?;
    let verdict = match &scaled {
        _ if chi_squared <= limit => Verdict::AsPredicted,
        Some(scaled) => scaled.verdict(chi_squared, m, *response_uncertainty),
        None => Verdict::Different,
    };
    let (ratio, error) = scaled.map_or((None, None), |s| (Some(s.ratio), Some(s.std_error)));
    let difference_rms = rms(&|i| after[i] - p[i]);
    let expected_difference_rms = rms(&|i| s[i]);
    Ok(Answer {
        nodes: m,
        before_rms: rms(&|i| d[i]),
        predicted_rms: rms(&|i| p[i]),
        measured_rms: rms(&|i| after[i]),
        difference_rms,
        expected_difference_rms,
        response_ratio: ratio,
        response_ratio_std_error: error,
        chi_squared,
        chi_squared_limit: limit,
        verdict,
        sentence: sentence(verdict, ratio, difference_rms, expected_difference_rms),
    })
}

/// The measured change as a multiple of the predicted one.
struct Scaled {
    ratio: f64,
    std_error: f64,
    /// χ² of what the multiple leaves.
    left: f64,
}

impl Scaled {
    /// A weighted fit of one column; `None` where no change was predicted.
    fn of(before: &[f64], predicted: &[f64], after: &[f64], s: &[f64]) -> Result<Option<Self>, FitError> {
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
        Ok(Some(Scaled { ratio, std_error: 1.0 / square.sqrt(), left: fitted.residuals.rss / (least * least) }))
    }

    fn verdict(&self, chi_squared: f64, nodes: usize, eta: f64) -> Verdict {
        let explained = self.left <= quantile(nodes.max(2) - 1) || self.left <= (1.0 - EXPLAINED) * chi_squared;
        let away = (self.ratio - 1.0).abs() > TWO_SIDED * self.std_error.hypot(eta);
        match explained && away {
            // the machine went the other way: no multiple of what J says
            true if self.ratio < -TWO_SIDED * self.std_error => Verdict::Different,
            true if self.ratio < 1.0 => Verdict::Weaker,
            true => Verdict::Stronger,
            // all of J may be off by η together
            false if explained => Verdict::AsPredicted,
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

fn sentence(verdict: Verdict, ratio: Option<f64>, difference: f64, expected: f64) -> String {
    let came = ratio.map_or(String::new(), |ratio| format!(", {:.0} % of the predicted change came", 100.0 * ratio));
    let apart = format!("measured and predicted differ by {difference:.3} µm rms, {expected:.3} µm are expected{came}");
    match verdict {
        Verdict::AsPredicted => format!("The machine answered as predicted: {apart}."),
        Verdict::Weaker => format!("The machine answered more weakly than predicted: {apart}."),
        Verdict::Stronger => format!("The machine answered more strongly than predicted: {apart}."),
        Verdict::Different => format!("The machine answered differently: {apart}."),
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
