//! Continuity of a surface across the lines where its pieces meet: borders of patches and knots
//! alike.
//!
//! Along each such line both sides are sampled at the same places, a few roundings to either side
//! of it. Reported is the worst of each: the gap (C⁰), the angle between normals (G¹), the jump of
//! the first derivatives (C¹), of the second (C²) and of the principal curvatures (G², where G¹
//! holds). Whoever knows what is small for him turns figures into classes: [`Joint::class`].

use super::{Differential, Surface, SurfaceJet, local::normal};
use flankfit_numerics::cancel;

/// How far from the line either side is looked at, in roundings of the largest parameter.
const ASIDE: f64 = 8.0 * f64::EPSILON;

/// The largest of some results, and the place where it was found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema))]
pub struct Worst {
    /// The largest result.
    pub value: f64,
    /// `[u, v]`, where it was found.
    #[cfg_attr(feature = "contract", schema(value_type = Vec<f64>, min_items = 2, max_items = 2))]
    pub at: [f64; 2],
}

impl Worst {
    pub(super) fn see(&mut self, value: f64, at: [f64; 2]) {
        if value > self.value || self.at == [0.0; 2] && value >= self.value {
            *self = Worst { value, at };
        }
    }
}

/// One line between two pieces, from one crossing line to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// Which parameter is constant on the line: 0 for u.
    pub axis: usize,
    /// Its value there.
    pub at: f64,
    /// The other parameter's range.
    pub along: [f64; 2],
    /// Distance of the two sides.
    pub gap: Worst,
    /// Angle between the normals of the two sides, in radians; none where either has no normal at
    /// any sample.
    pub normal_angle: Option<Worst>,
    /// Length of the jump of S_u or S_v, whichever is longer.
    pub first_derivative: Worst,
    /// Length of the jump of S_uu, S_uv or S_vv, whichever is longest.
    pub second_derivative: Worst,
    /// Jump of either principal curvature (as sorted); none where there is no curvature.
    pub curvature: Option<Worst>,
}

/// Tolerances of continuity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContinuityTolerance {
    /// In units of the coordinates.
    pub gap: f64,
    /// In radians.
    pub angle: f64,
    /// Jump of first derivatives, in units of the coordinates per unit of the parameter.
    pub first: f64,
    /// Jump of second derivatives, in units of the coordinates per squared unit of the parameter.
    pub second: f64,
}

/// Continuity of two patches, from worst to best: a gap; a common line with an edge; a common
/// tangent plane; equal first derivatives; equal second derivatives, hence equal curvature.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum ContinuityClass {
    /// The patches have a gap.
    Apart,
    /// One point set, with an edge.
    C0,
    /// One tangent plane.
    G1,
    /// The same first derivatives.
    C1,
    /// The same second derivatives, hence one curvature.
    C2,
}

impl Joint {
    /// The best class whose figures, and those of all classes below, are within `tolerance`. Where
    /// no normal exists the derivatives decide.
    pub fn class(&self, tolerance: &ContinuityTolerance) -> ContinuityClass {
        let flat = self.normal_angle.is_none_or(|angle| angle.value <= tolerance.angle);
        if !(self.gap.value <= tolerance.gap) {
            ContinuityClass::Apart
        } else if self.first_derivative.value <= tolerance.first {
            if self.second_derivative.value <= tolerance.second { ContinuityClass::C2 } else { ContinuityClass::C1 }
        } else if flat && self.normal_angle.is_some() {
            ContinuityClass::G1
        } else {
            ContinuityClass::C0
        }
    }
}

/// Every line inside of the domain along which `surface` is not known to be infinitely smooth,
/// looked at in `samples` (2 or more) places between any two crossing lines, close to the crossings
/// too.
pub fn joints(surface: &dyn Surface, samples: usize) -> Vec<Joint> {
    let (domain, breaks) = (surface.domain(), surface.breaks());
    let samples = samples.max(2);
    let mut joints = Vec::new();
    for axis in 0..2 {
        let [low, high] = domain[axis];
        let aside = ASIDE * low.abs().max(high.abs());
        for at in breaks[axis].iter().copied().filter(|x| *x > low + aside && *x < high - aside) {
            for span in breaks[1 - axis].windows(2) {
                cancel::checkpoint();
                joints.push(joint(surface, axis, at, aside, [span[0], span[1]], samples));
            }
        }
    }
    joints
}

fn joint(surface: &dyn Surface, axis: usize, at: f64, aside: f64, along: [f64; 2], samples: usize) -> Joint {
    let none = Worst::default();
    let mut found = Joint {
        axis,
        at,
        along,
        gap: none,
        normal_angle: None,
        first_derivative: none,
        second_derivative: none,
        curvature: None,
    };
    for k in 0..samples {
        // both ends are crossings with other lines, where it is not settled which piece counts
        let share = (k as f64 + 0.5 / samples as f64) / (samples as f64 - 1.0 + 1.0 / samples as f64);
        let t = along[0] + share * (along[1] - along[0]);
        let place = |x: f64| if axis == 0 { (x, t) } else { (t, x) };
        let (before, after) = (place(at - aside), place(at + aside));
        let here = place(at);
        let here = [here.0, here.1];
        let (a, b) = (surface.place(before.0, before.1), surface.place(after.0, after.1));
        found.gap.see(distance(&a, &b, aside), here);
        found.first_derivative.see((b.u - a.u).norm().max((b.v - a.v).norm()), here);
        let second = (b.uu - a.uu).norm().max((b.uv - a.uv).norm()).max((b.vv - a.vv).norm());
        found.second_derivative.see(second, here);
        let sides = [(before, &a), (after, &b)].map(|((u, v), jet)| (Differential::at_jet(surface, jet, u, v), u, v));
        let normals = sides.map(|(side, u, v)| side.map_or_else(|| normal(surface, u, v), |side| Some(side.normal)));
        if let [Some(m), Some(n)] = normals {
            // sine and cosine together keep the digits of small angles
            let angle = m.cross(&n).norm().atan2(m.dot(&n));
            found.normal_angle.get_or_insert(none).see(angle, here);
        }
        if let [(Some(m), ..), (Some(n), ..)] = sides {
            let change = (0..2).fold(0.0f64, |most, i| most.max((m.principal[i] - n.principal[i]).abs()));
            found.curvature.get_or_insert(none).see(change, here);
        }
    }
    found
}

/// The gap, without what the surface itself moves between the two places looked at.
fn distance(a: &SurfaceJet, b: &SurfaceJet, aside: f64) -> f64 {
    let own = 2.0 * aside * (a.u.norm() + a.v.norm()).max(b.u.norm() + b.v.norm());
    ((b.value - a.value).norm() - own).max(0.0)
}
