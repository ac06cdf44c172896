//! Sides of a rectangle that lie in the plane: lines of the section, wherever the surface goes from
//! there.

use super::{
    cells::Rectangle,
    chain::{Chain, Pieces},
    field::Kind,
};
use flankfit_numerics::cancel::checkpoint;

/// Steps along a side at which the slope across it is looked at.
const STEPS: usize = 32;
/// Every so many of these places are enough to begin the line with.
const COARSE: usize = 4;

/// Distance that counts as next to a side, in widths of the rectangle.
const BESIDE: f64 = 1e-3;

/// The four sides, each as the parameter that is fixed on it and at which end.
const SIDES: [(usize, usize); 4] = [(0, 0), (0, 1), (1, 0), (1, 1)];

/// Which of the sides lie in the plane.
pub(super) fn sides_within(rectangle: &Rectangle<'_>) -> Vec<(usize, usize)> {
    let [u, v] = rectangle.range;
    let ends = [[u[0], v[0]], [u[1], v[1]]];
    let within = |side: &(usize, usize)| rectangle.heights.side_within(rectangle.field, ends, *side, rectangle.contact);
    SIDES.into_iter().filter(within).collect()
}

/// Whether all places lie on one of these sides of the rectangle.
pub(super) fn on_side<'a>(
    range: &[[f64; 2]; 2],
    sides: &[(usize, usize)],
    mut places: impl Iterator<Item = &'a [f64; 2]> + Clone,
) -> bool {
    let near = |at: &[f64; 2], (axis, end): (usize, usize)| {
        let [low, high] = range[axis];
        (at[axis] - [low, high][end]).abs() <= 1e-6 * (high - low)
    };
    sides.iter().any(|side| places.clone().all(|at| near(at, *side))) && places.next().is_some()
}

/// Adds the sides that lie in the plane, divided where branches cross them.
pub(super) fn borders(rectangle: &Rectangle<'_>, sides: &[(usize, usize)], all: &mut Pieces) {
    for side in sides {
        checkpoint();
        border(rectangle, *side, all);
    }
}

fn border(rectangle: &Rectangle<'_>, (axis, end): (usize, usize), all: &mut Pieces) {
    let field = rectangle.field;
    let fixed = rectangle.range[axis][end];
    let [low, high] = rectangle.range[1 - axis];
    let place = |t: f64| -> [f64; 2] { if axis == 0 { [fixed, t] } else { [t, fixed] } };
    let at = |k: usize| if k == STEPS { high } else { low + (high - low) * (k as f64 / STEPS as f64) };
    let width = rectangle.range[axis][1] - rectangle.range[axis][0];
    let across = |t: f64| field.at(place(t)).slope[axis] * width;
    let flat = 1e3 * rectangle.contact;
    let touches = (1..STEPS).all(|k| across(at(k)).abs() <= flat);
    let beyond =
        |at: &[f64; 2]| (at[axis] - fixed).abs() > BESIDE * width || field.height(*at).abs() > rectangle.contact;
    // a side that is one place is no line
    if field.at(place(at(STEPS / 2))).is_pole() {
        let inside = if end == 0 { fixed + BESIDE * width } else { fixed - BESIDE * width };
        let height = |k: usize| field.height(if axis == 0 { [inside, at(k)] } else { [at(k), inside] });
        let above = height(0) > 0.0;
        if touches && (1..=STEPS).all(|k| (height(k) > 0.0) == above) {
            all.contacts.push(place(low));
            all.unresolved.retain(beyond);
        }
        return;
    }
    if touches {
        if !all.coincident {
            // along the side itself the slope may not change its sign
            all.unresolved.retain(beyond);
            let places = (0..=STEPS).step_by(COARSE).map(|k| (place(at(k)), Kind::Touching)).collect();
            all.chains.push(Chain { places, closed: false });
        }
        return;
    }
    let mut ends = vec![low];
    for k in 1..STEPS {
        let (from, to) = (at(k), at(k + 1));
        if across(from).abs() <= flat {
            ends.push(from);
        } else if across(to).abs() > flat && (across(from) > 0.0) != (across(to) > 0.0) {
            ends.push(field.crossing(place(from), place(to), Some(axis))[1 - axis]);
        }
    }
    ends.push(high);
    let crossings = ends[1..ends.len() - 1].iter().map(|t| place(*t));
    all.branches.extend(crossings);
    let kind = |t: f64| {
        let inner = t > low && t < high;
        if inner || across(t).abs() <= flat || field.at(place(t)).is_pole() { Kind::End } else { Kind::Across }
    };
    for pair in ends.windows(2) {
        let between = (0..=STEPS)
            .step_by(COARSE)
            .map(at)
            .filter(|t| *t > pair[0] && *t < pair[1])
            .map(|t| (place(t), Kind::Across));
        let mut places = vec![(place(pair[0]), kind(pair[0]))];
        places.extend(between);
        places.push((place(pair[1]), kind(pair[1])));
        all.chains.push(Chain { places, closed: false });
    }
}
