//! The sign of helix traces against that of the profiles they cross.
//!
//! On many testers the sign of a helix trace is a convention of its own: it may count a slope
//! towards one end of the face instead of material, as profiles do. Where both cross they touched
//! the same point, so the file itself says which of the two it is.

use std::collections::BTreeMap;

use crate::{gear::Kind, numerics::cancel};

/// Traces of a kind that are compared.
const MOST_TRACES: usize = 100;
/// Helix traces are turned where that leaves less than this share of the distance at the crossings.
const CLEARLY: f64 = 0.2;
/// Fewest crossings by which helix traces are turned: zeros of their own may make a few agree.
const FEWEST: u32 = 4;
/// Distances below this share of the range of the heights are noise: they turn nothing.
const NOISE: f64 = 0.05;

/// How far helix traces and profiles of a side are apart where they cross: root mean square, in
/// the unit of the heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossings {
    /// As the file has them.
    pub as_given: f64,
    /// With the sign of the helix traces changed.
    pub turned: f64,
    /// Greatest less least height of all traces.
    pub range: f64,
    /// Number of crossings.
    pub count: u32,
}

impl Crossings {
    /// True if the helix traces count the other way.
    pub fn helices_are_turned(&self) -> bool {
        self.count >= FEWEST && self.turned < CLEARLY * self.as_given && self.as_given > NOISE * self.range
    }

    /// Those of several teeth together; `None` of none.
    pub(super) fn pooled(teeth: &[Self]) -> Option<Self> {
        let count = teeth.iter().map(|one| one.count).sum();
        let rms = |of: fn(&Self) -> f64| {
            let sum: f64 = teeth.iter().map(|one| f64::from(one.count) * of(one).powi(2)).sum();
            (sum / f64::from(count)).sqrt()
        };
        let (as_given, turned) = (rms(|one| one.as_given), rms(|one| one.turned));
        let range = teeth.iter().map(|one| one.range).fold(0.0, f64::max);
        (count > 0).then_some(Crossings { as_given, turned, range, count })
    }

    /// Takes samples of traces: roll length, place along the face and height, which may be NaN.
    /// `None` where nothing crosses.
    pub(super) fn of(samples: impl Iterator<Item = (Kind, [f64; 3])>) -> Option<Self> {
        let (mut helices, mut profiles) = (BTreeMap::new(), BTreeMap::new());
        let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        for (k, (kind, [along, across, height])) in samples.enumerate() {
            cancel::every(10, k);
            if height.is_nan() {
                continue;
            }
            (least, greatest) = (least.min(height), greatest.max(height));
            let (traces, at, running) = match kind {
                Kind::Helix => (&mut helices, along, across),
                Kind::Profile => (&mut profiles, across, along),
            };
            traces.entry(at.to_bits()).or_insert_with(Vec::new).push((running, height));
        }
        for trace in helices.values_mut().chain(profiles.values_mut()) {
            trace.sort_unstable_by(cancel::comparing(|a: &(f64, f64), b: &(f64, f64)| a.0.total_cmp(&b.0)));
        }
        let (mut same, mut opposite, mut crossings) = (0.0, 0.0, 0_u32);
        for (along, helix) in helices.iter().take(MOST_TRACES) {
            cancel::checkpoint();
            for (across, profile) in profiles.iter().take(MOST_TRACES) {
                let on_helix = height(helix, f64::from_bits(*across));
                if let (Some(a), Some(b)) = (on_helix, height(profile, f64::from_bits(*along))) {
                    same += (a - b).powi(2);
                    opposite += (a + b).powi(2);
                    crossings += 1;
                }
            }
        }
        let rms = |sum: f64| (sum / f64::from(crossings)).sqrt();
        (crossings > 0).then(|| Crossings {
            as_given: rms(same),
            turned: rms(opposite),
            range: greatest - least,
            count: crossings,
        })
    }
}

/// Height at a place of a trace, linear between the neighbouring samples.
fn height(trace: &[(f64, f64)], at: f64) -> Option<f64> {
    let next = trace.partition_point(|(place, _)| *place < at);
    let (b, to) = *trace.get(next)?;
    if b == at {
        return Some(to);
    }
    let (a, from) = *trace.get(next.checked_sub(1)?)?;
    Some(from + (to - from) * (at - a) / (b - a))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Profiles z = 2 u at v = 0 and v = 2 and a helix at u = 1, which rises from 1 to 3 there:
    /// the profiles have 2 at both crossings, the helix 1 and 3.
    #[test]
    fn distances_at_crossings() {
        let sampled = |kind, places: [[f64; 3]; 2]| places.map(|place| (kind, place)).to_vec();
        let helix = |sign: f64| sampled(Kind::Helix, [[1.0, 2.0, 3.0 * sign], [1.0, 0.0, sign]]);
        let profile = |v: f64| sampled(Kind::Profile, [[0.0, v, 0.0], [2.0, v, 4.0]]);
        let of = |helix: Vec<_>| Crossings::of([helix, profile(0.0), profile(2.0)].concat().into_iter());
        let given = of(helix(1.0)).expect("crossings");
        assert_eq!((given.as_given, given.turned, given.range), (1.0, 17.0_f64.sqrt(), 4.0));
        let opposite = of(helix(-1.0)).expect("crossings");
        assert_eq!((opposite.as_given, opposite.turned), (given.turned, given.as_given));
        let one = |as_given, turned, count| Crossings { as_given, turned, range: 10.0, count };
        let turned = |as_given, turned, count| one(as_given, turned, count).helices_are_turned();
        let pooled = Crossings::pooled(&[one(4.0, 0.0, 1), one(8.0, 1.0, 3)]).expect("crossings");
        assert_eq!(pooled, one(52.0_f64.sqrt(), 0.75_f64.sqrt(), 4));
        assert!(turned(5.0, 0.9, 4) && !turned(5.0, 1.1, 4) && !turned(0.9, 5.0, 4));
        assert!(!turned(5.0, 0.9, 3), "a trace with its own zero may agree by chance");
        assert!(!turned(0.02, 0.0, 9), "traces that are zeroed where they cross differ there by rounding alone");
        assert_eq!(Crossings::of(helix(1.0).into_iter()), None);
        let undefined = sampled(Kind::Helix, [[1.0, 2.0, f64::NAN], [1.0, 0.0, f64::NAN]]);
        assert_eq!(of(undefined), None);
        let outside = sampled(Kind::Helix, [[3.0, 0.0, 1.0], [3.0, 2.0, 1.0]]);
        assert_eq!(of(outside), None);
    }
}
