//! Nodes of a flank: checked, trimmed to the evaluation range and mapped to [-1, 1]².

use super::{
    super::{
        fault::{SurfaceFaults, SurfaceField, SurfaceReason, SurfaceRefused},
        warning::SurfaceWarning,
    },
    settings::{Border, FigureTerms, Slopes, SurfaceSettings, covers},
};
use crate::{Gear, Kind, NoInvolute, ProfileAxis, data::MOST_LENGTH, evaluation::EDGE};
use flankfit_estimation::{FitError, Nodes};
use flankfit_numerics::{
    cancel::Asking,
    check,
    fault::{Common, Faults},
};

/// Deviations over a flank, µm; NaN or invalid where missing.
#[derive(Clone, Copy, Debug)]
pub struct FlankNodes<'a> {
    /// Coordinate of the profile: roll length, diameter or another.
    pub axis: ProfileAxis,
    /// Rows of a grid, or one number per node.
    pub profile: &'a [f64],
    /// Columns of a grid, or one number per node, mm.
    pub z: &'a [f64],
    /// Of a grid row by row: `deviation[i * z.len() + j]` at `(profile[i], z[j])`.
    pub deviation: &'a [f64],
    /// Whether each deviation is defined; all are by default.
    pub valid: Option<&'a [bool]>,
    /// Whether the axes are those of a grid; they ascend then.
    pub grid: bool,
}

/// Nodes by what became of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeCounts {
    /// Nodes given.
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
    /// Roll lengths before the border was cut off.
    pub evaluated: [f64; 2],
    /// Whether nodes cover enough of the roll lengths, and of z, to hold figures against limits.
    pub covered: [bool; 2],
    /// What is to be known of the nodes.
    pub warnings: Vec<SurfaceWarning>,
    /// The node given that each node of the fit is.
    pub kept: Vec<usize>,
    /// +1 where the tip lies at greater roll lengths.
    outward: f64,
}

