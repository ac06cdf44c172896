//! Nodes of a flank: checked, trimmed to the evaluation range and mapped to [-1, 1]².

use super::SurfaceSettings;
use crate::numerics::cancel::Asking;
use crate::{
    estimation::{Faults, FitError, Nodes},
    fault::words::{Shown, entries},
    gear::{Gear, Kind, ProfileAxis, evaluation::EDGE},
};

/// Deviations over a flank, µm; NaN or invalid where missing.
#[derive(Clone, Copy, Debug)]
pub struct FlankNodes<'a> {
    pub axis: ProfileAxis,
    /// Rows of a grid, or one number per node.
    pub profile: &'a [f64],
    /// Columns of a grid, or one number per node, mm.
    pub z: &'a [f64],
    /// Of a grid row by row: `deviation[i * z.len() + j]` at `(profile[i], z[j])`.
    pub deviation: &'a [f64],
    pub valid: Option<&'a [bool]>,
    /// Whether the axes are those of a grid; they ascend then.
    pub grid: bool,
}

/// Shares of the evaluation range that are cut off, in %: 0 to below 100 together on each axis.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Border {
    pub root: f64,
    pub tip: f64,
    /// At the end of small z.
    pub toe: f64,
    /// At the end of great z.
    pub heel: f64,
}

/// Nodes by what became of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeCounts {
    pub posted: usize,
    /// Missing or invalid.
    pub missing: usize,
    /// There, but outside the trimmed range.
    pub trimmed: usize,
    /// Handed to the fit (filters may still remove some).
    pub used: usize,
}

/// The part of the flank that is fitted.
pub(super) struct Trimmed {
    pub roll: [f64; 2],
    pub z: [f64; 2],
    /// +1 where the tip lies at greater roll lengths.
    outward: f64,
}

impl Trimmed {
    /// What is left, how many nodes that are, and the nodes of the fit.
    pub fn new(
        gear: &Gear,
        nodes: &FlankNodes,
        settings: &SurfaceSettings,
    ) -> Result<(Self, NodeCounts, Nodes), FitError> {
        check(nodes, &settings.border)?;
        let roll = nodes.axis.roll_lengths(gear, nodes.profile, "/profile")?;
        let there = |k: usize| !nodes.deviation[k].is_nan() && nodes.valid.is_none_or(|valid| valid[k]);
        let at = |k: usize| match nodes.grid {
            true => [roll[k / nodes.z.len()], nodes.z[k % nodes.z.len()]],
            false => [roll[k], nodes.z[k]],
        };
        let posted = nodes.deviation.len();
        let extent = |axis: usize| {
            (0..posted)
                .filter(|&k| there(k))
                .map(|k| at(k)[axis])
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], x| [least.min(x), most.max(x)])
        };
        let missing = (0..posted).filter(|&k| !there(k)).count();
        if missing == posted {
            return Err(Faults::one("/deviation_um", "every node is missing").into());
        }
        let roll_range = match settings.profile_range {
            Some(range) => {
                let found = nodes.axis.roll_lengths(gear, &range, "/profile_range")?;
                [found[0], found[1]]
            }
            None => extent(0),
        };
        let (border, outward) = (settings.border, gear.outward());
        let ends = if outward > 0.0 { [border.root, border.tip] } else { [border.tip, border.root] };
        let roll_range = cut(roll_range, ends, "/profile_range")?;
        let z_range =
            cut(settings.helix_range.unwrap_or_else(|| extent(1)), [border.toe, border.heel], "/helix_range_mm")?;
        let trimmed = Trimmed { roll: roll_range, z: z_range, outward };
        let sign = settings.given.to_material(Kind::Profile, settings.side);
        let height = |k: usize| if there(k) { sign * nodes.deviation[k] } else { f64::NAN };
        let used = (0..posted).filter(|&k| there(k) && trimmed.holds(at(k))).count();
        if used == 0 {
            return Err(Faults::one("/border_percent", "no node is left within the trimmed range").into());
        }
        let fitted = match nodes.grid {
            true => trimmed.grid(&roll, nodes.z, height)?,
            false => trimmed.scattered(&roll, nodes.z, height)?,
        };
        let counts = NodeCounts { posted, missing, trimmed: posted - missing - used, used };
        Ok((trimmed, counts, fitted))
    }

    fn holds(&self, [roll, z]: [f64; 2]) -> bool {
        within(roll, self.roll) && within(z, self.z)
    }

    fn u(&self, roll: f64) -> f64 {
        self.outward * mapped(roll, self.roll)
    }

    fn grid(&self, roll: &[f64], z: &[f64], height: impl Fn(usize) -> f64) -> Result<Nodes, Faults> {
        let mut rows: Vec<usize> = (0..roll.len()).filter(|&i| within(roll[i], self.roll)).collect();
        if self.outward < 0.0 {
            rows.reverse();
        }
        let columns: Vec<usize> = (0..z.len()).filter(|&j| within(z[j], self.z)).collect();
        let heights = rows.iter().flat_map(|&i| columns.iter().map(move |&j| i * z.len() + j)).map(height).collect();
        let u = rows.iter().map(|&i| self.u(roll[i])).collect();
        Nodes::grid(u, columns.iter().map(|&j| mapped(z[j], self.z)).collect(), heights, None, None)
    }

    fn scattered(&self, roll: &[f64], z: &[f64], height: impl Fn(usize) -> f64) -> Result<Nodes, Faults> {
        let (mut u, mut v, mut heights) = (Vec::new(), Vec::new(), Vec::new());
        for k in (0..roll.len()).asking(50) {
            let h = height(k);
            if !h.is_nan() && self.holds([roll[k], z[k]]) {
                u.push(self.u(roll[k]));
                v.push(mapped(z[k], self.z));
                heights.push(h);
            }
        }
        Nodes::scattered(u, v, heights, None)
    }
}

