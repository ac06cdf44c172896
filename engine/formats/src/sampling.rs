//! Curves and surfaces at chosen parameters: what facets and elements are made of.

use std::{cmp::Ordering, collections::BinaryHeap};

use flankfit_geometry::{curve::Curve, space::Vector, surface::Surface};
use flankfit_numerics::{cancel, check::Faults, words::Shown};

/// More nodes than this are refused for one surface.
pub const MOST_NODES: usize = 4_000_000;

/// Chords of one curve at most.
const MOST_CHORDS: usize = 1 << 20;

/// Refuses parameters that do not ascend, or are fewer than two.
pub(super) fn check(us: &[f64], vs: &[f64]) -> Result<(), Faults> {
    for values in [us, vs] {
        if values.len() < 2 {
            let given = values.len();
            let message = format_args!(
                "{given} parameters along one direction do not make faces; at least 2 are \
                needed"
            );
            return Err(Faults::one("", message));
        }
        if let Some(i) = (1..values.len()).find(|i| !(values[i - 1] < values[*i])) {
            let [before, value] = [values[i - 1], values[i]].map(Shown);
            let message = format_args!("parameter {i} ({value}) does not lie above the one before it ({before})");
            return Err(Faults::one("", message));
        }
    }
    Ok(())
}

fn too_many(wanted: usize) -> Faults {
    Faults::one("samples[0]", format_args!("{wanted} nodes are more than {MOST_NODES}"))
}

/// Refuses a point outside the range of a double at parameters (u, v).
pub(super) fn no_place(at: [f64; 2]) -> Faults {
    Faults::one("", format_args!("the place at the parameters {at:?} exceeds the range of double precision"))
}

/// Refuses a tolerance that nodes cannot be compared by.
pub(super) fn no_tolerance(tolerance: f64) -> Faults {
    let tolerance = Shown(tolerance);
    Faults::one("tolerance", format_args!("the tolerance {tolerance} is not a length above 0"))
}

/// Number of all nodes; refuses more than [`MOST_NODES`], before there is any list of that length.
pub(super) fn counted(surfaces: &[&dyn Surface], intervals: [usize; 2]) -> Result<usize, Faults> {
    let nodes = |surface: &dyn Surface| {
        let [us, vs] = surface.breaks().map(|breaks| breaks.len().saturating_sub(1));
        let along = |pieces: usize, steps: usize| pieces.saturating_mul(steps.max(1)).saturating_add(1);
        along(us, intervals[0]).saturating_mul(along(vs, intervals[1]))
    };
    let wanted = surfaces.iter().fold(0usize, |sum, surface| sum.saturating_add(nodes(*surface)));
    if wanted > MOST_NODES { Err(too_many(wanted)) } else { Ok(wanted) }
}

/// `intervals` equal steps (at least one) from each value to the next; the values given are met
/// exactly.
///
/// ```
/// use flankfit_formats::sampling::between;
///
/// assert_eq!(between(&[0.0, 1.0, 3.0], 2), [0.0, 0.5, 1.0, 2.0, 3.0]);
/// ```
pub fn between(values: &[f64], intervals: usize) -> Vec<f64> {
    let steps = intervals.max(1);
    let inner = |pair: &[f64], k: usize| pair[0] + (pair[1] - pair[0]) * (k as f64 / steps as f64);
    let mut all: Vec<f64> = values
        .windows(2)
        .flat_map(|pair| (0..steps).map(move |k| if k == 0 { pair[0] } else { inner(pair, k) }))
        .collect();
    all.extend(values.last());
    all
}

/// Parameters at which chords stay within `tolerance` (mm) of the curve, looked at in three places
/// of each chord.
///
/// Breaks are always among them. The chord that strays most is halved first; a tolerance that takes
/// more than a million chords, or lies below the rounding of the places, is refused with what was
/// reached.
pub fn curve_parameters(curve: &dyn Curve, tolerance: f64) -> Result<Vec<f64>, Faults> {
    if !(tolerance > 0.0) {
        return Err(no_tolerance(tolerance));
    }
    let breaks = curve.breaks();
    let chord = |a: f64, b: f64| Chord { ends: [a, b], strays: sagitta(curve, a, b) };
    let mut waiting = BinaryHeap::new();
    for pair in breaks.windows(2) {
        // one halving at least, lest an S look straight
        let middle = pair[0] + (pair[1] - pair[0]) / 2.0;
        waiting.extend([chord(pair[0], middle), chord(middle, pair[1])]);
    }
    if waiting.len() > MOST_CHORDS {
        let wanted = waiting.len();
        return Err(Faults::one("tolerance", format_args!("{wanted} nodes are more than {MOST_CHORDS}")));
    }
    while let Some(worst) = waiting.peek().copied().filter(|worst| !(worst.strays <= tolerance)) {
        let [a, b] = worst.ends;
        let middle = a + (b - a) / 2.0;
        if !worst.strays.is_finite() {
            return Err(no_place([middle, 0.0]));
        }
        if waiting.len() == MOST_CHORDS || !(a < middle && middle < b) {
            let [tolerance, reached] = [tolerance, worst.strays].map(Shown);
            return Err(Faults::one(
                "tolerance",
                format_args!(
                    "a million chords, or rounding, allow a distance of {reached} from the curve only, not {tolerance}"
                ),
            ));
        }
        cancel::checkpoint();
        waiting.pop();
        waiting.extend([chord(a, middle), chord(middle, b)]);
    }
    let mut all: Vec<f64> = waiting.into_iter().map(|chord| chord.ends[0]).chain(breaks.last().copied()).collect();
    all.sort_by(cancel::comparing(f64::total_cmp));
    Ok(all)
}

