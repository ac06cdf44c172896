//! Whether the machine answered as predicted.
//!
//! Before the correction d was measured, `p = d + JΔ` predicted, and afterwards d' is measured,
//! with independent noise of both (σ at weight 1). A machine responds with β JΔ, and J itself is
//! uncertain by η. Two questions are asked; docs/explanation/mathematics.md derives what follows
//! here.
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
//! *How much came* is decided by the 99.7 % interval of β̂, where β c explains what was measured:
//!
//! | interval of β | verdict |
//! |---|---|
//! | contains 1, excludes 0.5 | *as predicted* |
//! | lies below 1 | *weaker* |
//! | contains 0, excludes 0.5 | *no response* |
//! | lies above 1 | *stronger* |
//! | lies below 0 | *different* |
//! | contains 0.5 and 1 | *undecided* |
//!
//! Where β c does not explain it, the machine is *different*: another setting, another tool,
//! another workpiece, or a setting whose change was not entered (`not_entered`).
//!
//! *Means over teeth.* The scatter of teeth adds the covariance of the difference of both means to
//! S ([`super::teeth`]), and what it does to ⟨c, d' − d⟩ to e²; degrees of freedom of e² are then
//! those of Satterthwaite.
//!
//! The quantile of χ² is that of 0.999. Error rates are those of
//! `tests/laws/gear_correction_verdict.rs`; waviness that does not repeat raises them. Where σ was
//! estimated from the residuals of the correction quantiles are those of Student's t and Fisher's
//! F, and the interval reaches up to that of β̂ without the correction by σ² h: such a σ holds form
//! that both measurements share, and which biases nothing.

mod answer;
mod comparison;
mod counted;
mod figures;
mod misfit;
mod not_entered;
mod scaled;

pub use answer::{Answer, NotEntered, Verdict};
pub use comparison::Comparison;
use counted::Counted;
pub use figures::{FigureChange, Measurements, compare_figures};
use flankfit_estimation::{FitError, Unconverged};
use flankfit_numerics::check::Faults;
use misfit::{Covariance, quantile};
use not_entered::Explained;
use scaled::Scaled;

/// Share of the misfit that a scaled prediction must explain where it does not explain all of it.
const EXPLAINED: f64 = 0.9;

/// Compares.
pub fn compare(comparison: &Comparison) -> Result<Answer, FitError> {
    comparison.check()?;
    let nodes = Counted::of(comparison);
    if nodes.before.is_empty() {
        return Err(Faults::one("measured", "no node is defined before, predicted and measured").into());
    }
    let m = nodes.before.len();
    let freedom = comparison.noise.freedom;
    let rms = |x: &dyn Fn(usize) -> f64| ((0..m).map(|i| x(i) * x(i)).sum::<f64>() / m as f64).sqrt();
    let predicted = |i: usize| nodes.before[i] + nodes.change[i];
    let left = |beta: f64| -> Vec<f64> { (0..m).map(|i| nodes.came[i] - beta * nodes.change[i]).collect() };
    let eta = comparison.response_uncertainty;
    let of_scatter = comparison.scatter.freedom;
    let covariance =
        Covariance::of(&nodes, eta, eta, of_scatter).ok_or(FitError::NotConverged(Unconverged::Comparison))?;
    let chi_squared = covariance.square(&left(1.0));
    let alone = |r: &[f64]| r.iter().zip(&nodes.variance).map(|(r, s)| r * r / s).sum::<f64>();
    // what all nodes (of a trace) have in common is left aside
    let free = m.saturating_sub(nodes.means).max(1);
    let chi_squared_limit = quantile(free, freedom);
    let scaled = Scaled::of(&nodes, comparison);
    let within = chi_squared <= chi_squared_limit;
    let multiple = |scaled: &Scaled| {
        let rest = left(scaled.ratio);
        // a machine that responds more strongly has greater errors too
        let greater = Covariance::of(&nodes, eta, eta * scaled.ratio.abs().max(1.0), of_scatter);
        greater.is_some_and(|greater| greater.square(&rest) <= quantile(free.max(2) - 1, freedom))
            || alone(&rest) <= (1.0 - EXPLAINED) * alone(&left(1.0))
    };
    let explained = within || scaled.as_ref().is_some_and(multiple);
    let verdict = match &scaled {
        _ if !explained => Verdict::Different,
        Some(scaled) => scaled.verdict(),
        None => Verdict::Undecided,
    };
    let not_entered = scaled.as_ref().map_or_else(Vec::new, |scaled| {
        let along = covariance.product(&nodes.change, &nodes.came);
        Explained {
            left: left(1.0),
            contributions: (0..comparison.settings.len())
                .map(|j| nodes.contributions.iter().map(|row| row[j]).collect())
                .collect(),
            names: &comparison.settings,
            covariance: &covariance,
            by_ratio: covariance.square(&nodes.came) - along * along / covariance.square(&nodes.change),
            limit: chi_squared_limit,
        }
        .not_entered(scaled)
    });
    let verdict = if not_entered.is_empty() { verdict } else { Verdict::Different };
    let determined = scaled.filter(|scaled| scaled.determined() || verdict != Verdict::Undecided);
    let mut answer = Answer {
        nodes: m,
        rms_before_um: rms(&|i| nodes.before[i]),
        rms_predicted_um: rms(&predicted),
        rms_measured_um: rms(&|i| nodes.before[i] + nodes.came[i]),
        rms_predicted_change_um: rms(&|i| nodes.change[i]),
        rms_difference_um: rms(&|i| nodes.came[i] - nodes.change[i]),
        rms_expected_difference_um: (nodes.variance.iter().sum::<f64>() / m as f64).sqrt(),
        response_ratio: determined.as_ref().map(|scaled| scaled.ratio),
        response_ratio_std_error: determined.as_ref().map(|scaled| scaled.std_error),
        response_ratio_interval: determined.map(|scaled| scaled.interval()),
        chi_squared,
        chi_squared_limit,
        verdict,
        not_entered,
        sentence: String::new(),
    };
    answer.sentence = answer.in_words();
    Ok(answer)
}
