//! Where a registration begins: which flank every point belongs to, and the motions to within what the iteration
//! closes.
//!
//! A point that is nearest to a flank need not belong to it: a part that lies turned by a quarter of a pitch, or off
//! centre by a module, has most of its points nearest to others. So the rotation is sought over a whole pitch and
//! shifts over a disc of two modules. By how much the gear must be turned for a flank to pass through a point follows
//! in closed form ([`crate::gear::deviation::foot::phase`]), so that one shift costs one such angle per point and side,
//! and every rotation a comparison. The best places are refined by damped least squares in all motions that are free,
//! every point going to the nearest flank anew after each step, and far ones counting little. Of places that fit alike
//! the one with the least motion is taken.
//!
//! Rotations by whole pitches carry the teeth into each other: only points whose tooth is told (`tooth` of a [`Touch`])
//! say how many. With teeth *and* flanks told nothing is sought: the rotation is the mean angle, over the full circle.

use super::{
    Registering,
    columns::Freedom,
    pose::{Pose, Undoing},
    search::Search,
};
use crate::{
    estimation::Faults,
    gear::{
        Gear, Side,
        deviation::{
            Foot, Touch,
            foot::{foot, normal},
        },
    },
    geometry::space::Vector,
    numerics::cancel::Asking,
};

/// Most points that the search looks at.
const MOST_POINTS: usize = 240;
/// A part that lies nearer than this to where it should (root mean square over the points, modules) begins where it
/// should: regularisation then counts from there.
const AT_HOME: f64 = 0.1;

/// Where a registration begins.
#[derive(Clone, Debug)]
pub struct Start {
    pub pose: Pose,
    /// The points carried back by `pose`, in their order; what is not told of them stays open.
    pub touches: Vec<Touch>,
    /// Whether no point tells how many whole pitches the part is turned by, though it may be turned.
    pub teeth_assumed: bool,
    /// Whether points told to be of one tooth lie on others when most lie where they are told to.
    pub teeth_contradict: bool,
    /// Whether points may lie on other flanks as well, by another motion that fits alike.
    pub flanks_ambiguous: bool,
    /// The side that each point was nearest to as it was measured.
    before: Vec<Option<Side>>,
}

impl Start {
    /// Whether an open point was nearest to the other side before.
    pub(super) fn left(&self, index: usize, side: Side) -> bool {
        self.before.get(index).is_some_and(|before| before.is_some_and(|before| before != side))
    }
}

/// Finds where to begin. Faults are those of [`Freedom::new`].
pub fn start(gear: &Gear, touches: &[Touch], ball: f64, asked: &Registering) -> Result<Start, Faults> {
    let freedom = Freedom::new(gear, asked.motions)?;
    let defined: Vec<&Touch> = touches.iter().filter(|touch| touch.point.iter().all(|x| x.is_finite())).collect();
    let z = defined.iter().map(|touch| touch.point.z);
    let [low, high] = z.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], z| [a.min(z), b.max(z)]);
    let middle = if defined.is_empty() { 0.0 } else { 0.5 * (low + high) };
    let stride = defined.len().div_ceil(MOST_POINTS).max(1);
    let search = Search {
        gear,
        freedom,
        scaling: asked.spec.scaling,
        pivot: asked.pivot.filter(|z| z.is_finite()).unwrap_or(middle),
        ball,
        told: defined.iter().all(|touch| touch.tooth.is_some() && touch.side.is_some()),
        // a stride that divides the number of points of a trace would take the same place of each
        points: defined
            .iter()
            .enumerate()
            .filter(|(i, _)| (i + i / 7) % stride == 0)
            .map(|(_, touch)| **touch)
            .collect(),
    };
    let still = search.pose(&vec![0.0; search.freedom.columns.len()]);
    let open = |pose: Pose| Start {
        touches: carried(&pose.undoing(), touches),
        pose,
        teeth_assumed: false,
        teeth_contradict: false,
        flanks_ambiguous: false,
        before: touches.iter().asking(200).map(|touch| nearest(gear, touch, ball).map(|foot| foot.side)).collect(),
    };
    if search.points.len() < search.freedom.columns.len() {
        return Ok(open(still));
    }
    let (best, flanks_ambiguous) =
        if search.told { (search.refined(search.mean_angle()), false) } else { search.best() };
    let (p, votes) = search.counted(best.p);
    let free = search.freedom.screw(gear).is_some();
    let pose = if search.motion(&p) < AT_HOME * search.module() { still } else { search.pose(&p) };
    Ok(Start {
        teeth_assumed: free && votes.is_none(),
        teeth_contradict: votes.is_some_and(|agreed| agreed < 0.9),
        flanks_ambiguous,
        ..open(if pose.is_sane() { pose } else { still })
    })
}

fn carried(undoing: &Undoing, touches: &[Touch]) -> Vec<Touch> {
    let each = touches.iter().asking(100);
    each.map(|touch| Touch {
        point: undoing.point(&touch.point),
        normal: touch.normal.map(|normal| undoing.direction(&normal)),
        ..*touch
    })
    .collect()
}

/// The nearest foot on the flanks that a point may belong to.
pub(super) fn nearest(gear: &Gear, touch: &Touch, ball: f64) -> Option<Foot> {
    let on = |side: Side| {
        let found = foot(gear, side, touch.tooth, &touch.point, ball).ok()?;
        let along = |given: Vector| given.dot(&normal(gear, found.tooth, side, found.roll_length, found.z)) > 0.0;
        touch.normal.is_none_or(along).then_some(found)
    };
    match touch.side {
        Some(side) => on(side),
        None => match (on(Side::Left), on(Side::Right)) {
            (Some(left), Some(right)) if right.distance.abs() < left.distance.abs() => Some(right),
            (left, right) => left.or(right),
        },
    }
}