/// Nodes on the end of a range belong to it, but for rounding.
fn within(x: f64, [low, high]: [f64; 2]) -> bool {
    x >= low - EDGE && x <= high + EDGE
}

fn mapped(x: f64, [low, high]: [f64; 2]) -> f64 {
    (x - 0.5 * (low + high)) / (0.5 * (high - low))
}

/// The range without the shares at its ends.
fn cut([low, high]: [f64; 2], percent: [f64; 2], pointer: &str) -> Result<[f64; 2], Faults> {
    let length = high - low;
    if !(length > 0.0 && length.is_finite()) {
        let detail = format!("{} to {} mm is not an ascending range", Shown(low), Shown(high));
        return Err(Faults::one(pointer, detail));
    }
    Ok([low + 0.01 * percent[0] * length, high - 0.01 * percent[1] * length])
}

fn check(nodes: &FlankNodes, border: &Border) -> Result<(), Faults> {
    let mut faults = Faults::default();
    let (rows, columns) = (nodes.profile.len(), nodes.z.len());
    let count = if nodes.grid { rows.saturating_mul(columns) } else { rows };
    if count == 0 {
        faults.push("/profile", "there are no nodes");
    }
    if !nodes.grid && columns != rows {
        faults.push("/z_mm", format!("{}, but {rows} would match the profile", entries(columns)));
    }
    let lengths = [("/deviation_um", Some(nodes.deviation.len())), ("/valid", nodes.valid.map(<[bool]>::len))];
    for (pointer, length) in lengths {
        if let Some(length) = length.filter(|&length| length != count) {
            faults.push(pointer, format!("{}, but {count} would match the positions", entries(length)));
        }
    }
    for (j, z) in nodes.z.iter().enumerate() {
        if !z.is_finite() {
            faults.push(format!("/z_mm/{j}"), "the number is not finite in double precision");
        }
    }
    for (k, deviation) in nodes.deviation.iter().enumerate() {
        if deviation.is_infinite() {
            faults.push(format!("/deviation_um/{k}"), "the number is not finite in double precision");
        }
    }
    for (pointer, axis) in [("/profile", nodes.profile), ("/z_mm", nodes.z)] {
        for (i, pair) in axis.windows(2).enumerate().filter(|_| nodes.grid) {
            if pair[1] <= pair[0] {
                let detail = format!("{} does not ascend: it follows {}", Shown(pair[1]), Shown(pair[0]));
                faults.push(format!("{pointer}/{}", i + 1), detail);
            }
        }
    }
    let shares = [("root", border.root), ("tip", border.tip), ("toe", border.toe), ("heel", border.heel)];
    for (name, percent) in shares {
        if !(0.0..100.0).contains(&percent) {
            faults.push(format!("/border_percent/{name}"), format!("{} is not within 0 and 100", Shown(percent)));
        }
    }
    if border.root + border.tip >= 100.0 || border.toe + border.heel >= 100.0 {
        faults.push("/border_percent", "nothing is left between opposite borders");
    }
    faults.into_result(())
}
