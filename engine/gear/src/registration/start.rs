//! Start of a registration: the flank of every point, and approximate motions.
//!
//! A point that is nearest to a flank need not belong to it: a part that lies turned by a quarter
//! of a pitch, or off centre by a module, has most of its points nearest to others. So the rotation
//! is sought over a whole pitch and shifts over a disc of two modules. By how much the gear must be
//! turned for a flank to pass through a point follows in closed form
//! ([`crate::deviation::foot::phase`]), so that one shift costs one such angle per point and
//! side, and every rotation a comparison. The best places are refined by damped least squares in
//! all motions that are free, every point going to the nearest flank anew after each step, and far
//! ones counting little. Of places that fit alike the one with the least motion is taken.
//!
//! Rotations by whole pitches carry the teeth into each other: only points whose tooth is given
//! (`tooth` of a [`MeasuredPoint`]) say how many. With teeth *and* flanks given nothing is sought
//! where they agree: the rotation is the angle that most of them ask for, over the full circle.
//! Where they do not agree the part is laid by the nearest flanks, and turned by what most teeth
//! say; the others are taken for wrongly named. Without a majority there is no place.

use super::{
    Registering,
    columns::Freedom,
    nearest::nearest,
    pose::{InversePose, Pose},
    search::{Candidate, Search},
    teeth::Agreement,
};
use crate::{Gear, Side, deviation::MeasuredPoint};
use flankfit_numerics::{
    cancel::Asking,
    check::Faults,
    words::{Shown, counted},
};

/// Most points that the search looks at.
const MOST_POINTS: usize = 240;
/// A part that lies nearer than this to where it should (root mean square over the points, modules)
/// begins where it should: regularisation then counts from there.
const AT_HOME: f64 = 0.1;

/// Share of given teeth that must agree: more than half.
const LEAST_AGREE: f64 = 0.5;
/// Share from which a few that disagree are not mentioned where the part fits badly.
const MOST_AGREE: f64 = 0.9;
/// A place without given teeth is better than theirs where its cost is less than so many of it.
const LESS_COST: f64 = 0.25;

/// Start of a registration.
#[derive(Clone, Debug)]
pub struct Start {
    /// The motions that were found.
    pub pose: Pose,
    /// The points carried back by `pose`, in their order; what is not given of them stays open.
    pub touches: Vec<MeasuredPoint>,
    /// True if no point determines how many whole pitches the part is turned by, though it may be
    /// turned.
    pub teeth_assumed: bool,
    /// How many points lie on another tooth than they are said to be of, when most lie where they
    /// are said to. Their teeth are open in `touches`.
    pub teeth_contradict: usize,
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
pub fn start(gear: &Gear, touches: &[MeasuredPoint], ball: f64, asked: &Registering) -> Result<Start, Faults> {
    let freedom = Freedom::new(gear, asked.motions)?;
    let defined: Vec<&MeasuredPoint> =
        touches.iter().filter(|touch| touch.point.iter().all(|x| x.is_finite())).collect();
    let z = defined.iter().map(|touch| touch.point.z);
    let [low, high] = z.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], z| [a.min(z), b.max(z)]);
    let middle = if defined.is_empty() { 0.0 } else { 0.5 * (low + high) };
    let stride = defined.len().div_ceil(MOST_POINTS).max(1);
    let search = Search {
        gear,
        freedom,
        pivot: asked.pivot.filter(|z| z.is_finite()).unwrap_or(middle),
        ball,
        named: defined.iter().all(|touch| touch.tooth.is_some() && touch.side.is_some()),
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
        teeth_contradict: 0,
        flanks_ambiguous: false,
        before: touches.iter().asking(200).map(|touch| nearest(gear, touch, ball).map(|foot| foot.side)).collect(),
    };
    if search.points.len() < search.freedom.columns.len() {
        return Ok(open(still));
    }
    let SearchEnd { p, flanks_ambiguous, agreement } = begun(&search)?;
    let pose = if search.motion(&p) < AT_HOME * search.module() { still } else { search.pose(&p) };
    let mut start = open(if pose.is_sane() { pose } else { still });
    start.teeth_assumed = search.freedom.screw(gear).is_some() && agreement.is_none();
    start.flanks_ambiguous = flanks_ambiguous;
    let Some(said) = agreement.filter(|said| said.share < 1.0) else { return Ok(start) };
    let undoing = search.pose(&p).undoing();
    let off = |touch: &MeasuredPoint| search.pitches_off(&undoing, touch).is_some_and(|pitches| pitches > 0);
    let given = touches.iter().enumerate().asking(200).filter(|(_, touch)| touch.point.iter().all(|x| x.is_finite()));
    let contradicting: Vec<usize> = given.filter(|(_, touch)| off(touch)).map(|(i, _)| i).collect();
    if said.is_sure {
        // a tooth that most others contradict is a wrong name
        contradicting.iter().for_each(|&i| start.touches[i].tooth = None);
        start.teeth_contradict = contradicting.len();
    } else if said.share < MOST_AGREE {
        start.teeth_contradict = contradicting.len();
    }
    Ok(start)
}

