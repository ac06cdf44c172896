//! The transverse section of a sector as quadrilaterals.
//!
//! Everything is laid out in polar coordinates. The rim reaches from its free circle along radial
//! lines to the root arc, to the lower part of the fillets and to a line across the tooth; the
//! tooth rests on that line with rows of one radius each. The line begins where the fillet has
//! become steeper than 45°, so that no angle of an element is flat.

use std::collections::HashMap;

use super::spec::{Elements, SolidSpec};
use crate::{
    Gear,
    generation::{
        Polar, Root,
        tooth::{Steps, Tooth},
    },
};
use flankfit_numerics::{check::Faults, words::rounded};

/// Part of the outline that an edge of a quadrilateral belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// The involute on the viewer's left, by tooth, from 1.
    LeftFlank(u32),
    /// The involute on the viewer's right.
    RightFlank(u32),
    /// Fillets and root arcs.
    Root,
    /// Tip arcs.
    Tip,
    /// The free circle of the rim.
    Rim,
    /// The cut counterclockwise of the sector.
    CutLeft,
    /// The cut clockwise of the sector.
    CutRight,
}

/// A quadrilateral: corners counterclockwise, then the middles of the edges that begin at them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Quad {
    pub nodes: [u32; 8],
    pub sides: [Option<Side>; 4],
}

/// Nodes and quadrilaterals; corners of quadrilaterals come first.
pub(super) struct Section {
    /// Radius and angle from the tooth's middle, counterclockwise.
    pub nodes: Vec<[f64; 2]>,
    pub corners: usize,
    pub quads: Vec<Quad>,
}

/// A place of the two grids, in half elements: of the rim (`None`) by column and row, of a tooth by
/// column within it and row.
type Key = (Option<u32>, usize, usize);

/// The flank from root to tip in half elements, and where its parts begin.
struct Flank {
    points: Vec<Polar>,
    /// The line across the tooth.
    base: usize,
    /// The involute.
    involute: usize,
}

impl Flank {
    fn new(gear: &Gear, elements: &Elements) -> Result<Self, Faults> {
        let twice = |count: usize| count.saturating_mul(2);
        let steps = Steps {
            involute: twice(elements.involute),
            fillet: twice(elements.fillet),
            tip: twice(elements.thickness),
            root: twice(elements.root),
        };
        let tooth = Tooth::new(gear, steps).map_err(|found| found.moved("steps", "elements"))?;
        if tooth.flank().last().is_none_or(|tip| tip.half_angle < 1e-9) {
            let message = "the flanks meet at the tip: hexahedra need a tip of some width; give a smaller tip diameter";
            return Err(Faults::one(gear.given_circle(), message).within("gear"));
        }
        let form = 0.5 * gear.diameter(Root::of(gear).form_roll());
        // radial parts are one step each
        let mut points: Vec<Polar> = Vec::new();
        for point in tooth.flank() {
            let radial = points.last().copied().filter(|last| last.half_angle == point.half_angle);
            if let Some(last) = radial {
                let count = twice(elements.fillet);
                points.extend((1..count).map(|k| Polar {
                    radius: last.radius + (point.radius - last.radius) * k as f64 / count as f64,
                    ..*point
                }));
            }
            points.push(*point);
        }
        let out = gear.outward();
        let steep = |pair: &[Polar]| {
            let (rise, turn) = (out * (pair[1].radius - pair[0].radius), pair[0].half_angle - pair[1].half_angle);
            (rise, pair[0].radius * turn)
        };
        let mut base = 0;
        while base + 2 < points.len() {
            let (rise, run) = steep(&[points[base], points[base + 2]]);
            if rise > run {
                break;
            }
            base += 2;
        }
        let back = |pair: &&[Polar]| !(steep(pair).0 > 0.0);
        let under = points[..=base].windows(2).find(|pair| !(steep(pair).1 > 0.0));
        if let Some(pair) = under.or_else(|| points[base..].windows(2).find(back)) {
            let diameter = rounded(2.0 * pair[0].radius, 7);
            return Err(Faults::one(
                "gear.profile_shift_coefficient",
                format_args!(
                    "the fillet bends back under the tooth at a diameter of {diameter} mm: such a root is not meshed"
                ),
            ));
        }
        let involute = points.iter().position(|p| out * (p.radius - form) >= -1e-12 * form).unwrap_or(base);
        Ok(Flank { points, base, involute: involute.max(base) })
    }
}

/// Angle and outer radius of the rim's columns over one pitch, in half elements.
fn columns(flank: &Flank, elements: &Elements, pitch: f64) -> (Vec<[f64; 2]>, [usize; 2]) {
    let (root, base) = (flank.points[0], flank.points[flank.base]);
    let half = 0.5 * pitch;
    let arc = half - root.half_angle > 1e-9 * half;
    let mut right: Vec<[f64; 2]> = Vec::new();
    let steps = if arc { 2 * elements.root } else { 0 };
    right.extend((0..steps).map(|k| {
        let share = k as f64 / steps as f64;
        [-half + (half - root.half_angle) * share, root.radius]
    }));
    right.extend(flank.points[..flank.base].iter().map(|p| [-p.half_angle, p.radius]));
    if let (false, Some(first)) = (arc, right.first_mut()) {
        first[0] = -half;
    }
    let across = 2 * elements.thickness;
    let from = right.len();
    let middle = (0..=across).map(|k| [base.half_angle * (2.0 * k as f64 / across as f64 - 1.0), base.radius]);
    let left: Vec<[f64; 2]> = right.iter().rev().map(|[angle, radius]| [-angle, *radius]).collect();
    let all = right.iter().copied().chain(middle).chain(left).collect();
    (all, [from, from + across])
}

