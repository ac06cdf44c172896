//! Nodes of a flank: checked, trimmed to the evaluation range and mapped to [-1, 1]².

use super::{
    super::warning::{SurfaceWarning, share},
    settings::{Border, FigureTerms, Slopes, SurfaceSettings, covers},
};
use crate::{Gear, Kind, ProfileAxis, data::MOST_LENGTH, evaluation::EDGE};
use flankfit_estimation::{FitError, Nodes};
use flankfit_numerics::{
    cancel::Asking,
    check::{Faults, length_exceeds, not_ascending, not_finite, per_position, range as not_a_range},
    words::{Shown, entries, rounded},
};

/// Paths to the ranges, and to what is cut off at their ends.
const PROFILE_RANGE: &str = "profile_range";
const HELIX_RANGE: &str = "helix_range_mm";
const BORDER: &str = "border_percent";

/// Deviations over a flank, µm; NaN or invalid where missing.
#[derive(Clone, Copy, Debug)]
pub struct FlankNodes<'a> {
    /// Coordinate of the profile: roll length, diameter or another.
    pub axis: ProfileAxis,
    /// Rows of a grid, or one number per node.
    pub profile: &'a [f64],
    /// Columns of a grid, or one number per node, mm.
    pub z: &'a [f64],
    /// Deviations of a grid row by row: `deviation[i * z.len() + j]` at `(profile[i], z[j])`.
    pub deviation: &'a [f64],
    /// Whether each deviation is defined; all are by default.
    pub valid: Option<&'a [bool]>,
    /// Whether the axes are those of a grid; they ascend then.
    pub grid: bool,
}

/// Nodes by their use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = FlankNodeCounts)
)]
pub struct NodeCounts {
    /// All nodes that were posted.
    pub posted: usize,
    /// Nodes without a deviation.
    pub missing: usize,
    /// Nodes outside the evaluation ranges.
    pub trimmed: usize,
    /// Nodes that the surface was fitted to (filters may remove some).
    pub used: usize,
}

/// The part of the flank that is fitted.
pub(super) struct Trimmed {
    pub roll: [f64; 2],
    pub z: [f64; 2],
    /// Roll lengths before the border was cut off.
    pub evaluated: [f64; 2],
    /// Whether nodes cover enough of the roll lengths, and of z, to hold figures against limits.
    pub covered: [bool; 2],
    /// Warnings about the nodes.
    pub warnings: Vec<SurfaceWarning>,
    /// The node given that each node of the fit is.
    pub kept: Vec<usize>,
    /// +1 where the tip lies at greater roll lengths.
    outward: f64,
}

impl Trimmed {
    /// Returns the remaining range, the number of its nodes, and the nodes of the fit.
    pub(crate) fn new(
        gear: &Gear,
        nodes: &FlankNodes,
        settings: &SurfaceSettings,
    ) -> Result<(Self, NodeCounts, Nodes), FitError> {
        check(nodes, &settings.border)?;
        let roll = nodes.axis.roll_lengths(gear, nodes.profile);
        let roll: Vec<f64> = roll.map_err(|found| found.within("profile"))?;
        let there = |k: usize| !nodes.deviation[k].is_nan() && nodes.valid.is_none_or(|valid| valid[k]);
        let at = |k: usize| match nodes.grid {
            true => [roll[k / nodes.z.len()], nodes.z[k % nodes.z.len()]],
            false => [roll[k], nodes.z[k]],
        };
        let posted = nodes.deviation.len();
        let extent = |axis: usize| extent_of((0..posted).filter(|&k| there(k)).map(|k| at(k)[axis]));
        let missing = (0..posted).filter(|&k| !there(k)).count();
        if missing == posted {
            return Err(Faults::one("deviation_um", "every node is missing").into());
        }
        let roll_range = match settings.profile_range {
            Some(range) => {
                let found = nodes.axis.roll_lengths(gear, &range);
                let found = found.map_err(|found| found.within(PROFILE_RANGE))?;
                [found[0], found[1]]
            }
            None => extent(0),
        };
        let (border, outward) = (settings.border, gear.outward());
        let ends = if outward > 0.0 { [border.root, border.tip] } else { [border.tip, border.root] };
        let evaluated = roll_range;
        let roll_range = cut(roll_range, ends, PROFILE_RANGE)?;
        let z_range = cut(settings.helix_range.unwrap_or_else(|| extent(1)), [border.toe, border.heel], HELIX_RANGE)?;
        let warnings = outside_face(gear, extent(1)).into_iter().collect();
        let (covered, kept) = ([true; 2], Vec::new());
        let mut trimmed = Trimmed { roll: roll_range, z: z_range, evaluated, covered, warnings, kept, outward };
        let sign = settings.given.to_material(Kind::Profile, settings.side);
        let height = |k: usize| if there(k) { sign * nodes.deviation[k] } else { f64::NAN };
        let counted = || (0..posted).filter(|&k| there(k) && trimmed.holds(at(k)));
        let used = counted().count();
        if used == 0 {
            return Err(Faults::one(BORDER, "no node is left within the trimmed range").into());
        }
        cover(counted().map(|k| at(k)[0]), trimmed.roll, PROFILE_RANGE)?;
        cover(counted().map(|k| at(k)[1]), trimmed.z, HELIX_RANGE)?;
        let reached = [0, 1].map(|axis| extent_of(counted().map(|k| at(k)[axis])));
        // a range that was not asked for is that of the nodes, less the border
        let asked = [
            settings.profile_range.map_or(BORDER, |_| PROFILE_RANGE),
            settings.helix_range.map_or(BORDER, |_| HELIX_RANGE),
        ];
        let ranges = [trimmed.roll, trimmed.z];
        for axis in 0..2 {
            let (path, reached, range) = (asked[axis], reached[axis], ranges[axis]);
            trimmed.covered[axis] = covers(reached, range);
            if !trimmed.covered[axis] {
                trimmed.warnings.push(SurfaceWarning::RangeNotCovered {
                    path,
                    reached_mm: reached,
                    range_mm: range,
                    covered: share(reached, range),
                });
            }
        }
        let fitted = match nodes.grid {
            true => trimmed.grid(&roll, nodes.z, height),
            false => trimmed.scattered(&roll, nodes.z, height),
        };
        let fitted = fitted.map_err(|faults| FitError::from(faults.within("nodes")))?;
        let counts = NodeCounts { posted, missing, trimmed: posted - missing - used, used };
        Ok((trimmed, counts, fitted))
    }

