//! The closed loop simulated: a machine whose settings are off, a probe, and corrections until the
//! flank is good.
//!
//! A machine responds to settings that are off by e with the deviations `G e`, where its true
//! response G differs from the sensitivity J that the correction knows: `G_kj = J_kj (1 + ρ g_kj)`,
//! g standard normal, drawn once. A measurement is `G e` plus probe noise, some nodes undefined. A
//! correction Δ makes e + Δ of e.
//!
//! * [`Simulation`]: the machine, step by step, so that a caller may keep every round;
//! * [`closed_loop`]: whole runs with several ways to correct;
//! * [`case`]: the ill-conditioned case.
//!
//! *Reproducible.* Stream 0 of the seed gives e, stream 1 the response; measurement number r takes
//! stream 2 + 2r for its noise and 3 + 2r for the nodes that it misses. Measuring twice without a
//! correction between gives the same numbers.

pub mod case;
pub mod closed_loop;

use flankfit_estimation::randomization::normal::Normals;
use flankfit_numerics::{
    check::Faults,
    words::{Shown, counted, entries},
};

pub use closed_loop::{Round, Run, Strategy, run};

use super::correction::{MOST_ENTRIES, MOST_SETTINGS, Setting};

/// Most corrections of a run: settings that run away are still numbers then.
pub const MOST_CORRECTIONS: usize = 20;
/// How far a setting that is off may move a node, µm: a kilometre.
pub const MOST_DEVIATION: f64 = 1e9;

/// Most of [`MachineSpec::response_noise`]: as much as the response itself.
pub const MOST_RESPONSE_NOISE: f64 = 1.0;
/// Most of [`MachineSpec::probe_noise`], µm: a metre.
pub const MOST_PROBE_NOISE: f64 = 1e6;

/// A machine to be simulated.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineSpec {
    /// Seed of errors, response and noise: the same seed gives the same run.
    pub seed: u64,
    /// J row by row, µm at each node per unit of each setting: what corrections know.
    pub sensitivity: Vec<f64>,
    /// Settings of the machine, with their limits.
    pub settings: Vec<Setting>,
    /// Standard deviation of what each setting is off by at first, in its unit.
    pub setting_error: Vec<f64>,
    /// ρ, by how much an entry of the true response differs from that of J, relative to it; 0 to 1.
    pub response_noise: f64,
    /// Standard deviation of a measured deviation, µm; 0 to 1e6.
    pub probe_noise: f64,
    /// Share of the nodes that a measurement misses; it leaves as many nodes as there are settings.
    pub missing: f64,
}

impl MachineSpec {
    /// Nodes that a measurement misses.
    fn missed(&self) -> usize {
        let nodes = self.sensitivity.len() / self.settings.len().max(1);
        (self.missing * nodes as f64).floor() as usize
    }
}

/// A machine with its hidden state.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulation {
    asked: MachineSpec,
    response: Vec<f64>,
    off: Vec<f64>,
    corrections: u64,
}

impl Simulation {
    /// Draws the machine.
    pub fn new(asked: MachineSpec) -> Result<Self, Faults> {
        check(&asked)?;
        let mut normals = Normals::new(asked.seed, 0);
        let off = asked.setting_error.iter().map(|error| error * normals.draw()).collect();
        let mut normals = Normals::new(asked.seed, 1);
        let response = asked.sensitivity.iter().map(|j| j * (1.0 + asked.response_noise * normals.draw())).collect();
        Ok(Simulation { asked, response, off, corrections: 0 })
    }

    /// Returns the specification.
    pub fn spec(&self) -> &MachineSpec {
        &self.asked
    }

    /// Errors of the settings, which no correction sees.
    pub fn off(&self) -> &[f64] {
        &self.off
    }

    /// G e: the deviations without noise, µm for each node.
    pub fn flank(&self) -> Vec<f64> {
        let row = |row: &[f64]| row.iter().zip(&self.off).map(|(g, e)| g * e).sum();
        self.response.chunks_exact(self.off.len()).map(row).collect()
    }