impl Trimmed {
    /// What is left, how many nodes that are, and the nodes of the fit.
    pub(crate) fn new(
        gear: &Gear,
        nodes: &FlankNodes,
        settings: &SurfaceSettings,
    ) -> Result<(Self, NodeCounts, Nodes), SurfaceRefused> {
        check(nodes, &settings.border)?;
        let roll = nodes.axis.roll_lengths(gear, nodes.profile);
        let roll: Vec<f64> =
            roll.map_err(|found| without_involute(found, |index| SurfaceField::ProfileAt { index }))?;
        let there = |k: usize| !nodes.deviation[k].is_nan() && nodes.valid.is_none_or(|valid| valid[k]);
        let at = |k: usize| match nodes.grid {
            true => [roll[k / nodes.z.len()], nodes.z[k % nodes.z.len()]],
            false => [roll[k], nodes.z[k]],
        };
        let posted = nodes.deviation.len();
        let extent = |axis: usize| extent_of((0..posted).filter(|&k| there(k)).map(|k| at(k)[axis]));
        let missing = (0..posted).filter(|&k| !there(k)).count();
        if missing == posted {
            return Err(SurfaceFaults::one(SurfaceField::Deviations, SurfaceReason::AllMissing).into());
        }
        let roll_range = match settings.profile_range {
            Some(range) => {
                let found = nodes.axis.roll_lengths(gear, &range);
                let found =
                    found.map_err(|found| without_involute(found, |index| SurfaceField::ProfileRangeEnd { index }))?;
                [found[0], found[1]]
            }
            None => extent(0),
        };
        let (border, outward) = (settings.border, gear.outward());
        let ends = if outward > 0.0 { [border.root, border.tip] } else { [border.tip, border.root] };
        let evaluated = roll_range;
        let roll_range = cut(roll_range, ends, SurfaceField::ProfileRange)?;
        let z_range = cut(
            settings.helix_range.unwrap_or_else(|| extent(1)),
            [border.toe, border.heel],
            SurfaceField::HelixRange,
        )?;
        let warnings = beyond_face(gear, extent(1)).into_iter().collect();
        let (covered, kept) = ([true; 2], Vec::new());
        let mut trimmed = Trimmed { roll: roll_range, z: z_range, evaluated, covered, warnings, kept, outward };
        let sign = settings.given.to_material(Kind::Profile, settings.side);
        let height = |k: usize| if there(k) { sign * nodes.deviation[k] } else { f64::NAN };
        let counted = || (0..posted).filter(|&k| there(k) && trimmed.holds(at(k)));
        let used = counted().count();
        if used == 0 {
            return Err(SurfaceFaults::one(SurfaceField::Border, SurfaceReason::AllTrimmed).into());
        }
        cover(counted().map(|k| at(k)[0]), trimmed.roll, SurfaceField::ProfileRange)?;
        cover(counted().map(|k| at(k)[1]), trimmed.z, SurfaceField::HelixRange)?;
        let reached = [0, 1].map(|axis| extent_of(counted().map(|k| at(k)[axis])));
        // a range that was not asked for is that of the nodes, less the border
        let asked = [
            settings.profile_range.map_or(SurfaceField::Border, |_| SurfaceField::ProfileRange),
            settings.helix_range.map_or(SurfaceField::Border, |_| SurfaceField::HelixRange),
        ];
        let ranges = [trimmed.roll, trimmed.z];
        for axis in 0..2 {
            let (field, reached, range) = (asked[axis], reached[axis], ranges[axis]);
            trimmed.covered[axis] = covers(reached, range);
            if !trimmed.covered[axis] {
                trimmed.warnings.push(SurfaceWarning::RangeNotCovered { field, reached, range });
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

    fn grid(&mut self, roll: &[f64], z: &[f64], height: impl Fn(usize) -> f64) -> Result<Nodes, check::Faults> {
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

    fn scattered(&mut self, roll: &[f64], z: &[f64], height: impl Fn(usize) -> f64) -> Result<Nodes, check::Faults> {
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

/// How much longer than the face nodes may reach: a probe begins and ends beside it.
const OVERRUN: f64 = 0.05;

/// Whether nodes reach farther than the face of the gear.
fn beyond_face(gear: &Gear, [low, high]: [f64; 2]) -> Option<SurfaceWarning> {
    let face_width = gear.data().face_width?;
    let span = high - low;
    (span > (1.0 + OVERRUN) * face_width).then_some(SurfaceWarning::BeyondFace { span, face_width })
}

/// Nodes on the end of a range belong to it, but for rounding.
fn within(x: f64, [low, high]: [f64; 2]) -> bool {
    x >= low - EDGE && x <= high + EDGE
}

/// Share of a range that may be without nodes at either end, where they lie closer.
const OPEN_END: f64 = 0.05;

/// Refuses places that leave more of the range open at an end than the distance of the two that are
/// nearest to it, and than a twentieth of the range.
fn cover(places: impl Iterator<Item = f64>, range: [f64; 2], field: SurfaceField) -> Result<(), SurfaceFaults> {
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
        return Err(SurfaceFaults::one(field, SurfaceReason::NotCovered { reached: [low[0], -high[0]], range }));
    }
    Ok(())
}

fn mapped(x: f64, [low, high]: [f64; 2]) -> f64 {
    (x - 0.5 * (low + high)) / (0.5 * (high - low))
}

/// The range without the shares at its ends.
fn cut([low, high]: [f64; 2], percent: [f64; 2], field: SurfaceField) -> Result<[f64; 2], SurfaceFaults> {
    let length = high - low;
    if !(length > 0.0 && length.is_finite()) {
        return Err(SurfaceFaults::one(field, Common::Range { range: [low, high] }));
    }
    Ok([low + 0.01 * percent[0] * length, high - 0.01 * percent[1] * length])
}

/// Places without an involute.
fn without_involute(found: Faults<usize, NoInvolute>, field: impl Fn(usize) -> SurfaceField) -> SurfaceFaults {
    found.placed(field).widened()
}

fn check(nodes: &FlankNodes, border: &Border) -> Result<(), SurfaceFaults> {
    let mut faults = SurfaceFaults::default();
    let (rows, columns) = (nodes.profile.len(), nodes.z.len());
    let count = if nodes.grid { rows.saturating_mul(columns) } else { rows };
    if count == 0 {
        faults.push(SurfaceField::Profile, SurfaceReason::NoNodes);
    }
    if !nodes.grid && columns != rows {
        faults.push(SurfaceField::Positions, SurfaceReason::Positions { given: columns, profile: rows });
    }
    let lengths = [
        (SurfaceField::Deviations, Some(nodes.deviation.len())),
        (SurfaceField::Valid, nodes.valid.map(<[bool]>::len)),
    ];
    for (field, length) in lengths {
        if let Some(given) = length.filter(|&length| length != count) {
            faults.push(field, Common::PerPosition { given, positions: count });
        }
    }
    for (index, &z) in nodes.z.iter().enumerate() {
        match z.abs() {
            size if size <= MOST_LENGTH => {}
            size if size.is_finite() => {
                let reason = Common::LengthBeyond { value: z, most: MOST_LENGTH };
                faults.push(SurfaceField::Position { index }, reason);
            }
            _ => faults.push(SurfaceField::Position { index }, Common::NotFinite),
        }
    }
    for (index, deviation) in nodes.deviation.iter().enumerate() {
        if deviation.is_infinite() {
            faults.push(SurfaceField::Deviation { index }, Common::NotFinite);
        }
    }
    let profile: fn(usize) -> SurfaceField = |index| SurfaceField::ProfileAt { index };
    let position: fn(usize) -> SurfaceField = |index| SurfaceField::Position { index };
    let axes = [(nodes.profile, profile), (nodes.z, position)];
    for (axis, field) in axes {
        for (i, pair) in axis.windows(2).enumerate().filter(|_| nodes.grid) {
            if pair[1] <= pair[0] && pair[0].is_finite() {
                faults.push(field(i + 1), Common::NotAscending { value: pair[1], before: pair[0] });
            }
        }
    }
    let shares = [
        (SurfaceField::BorderRoot, border.root),
        (SurfaceField::BorderTip, border.tip),
        (SurfaceField::BorderToe, border.toe),
        (SurfaceField::BorderHeel, border.heel),
    ];
    for (field, percent) in shares {
        if !(0.0..100.0).contains(&percent) {
            faults.push(field, SurfaceReason::Percent(percent));
        }
    }
    if border.root + border.tip >= 100.0 || border.toe + border.heel >= 100.0 {
        faults.push(SurfaceField::Border, SurfaceReason::NothingLeft);
    }
    faults.into_result(())
}