    /// Returns the reference lengths of the slopes over this part of the flank.
    pub(super) fn slopes(&self, gear: &Gear, terms: FigureTerms) -> Slopes {
        let length = |[low, high]: [f64; 2]| high - low;
        Slopes::new(gear, terms, [length(self.roll), length(self.z)], length(self.evaluated))
    }

    fn holds(&self, [roll, z]: [f64; 2]) -> bool {
        within(roll, self.roll) && within(z, self.z)
    }

    fn u(&self, roll: f64) -> f64 {
        self.outward * mapped(roll, self.roll)
    }

    fn grid(&mut self, roll: &[f64], z: &[f64], height: impl Fn(usize) -> f64) -> Result<Nodes, Faults> {
        let mut rows: Vec<usize> = (0..roll.len()).filter(|&i| within(roll[i], self.roll)).collect();
        if self.outward < 0.0 {
            rows.reverse();
        }
        let columns: Vec<usize> = (0..z.len()).filter(|&j| within(z[j], self.z)).collect();
        self.kept = rows.iter().flat_map(|&i| columns.iter().map(move |&j| i * z.len() + j)).collect();
        let heights = self.kept.iter().map(|&k| height(k)).collect();
        let u = rows.iter().map(|&i| self.u(roll[i])).collect();
        Nodes::grid(u, columns.iter().map(|&j| mapped(z[j], self.z)).collect(), heights, None, None)
    }

    fn scattered(&mut self, roll: &[f64], z: &[f64], height: impl Fn(usize) -> f64) -> Result<Nodes, Faults> {
        let (mut u, mut v, mut heights) = (Vec::new(), Vec::new(), Vec::new());
        for k in (0..roll.len()).asking(50) {
            let h = height(k);
            if !h.is_nan() && self.holds([roll[k], z[k]]) {
                u.push(self.u(roll[k]));
                v.push(mapped(z[k], self.z));
                heights.push(h);
                self.kept.push(k);
            }
        }
        Nodes::scattered(u, v, heights, None)
    }
}

/// The least and the greatest of some places.
fn extent_of(places: impl Iterator<Item = f64>) -> [f64; 2] {
    places.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], x| [least.min(x), most.max(x)])
}

/// Length outside the face that nodes may reach: a probe begins and ends next to it.
const OVERRUN: f64 = 0.05;

/// Whether nodes reach farther than the face of the gear.
fn outside_face(gear: &Gear, [low, high]: [f64; 2]) -> Option<SurfaceWarning> {
    let face_width = gear.data().face_width?;
    let span = high - low;
    (span > (1.0 + OVERRUN) * face_width)
        .then_some(SurfaceWarning::OutsideFace { span_mm: span, face_width_mm: face_width })
}