/// A chord and how far the curve strays from it; the one that it strays from most is the greatest.
#[derive(Clone, Copy, Debug)]
struct Chord {
    ends: [f64; 2],
    strays: f64,
}

impl Ord for Chord {
    fn cmp(&self, other: &Self) -> Ordering {
        // alike: the place decides, so that the order is always the same
        self.strays.total_cmp(&other.strays).then(self.ends[0].total_cmp(&other.ends[0]))
    }
}

impl PartialOrd for Chord {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Chord {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Chord {}

/// Greatest distance of the curve over [a, b] from its chord.
fn sagitta(curve: &dyn Curve, a: f64, b: f64) -> f64 {
    let [start, end] = [a, b].map(|t| curve.place(t)[0]);
    let chord = end - start;
    let distance = |share: f64| {
        let offset = curve.place(a + (b - a) * share)[0] - start;
        let along =
            if chord.norm_squared() > 0.0 { (offset.dot(&chord) / chord.norm_squared()).clamp(0.0, 1.0) } else { 0.0 };
        (offset - chord * along).norm()
    };
    [0.25, 0.5, 0.75].map(distance).into_iter().fold(0.0, f64::max)
}

/// Places of a curve.
pub fn curve_nodes(curve: &dyn Curve, parameters: &[f64]) -> Result<Vec<Vector>, Faults> {
    let place = |t: &f64| {
        let place = curve.place(*t)[0];
        if place.iter().all(|x| x.is_finite()) { Ok(place) } else { Err(no_place([*t, 0.0])) }
    };
    parameters.iter().map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use flankfit_geometry::{BSplineBasis, curve::BSplineCurve, space::Dimension};

    #[test]
    fn chords_of_a_circle() {
        let basis = BSplineBasis::new(2, vec![0., 0., 0., 1., 1., 1.]).unwrap();
        let points = [[10., 0.], [10., 10.], [0., 10.]].map(|[x, y]| Vector::new(x, y, 0.0)).to_vec();
        let arc = BSplineCurve::new(basis, Dimension::Plane, points, Some(vec![1.0, 0.5f64.sqrt(), 1.0])).unwrap();
        let parameters = curve_parameters(&arc, 1e-3).unwrap();
        let nodes = curve_nodes(&arc, &parameters).unwrap();
        assert!(parameters.windows(2).all(|p| p[0] < p[1]) && nodes.len() < 100);
        for pair in nodes.windows(2) {
            assert!(10.0 - ((pair[0] + pair[1]) / 2.0).norm() < 1.01e-3);
        }
        assert_eq!(curve_parameters(&arc, 0.0), Err(no_tolerance(0.0)));
        // 2.05e-8 was reached where no more than 12 halvings were made
        let fine = curve_nodes(&arc, &curve_parameters(&arc, 1e-10).unwrap()).unwrap();
        assert!(fine.windows(2).all(|pair| 10.0 - ((pair[0] + pair[1]) / 2.0).norm() < 1.01e-10));
        // a tolerance below rounding is refused, in bounded time
        let refused = curve_parameters(&arc, 1e-30).unwrap_err().to_string();
        assert!(refused.ends_with("from the curve only, not 1e-30"), "{refused}");
        let words = refused.strip_prefix("tolerance: a million chords, or rounding, allow a distance of ").unwrap();
        let reached: f64 = words.split(' ').next().unwrap().parse().unwrap();
        assert!(reached > 1e-30 && reached < 1e-10, "{reached}");
    }

    #[test]
    fn values_given_are_met() {
        assert_eq!(between(&[0.5, 0.75, 2.0], 2), [0.5, 0.625, 0.75, 1.375, 2.0]);
        assert_eq!(between(&[0.1, 0.3], 0), [0.1, 0.3]);
    }
}