/// Puts nodes of both grids into one row.
struct Builder<'a> {
    places: HashMap<Key, u32>,
    nodes: Vec<[f64; 2]>,
    place: &'a dyn Fn(Key) -> [f64; 2],
    same: &'a dyn Fn(Key) -> Key,
}

impl Builder<'_> {
    fn node(&mut self, key: Key) -> u32 {
        let key = (self.same)(key);
        let next = self.nodes.len() as u32;
        *self.places.entry(key).or_insert_with(|| {
            self.nodes.push((self.place)(key));
            next
        })
    }
}

impl Section {
    pub(super) fn new(gear: &Gear, spec: &SolidSpec, rim: f64) -> Result<Self, Faults> {
        let elements = &spec.elements;
        let flank = Flank::new(gear, elements)?;
        let pitch = gear.pitch_angle();
        let (column, [from, to]) = columns(&flank, elements, pitch);
        let (wide, deep, high) = (column.len() - 1, 2 * elements.rim, flank.points.len() - 1 - flank.base);
        let whole = spec.teeth == gear.data().teeth;
        let teeth = spec.teeth as usize;
        // tooth 1 is at the top, the others clockwise of it; places count from the right cut
        let turn = |tooth: usize| pitch * (tooth as f64 - (teeth as f64 - 1.0));
        let place = |(tooth, a, b): Key| match tooth {
            None => {
                let (own, within) = if a == wide * teeth { (teeth - 1, wide) } else { (a / wide, a % wide) };
                let [angle, top] = column[within];
                [rim + (top - rim) * b as f64 / deep as f64, angle + turn(own)]
            }
            Some(tooth) => {
                let point = flank.points[flank.base + b];
                let share = 2.0 * a as f64 / (to - from) as f64 - 1.0;
                [point.radius, point.half_angle * share + turn(tooth as usize)]
            }
        };
        let same = |key: Key| {
            let (tooth, a, b) = match key {
                (Some(tooth), a, 0) => (None, tooth as usize * wide + from + a, deep),
                other => other,
            };
            if tooth.is_none() && whole && a == wide * teeth { (None, 0, b) } else { (tooth, a, b) }
        };
        let number = |tooth: usize| (teeth - tooth) as u32;
        let mut cells: Vec<(Key, [Option<Side>; 4])> = Vec::new();
        for a in (0..wide * teeth).step_by(2) {
            for b in (0..deep).step_by(2) {
                let within = (from..to).contains(&(a % wide));
                let sides = [
                    (a == 0 && !whole).then_some(Side::CutRight),
                    (b + 2 == deep && !within).then_some(Side::Root),
                    (a + 2 == wide * teeth && !whole).then_some(Side::CutLeft),
                    (b == 0).then_some(Side::Rim),
                ];
                cells.push(((None, a, b), sides));
            }
        }
        for tooth in 0..teeth {
            for a in (0..to - from).step_by(2) {
                for b in (0..high).step_by(2) {
                    let fillet = flank.base + b < flank.involute;
                    let on = |side: Side| if fillet { Side::Root } else { side };
                    let sides = [
                        (a == 0).then(|| on(Side::RightFlank(number(tooth)))),
                        (b + 2 == high).then_some(Side::Tip),
                        (a + 2 == to - from).then(|| on(Side::LeftFlank(number(tooth)))),
                        None,
                    ];
                    cells.push(((Some(tooth as u32), a, b), sides));
                }
            }
        }
        Ok(Self::numbered(&cells, gear.data().internal, &place, &same))
    }

    /// Cells with their sides at low a, high b, high a and low b.
    fn numbered(
        cells: &[(Key, [Option<Side>; 4])],
        internal: bool,
        place: &dyn Fn(Key) -> [f64; 2],
        same: &dyn Fn(Key) -> Key,
    ) -> Self {
        // outwards, then counterclockwise, is counterclockwise; rows of internal teeth go inwards
        let around: [[usize; 2]; 8] = if internal {
            [[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1]]
        } else {
            [[0, 0], [0, 2], [2, 2], [2, 0], [0, 1], [1, 2], [2, 1], [1, 0]]
        };
        let mut builder = Builder { places: HashMap::new(), nodes: Vec::new(), place, same };
        let at = |(tooth, a, b): Key, [da, db]: [usize; 2]| (tooth, a + da, b + db);
        for (cell, _) in cells {
            for offset in &around[..4] {
                builder.node(at(*cell, *offset));
            }
        }
        let corners = builder.nodes.len();
        let quads = cells
            .iter()
            .map(|(cell, [low_a, high_b, high_a, low_b])| Quad {
                nodes: around.map(|offset| builder.node(at(*cell, offset))),
                sides: if internal { [*low_b, *high_a, *high_b, *low_a] } else { [*low_a, *high_b, *high_a, *low_b] },
            })
            .collect();
        Section { nodes: builder.nodes, corners, quads }
    }
}
