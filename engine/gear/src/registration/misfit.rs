//! Doubts about a converged registration: assumed teeth and flanks, implausible deviations.

use super::{
    Start,
    columns::Freedom,
    pose::{Motion, Pose},
    search::SHIFTS,
};
use crate::warning::Warning;
use crate::{Gear, deviation::Deviations};
use flankfit_numerics::quantiles::median;

/// Deviations of a flank are below this many µm and this many µm per mm of module: about what class
/// 11 of ISO 1328-1 allows.
pub(crate) const MISFIT: f64 = 10.0;
pub(crate) const MISFIT_PER_MODULE: f64 = 10.0;
/// Multiples of the scale (1.4826 × median absolute deviation) above which a point belongs to no
/// flank of the others.
const THRESHOLD: f64 = 8.0;
/// Distance outside the tip or root circle at which a point of a flank may lie, modules.
const BEYOND: f64 = 0.02;

/// Returns warnings about what the start had to assume.
pub(super) fn of_start(gear: &Gear, start: &Start, after: &Deviations) -> Vec<Warning> {
    let mut warnings = Vec::new();
    if start.teeth_assumed {
        warnings.push(Warning::RotationModuloPitch { pitch_urad: gear.pitch_angle() * 1e6 });
    }
    if start.teeth_contradict > 0 {
        warnings.push(Warning::TeethContradict { count: start.teeth_contradict });
    }
    if start.flanks_ambiguous {
        warnings.push(Warning::FlanksAmbiguous);
    }
    let open = |i: usize| start.touches.get(i).is_some_and(|touch| touch.side.is_none());
    let moved =
        after.nodes.iter().enumerate().filter(|(i, node)| node.counts() && open(*i) && start.left(*i, node.side));
    let moved = moved.count();
    if moved > 0 {
        warnings.push(Warning::FlanksReassigned { count: moved });
    }
    warnings
}

/// Returns a warning if an axial shift of a helical part takes up its rotation, which is not free.
pub(super) fn of_axial_shift(gear: &Gear, freedom: &Freedom, pose: &Pose) -> Option<Warning> {
    let shift = pose.get(Motion::AxialShift);
    let alone = freedom.determines(Motion::AxialShift) && !freedom.motions.contains(&Motion::Rotation);
    (alone && 1e-3 * shift.abs() > SHIFTS * gear.data().normal_module).then(|| Warning::AxialShiftForRotation {
        shift_um: shift,
        rotation_urad: -1e3 * shift * gear.turn_per_length(),
    })
}

/// Returns warnings about the remaining deviations.
pub(super) fn of_part(gear: &Gear, after: &Deviations, rows: &[usize]) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let scale = after.direction.from_normal(gear);
    let limit = MISFIT + MISFIT_PER_MODULE * gear.data().normal_module;
    let each: Vec<(usize, f64)> =
        rows.iter().map(|&i| (i, after.nodes[i].deviation / scale)).filter(|(_, d)| d.is_finite()).collect();
    let square: f64 = each.iter().map(|(_, d)| d * d).sum();
    let rms = (square / each.len().max(1) as f64).sqrt();
    if rms > limit {
        warnings.push(Warning::PoorFit { rms_um: rms, limit_um: limit });
    }
    if !each.is_empty() {
        let middle = median(&mut each.iter().map(|(_, d)| *d).collect::<Vec<f64>>());
        let usual = 1.4826 * median(&mut each.iter().map(|(_, d)| (d - middle).abs()).collect::<Vec<f64>>());
        let mut far = each.iter().filter(|(_, d)| (d - middle).abs() > limit.max(THRESHOLD * usual)).peekable();
        if let Some((first, deviation)) = far.peek().copied().copied() {
            warnings.push(Warning::PointsMisfit { count: far.count(), first, deviation_um: deviation });
        }
    }
    let slack = BEYOND * gear.data().normal_module;
    let (outward, tip, root) = (gear.outward(), gear.tip_radius(), gear.root_radius());
    let beyond = rows.iter().filter(|&&i| {
        let radius = 0.5 * after.nodes[i].diameter(gear);
        outward * (radius - tip) > slack || outward * (root - radius) > slack
    });
    let beyond = beyond.count();
    if beyond > 0 {
        warnings.push(Warning::PointsOutsideFlank { count: beyond });
    }
    warnings
}