/// Nodes on the end of a range belong to it, but for rounding.
fn within(x: f64, [low, high]: [f64; 2]) -> bool {
    x >= low - EDGE && x <= high + EDGE
}

/// Share of a range that may be without nodes at either end, where they lie closer.
const OPEN_END: f64 = 0.05;

/// Refuses places that leave more of the range open at an end than the distance of the two that are
/// nearest to it, and than a twentieth of the range.
fn cover(places: impl Iterator<Item = f64>, range: [f64; 2], path: &str) -> Result<(), Faults> {
    let outermost = |[end, inner]: [f64; 2], x: f64| match () {
        () if x < end - EDGE => [x, end],
        () if x > end + EDGE && x < inner => [end, x],
        () => [end, inner],
    };
    let beyond = [f64::INFINITY; 2];
    let [low, high] = places.fold([beyond; 2], |[low, high], x| [outermost(low, x), outermost(high, -x)]);
    // a single place says nothing of a distance; the fit refuses what it does not determine
    let open = |[end, inner]: [f64; 2], from: f64| inner.is_finite() && end - from > inner - end;
    let most = OPEN_END * (range[1] - range[0]);
    let opened = |ends: [f64; 2], from: f64| ends[0] - from > most && open(ends, from);
    if opened(low, range[0]) || opened(high, -range[1]) {
        let [[first, last], [from, to]] = [[low[0], -high[0]], range].map(|ends| ends.map(|x| rounded(x, 7)));
        return Err(Faults::one(
            path,
            format_args!(
                "the counted nodes span {first} to {last} mm, the range is {from} to {to} mm: its figures would be \
                 extrapolated; give a range that the nodes cover"
            ),
        ));
    }
    Ok(())
}

fn mapped(x: f64, [low, high]: [f64; 2]) -> f64 {
    (x - 0.5 * (low + high)) / (0.5 * (high - low))
}

/// The range without the shares at its ends.
fn cut([low, high]: [f64; 2], percent: [f64; 2], path: &str) -> Result<[f64; 2], Faults> {
    let length = high - low;
    if !(length > 0.0 && length.is_finite()) {
        return Err(Faults::one(path, not_a_range([low, high])));
    }
    Ok([low + 0.01 * percent[0] * length, high - 0.01 * percent[1] * length])
}

fn check(nodes: &FlankNodes, border: &Border) -> Result<(), Faults> {
    let mut faults = Faults::default();
    let (rows, columns) = (nodes.profile.len(), nodes.z.len());
    let count = if nodes.grid { rows.saturating_mul(columns) } else { rows };
    if count == 0 {
        faults.push("profile", "there are no nodes");
    }
    if !nodes.grid && columns != rows {
        faults.push("z_mm", format_args!("{}, but {rows} would match the profile", entries(columns)));
    }
    let lengths = [("deviation_um", Some(nodes.deviation.len())), ("valid", nodes.valid.map(<[bool]>::len))];
    for (path, length) in lengths {
        if let Some(given) = length.filter(|&length| length != count) {
            faults.push(path, per_position(given, count));
        }
    }
    for (index, &z) in nodes.z.iter().enumerate() {
        match z.abs() {
            size if size <= MOST_LENGTH => {}
            size if size.is_finite() => faults.push(format_args!("z_mm[{index}]"), length_exceeds(z, MOST_LENGTH)),
            _ => faults.push(format_args!("z_mm[{index}]"), not_finite()),
        }
    }
    for (index, deviation) in nodes.deviation.iter().enumerate() {
        if deviation.is_infinite() {
            faults.push(format_args!("deviation_um[{index}]"), not_finite());
        }
    }
    for (path, axis) in [("profile", nodes.profile), ("z_mm", nodes.z)] {
        for (i, pair) in axis.windows(2).enumerate().filter(|_| nodes.grid) {
            if pair[1] <= pair[0] && pair[0].is_finite() {
                faults.push(format_args!("{path}[{}]", i + 1), not_ascending(pair[1], pair[0]));
            }
        }
    }
    let shares = [("root", border.root), ("tip", border.tip), ("toe", border.toe), ("heel", border.heel)];
    for (name, percent) in shares {
        if !(0.0..100.0).contains(&percent) {
            faults.push(format_args!("{BORDER}.{name}"), format_args!("{} is not within 0 and 100", Shown(percent)));
        }
    }
    if border.root + border.tip >= 100.0 || border.toe + border.heel >= 100.0 {
        faults.push(BORDER, "nothing is left between opposite borders");
    }
    faults.into_result(())
}