/// End of the search.
struct SearchEnd {
    p: Vec<f64>,
    flanks_ambiguous: bool,
    /// Agreement with the given teeth there; `None` where none is given.
    agreement: Option<Agreement>,
}

/// The place by the given teeth where these agree, else by the flanks that are nearest, turned by
/// what most teeth say.
fn begun(search: &Search) -> Result<SearchEnd, Faults> {
    let open = search.open();
    // tilts and shifts may bring a wrong name's points within half a pitch of its tooth, but not
    // onto its flanks
    let by_names = search.named.then(|| search.refined(search.usual_angle())).map(|place| {
        let agreement = search.agreement(&place.p);
        (Candidate { cost: open.cost(&place.p), ..place }, agreement)
    });
    if let Some((place, Some(said))) = &by_names
        && said.is_whole()
        && open.lies_on_flanks(place)
    {
        return Ok(SearchEnd { p: place.p.clone(), flanks_ambiguous: false, agreement: Some(*said) });
    }
    let (best, flanks_ambiguous) = match (open.best(), by_names) {
        ((best, _), Some((place, _))) if best.cost >= LESS_COST * place.cost => (place, false),
        (found, _) => found,
    };
    let sure = open.lies_on_flanks(&best) && !flanks_ambiguous;
    if search.named && !sure {
        // the part fits badly, whatever its teeth are called
        return Ok(SearchEnd { p: best.p, flanks_ambiguous: false, agreement: Some(Agreement::ASSUMED) });
    }
    let agreement = search.agreement(&best.p).map(|said| Agreement { is_sure: sure, ..said });
    match agreement.filter(|said| said.is_sure) {
        Some(said) if said.share <= LEAST_AGREE => {
            let percent = Shown((100.0 * said.share).round());
            return Err(Faults::one(
                "teeth",
                format_args!(
                    "the teeth contradict each other: however the part is turned, at most {percent} % of the points lie \
                     on the teeth that they are said to be of. Count teeth clockwise from 1, or leave `teeth` out"
                ),
            ));
        }
        Some(said) if said.pitches > 0 && !search.may_turn() => {
            let turned = said.turned_on(search.gear.data().teeth);
            let pitches = counted(turned as usize, "pitch", "pitches");
            return Err(Faults::one(
                "teeth",
                format_args!(
                    "the points lie {pitches} from the teeth that they are said to be of, and `rotation` is not among \
                     the motions: free it, or correct the teeth"
                ),
            ));
        }
        _ => {}
    }
    Ok(SearchEnd { p: search.counted(best.p, agreement), flanks_ambiguous, agreement })
}

fn carried(undoing: &InversePose, touches: &[MeasuredPoint]) -> Vec<MeasuredPoint> {
    let each = touches.iter().asking(100);
    each.map(|touch| MeasuredPoint {
        point: undoing.point(&touch.point),
        normal: touch.normal.map(|normal| undoing.direction(&normal)),
        ..*touch
    })
    .collect()
}
