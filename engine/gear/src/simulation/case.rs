//! Machines to simulate: the case that shows what λ* is for, and any sensitivity with settings off
//! by a given size.

use super::{MachineSpec, Setting};
use crate::correction::machine::Sensitivity;

/// Nodes along the profile and along the helix.
pub const GRID: [usize; 2] = [5, 9];
/// Part of the sixth setting that is not in its mixture, in µm at the ends of the helix; the
/// condition of JᵀJ is then about 1e11.
const APART: f64 = 1.4e-5;
/// Initial error of each setting, µm at the ends.
const OFF: f64 = 12.0;

/// 5×9 nodes and six settings: angle errors and crownings of profile and helix, twist, and a tilt
/// that is a mixture of helix angle and twist but for a part of 1e-5. True response 1 % off, probe
/// noise 0.3 µm, every tenth node undefined.
pub fn ill_conditioned(seed: u64) -> MachineSpec {
    let settings = [
        ("profile_angle", "µm at the tip"),
        ("helix_angle", "µm at the end"),
        ("profile_crowning", "um"),
        ("helix_crowning", "um"),
        ("twist", "µm at the corner"),
        ("tilt", "µm at the corner"),
    ];
    let place = |i: usize, of: usize| 2.0 * i as f64 / (of - 1) as f64 - 1.0;
    let mut sensitivity = Vec::new();
    for i in 0..GRID[0] {
        for j in 0..GRID[1] {
            let (u, v) = (place(i, GRID[0]), place(j, GRID[1]));
            let tilt = 0.6 * v + 0.8 * u * v + APART * v * v * v;
            sensitivity.extend([u, v, -u * u, -v * v, u * v, tilt]);
        }
    }
    MachineSpec {
        seed,
        sensitivity,
        settings: settings.map(|(name, unit)| Setting::free(name, unit)).to_vec(),
        setting_error: vec![OFF; settings.len()],
        response_noise: 0.01,
        probe_noise: 0.3,
        missing: 0.1,
    }
}

/// A machine with the sensitivity of `known` whose settings are off so that each alone deviates by
/// `size` µm RMS over the nodes (standard deviation); a setting that changes no node is not off.
/// Response, noise and misses as in [`ill_conditioned`].
pub fn off_by(seed: u64, known: Sensitivity, size: f64) -> MachineSpec {
    let columns = known.settings.len().max(1);
    let rows = (known.matrix.len() / columns) as f64;
    let error = |j: usize| {
        let square: f64 = known.matrix.iter().skip(j).step_by(columns).map(|x| x * x).sum();
        if square > 0.0 { size / (square / rows).sqrt() } else { 0.0 }
    };
    let setting_error = (0..known.settings.len()).map(error).collect();
    let Sensitivity { settings, matrix } = known;
    MachineSpec {
        seed,
        sensitivity: matrix,
        settings,
        setting_error,
        response_noise: 0.01,
        probe_noise: 0.3,
        missing: 0.1,
    }
}
