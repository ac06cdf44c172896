//! A closed loop to simulate, as it is requested.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::faults::Faults;
use flankfit_engine::{
    gear::{
        correction::Setting,
        simulation::{MachineSpec, Strategy, case},
    },
    words::entries,
};

/// A machine with wrong settings, and methods to correct it. By default the ill-conditioned case: 5
/// × 9 nodes and six settings, the sixth of which is nearly a combination of two others.
#[skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = ClosedLoopRequest)]
pub struct ClosedLoopBody {
    /// Seed of all random numbers. Default 0.
    pub seed: Option<u64>,
    /// Number of corrections. Default 2.
    #[schema(minimum = 1, maximum = 20)]
    pub corrections: Option<usize>,
    /// Correction methods. Default `spectral_uncertainty` (the default of corrections) and
    /// `least_squares`; others are `spectral_min_mse`, `ridge_gcv` and so on.
    pub strategies: Option<Vec<String>>,
    /// Names of the settings, with `matrix`.
    pub settings: Option<Vec<String>>,
    /// Sensitivity matrix: µm at each node per unit of each setting, as used by the corrections.
    pub matrix: Option<Vec<Vec<f64>>>,
    /// Rows and columns of the nodes of `matrix`, which then form a grid over [-1, 1] × [-1, 1].
    pub grid: Option<[usize; 2]>,
    /// Standard deviation of the initial error of each setting, in its unit. Default 12 µm in the
    /// ill-conditioned case; required with `matrix`.
    pub setting_error: Option<Vec<f64>>,
    /// Relative standard deviation of the difference between the true response and the matrix,
    /// entry by entry. Default 0.01.
    #[schema(minimum = 0, maximum = 1)]
    pub response_noise: Option<f64>,
    /// The value of `response_noise` that corrections assume. Default 0.02.
    #[schema(minimum = 0, maximum = 1)]
    pub response_uncertainty: Option<f64>,
    /// Standard deviation of the noise of a measured deviation. Default 0.3.
    #[schema(minimum = 0, maximum = 1e6)]
    pub probe_noise_um: Option<f64>,
    /// Share of the nodes that a measurement misses; at least as many nodes as settings must
    /// remain. Default 0.1.
    #[schema(minimum = 0, exclusive_maximum = 1)]
    pub missing: Option<f64>,
    /// If true, each run is stored as a job with its iterations and corrections, all in one
    /// transaction. Default false.
    pub store: Option<bool>,
}

impl ClosedLoopBody {
    /// The machine, and the rows and columns of its nodes.
    pub fn machine(&self) -> Result<(MachineSpec, [usize; 2]), Faults> {
        let mut machine = case::ill_conditioned(self.seed.unwrap_or(0));
        let mut grid = case::GRID;
        let mut faults = Faults::default();
        match (&self.matrix, &self.settings, &self.grid, &self.setting_error) {
            (Some(matrix), Some(settings), Some([rows, columns]), Some(error)) => {
                let nodes = rows.saturating_mul(*columns);
                if matrix.len() != nodes || *rows < 2 || *columns < 2 {
                    faults.push("/grid", format!("{rows} × {columns} nodes do not match {} rows", matrix.len()));
                }
                for (k, row) in matrix.iter().enumerate().filter(|(_, row)| row.len() != settings.len()) {
                    faults.push(
                        format!("/matrix/{k}"),
                        format!("{} for {} settings", entries(row.len()), settings.len()),
                    );
                }
                grid = [*rows, *columns];
                machine.sensitivity = matrix.concat();
                machine.settings = settings.iter().map(|name| Setting::free(name.clone(), "")).collect();
                machine.setting_error.clone_from(error);
            }
            (None, None, None, error) => {
                if let Some(error) = error {
                    machine.setting_error.clone_from(error);
                }
            }
            (matrix, settings, grid, error) => {
                let parts = [
                    ("/matrix", matrix.is_none()),
                    ("/settings", settings.is_none()),
                    ("/grid", grid.is_none()),
                    ("/setting_error", error.is_none()),
                ];
                for (pointer, _) in parts.into_iter().filter(|(_, missing)| *missing) {
                    faults.push_missing(
                        pointer,
                        "missing: `matrix`, `settings`, `grid` and `setting_error` belong together",
                    );
                }
            }
        }
        machine.response_noise = self.response_noise.unwrap_or(machine.response_noise);
        machine.probe_noise = self.probe_noise_um.unwrap_or(machine.probe_noise);
        machine.missing = self.missing.unwrap_or(machine.missing);
        faults.into_result((machine, grid))
    }

    /// The ways to correct.
    pub fn strategies(&self) -> Result<Vec<Strategy>, Faults> {
        let Some(names) = &self.strategies else {
            return Ok(vec![Strategy::uncertainty(), Strategy::least_squares()]);
        };
        let known = Strategy::all();
        let mut faults = Faults::default();
        if names.is_empty() {
            faults.push("/strategies", "there is none");
        }
        let mut found = Vec::with_capacity(names.len());
        for (k, name) in names.iter().enumerate() {
            match known.iter().find(|strategy| strategy.name == *name) {
                Some(strategy) if !found.contains(strategy) => found.push(strategy.clone()),
                Some(_) => faults.push(format!("/strategies/{k}"), "it occurs twice"),
                None => {
                    let names: Vec<_> = known.iter().map(|strategy| format!("`{}`", strategy.name)).collect();
                    faults.push(format!("/strategies/{k}"), format!("not one of {}", names.join(", ")));
                }
            }
        }
        faults.into_result(found)
    }
}