    /// Root mean square of the deviations without noise, over all nodes, µm.
    ///
    /// ```
    /// use flankfit_gear::simulation::{Simulation, case::ill_conditioned};
    ///
    /// // Undoing what the settings are off by leaves a flank without deviations.
    /// let mut machine = Simulation::new(ill_conditioned(1))?;
    /// assert!(machine.true_rms() > 1.0);
    /// let back: Vec<f64> = machine.off().iter().map(|off| -off).collect();
    /// machine.apply(&back)?;
    /// assert!(machine.true_rms() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn true_rms(&self) -> f64 {
        rms(&self.flank())
    }

    /// Deviations that the probe measures, µm for each node, NaN where it missed.
    pub fn measure(&self) -> Vec<f64> {
        let mut noise = Normals::new(self.asked.seed, 2 + 2 * self.corrections);
        let mut measured: Vec<f64> = self.flank().iter().map(|d| d + self.asked.probe_noise * noise.draw()).collect();
        let missed = self.asked.missed();
        let lots = Normals::new(self.asked.seed, 3 + 2 * self.corrections).take(measured.len());
        let mut order: Vec<usize> = (0..measured.len()).collect();
        order.sort_by(|&a, &b| lots[a].total_cmp(&lots[b]));
        for &k in &order[..missed] {
            measured[k] = f64::NAN;
        }
        measured
    }

    /// Changes the settings and machines again. Refuses a list of another length and changes that
    /// are not finite.
    pub fn apply(&mut self, change: &[f64]) -> Result<(), Faults> {
        if change.len() != self.off.len() {
            return Err(Faults::one("corrections", per_setting(change.len(), self.off.len())));
        }
        if change.iter().zip(&self.off).any(|(c, e)| !(c + e).is_finite()) {
            return Err(Faults::one("corrections", "the setting would no longer be a finite number"));
        }
        self.off.iter_mut().zip(change).for_each(|(e, c)| *e += c);
        self.corrections += 1;
        Ok(())
    }
}

/// Root mean square of what is defined; NaN where nothing is.
pub(super) fn rms(deviation: &[f64]) -> f64 {
    let (sum, count) =
        deviation.iter().filter(|d| !d.is_nan()).fold((0.0, 0.0), |(sum, count), d| (sum + d * d, count + 1.0));
    f64::sqrt(sum / count)
}

/// The message of a list with another number of entries than there are settings.
fn per_setting(given: usize, settings: usize) -> String {
    format!("{} for {}", entries(given), counted(settings, "setting", "settings"))
}

fn check(asked: &MachineSpec) -> Result<(), Faults> {
    let mut faults = Faults::default();
    let columns = asked.settings.len();
    if columns == 0 || columns > MOST_SETTINGS {
        let settings = counted(columns, "setting", "settings");
        return Err(Faults::one("settings", format_args!("{settings}; a machine has 1 to {MOST_SETTINGS}")));
    }
    let numbers = asked.sensitivity.len();
    if numbers == 0 || !numbers.is_multiple_of(columns) || numbers > MOST_ENTRIES {
        let given = entries(numbers);
        faults.push("matrix", format_args!("{given} are not rows of {columns} (at most {MOST_ENTRIES})"));
    }
    for (at, value) in asked.sensitivity.iter().enumerate().filter(|(_, x)| !x.is_finite()) {
        let path = format_args!("matrix[{}][{}]", at / columns, at % columns);
        faults.push(path, format_args!("{value} is not a finite number"));
    }
    if asked.setting_error.len() != columns {
        faults.push("setting_error", per_setting(asked.setting_error.len(), columns));
    }
    for (index, error) in asked.setting_error.iter().enumerate() {
        let effect =
            asked.sensitivity.iter().skip(index).step_by(columns).fold(0.0f64, |most, x| most.max((x * error).abs()));
        let path = format_args!("setting_error[{index}]");
        if !(error.is_finite() && *error >= 0.0) {
            faults.push(path, format_args!("{} is not a finite deviation of at least 0", Shown(*error)));
        } else if effect > MOST_DEVIATION {
            let effect = Shown(effect);
            faults.push(path, format_args!("it moves a node by {effect} µm; at most {MOST_DEVIATION:e} µm"));
        }
    }
    for (path, value, most) in [
        ("response_noise", asked.response_noise, MOST_RESPONSE_NOISE),
        ("probe_noise_um", asked.probe_noise, MOST_PROBE_NOISE),
    ] {
        if !(0.0..=most).contains(&value) {
            faults.push(path, format_args!("{} is not a deviation between 0 and {most:e}", Shown(value)));
        }
    }
    let nodes = numbers / columns;
    if !(0.0..1.0).contains(&asked.missing) {
        faults.push("missing", format_args!("{} is not a share of at least 0 and below 1", Shown(asked.missing)));
    } else if nodes >= columns && nodes - asked.missed() < columns {
        let left = counted(nodes - asked.missed(), "node", "nodes");
        let settings = counted(columns, "setting", "settings");
        faults.push("missing", format_args!("{left} remain, too few for {settings}"));
    }
    faults.into_result(())
}
