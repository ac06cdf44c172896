//! Sign and zeros of helix traces against those of the profiles they cross.
//!
//! On many testers the sign of a helix trace is a convention of its own: it may count a slope
//! towards one end of the face instead of material, as profiles do. And each trace may have a zero
//! of its own. Where two traces cross they touched the same point, so the file itself says which
//! sign it is and whether the zeros differ.

use std::collections::{BTreeMap, BTreeSet};

use flankfit_gear::Kind;
use flankfit_numerics::{cancel, distribution::fisher};

/// Traces of a kind that are compared.
const MOST_TRACES: usize = 100;
/// One sign is clearly right where it leaves less than this share of the distance that the other
/// one leaves.
const CLEARLY: f64 = 0.2;
/// Fewest crossings by which helix traces are turned: zeros of their own may make a few agree.
const FEWEST: u32 = 4;
/// Distances below this share of the range of the heights say nothing about the sign.
const NOISE: f64 = 0.05;
/// Difference of two strokes over one point without noise, as a share of the range.
const REPEATABLE: f64 = 0.015;
/// Probability that noise alone is taken for separate zeros.
const FALSE_ALARM: f64 = 0.01;
/// Probability that noise alone decides on the sign.
const WRONG_SIGN: f64 = 0.001;
/// Degrees of freedom of the noise, which neighbouring samples determine well.
const KNOWN: f64 = 100.0;
/// Sweeps in which the zeros of traces are estimated; one does where all of them cross.
const SWEEPS: usize = 50;
/// Traces of a kind whose fixed coordinates differ by more than this share of the flank are two.
const SAME_TRACE: f64 = 1e-3;

/// Distance of helix traces and profiles of a side at their crossings: root mean square, in the
/// unit of the heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossings {
    /// Distance with the file's sign.
    pub as_given: f64,
    /// With the sign of the helix traces changed.
    pub turned: f64,
    /// Greatest less least height of all traces.
    pub range: f64,
    /// Number of crossings.
    pub count: u32,
    /// Sums of squares of the distances, as given and turned, that separate zeros of the traces
    /// leave.
    rest: [f64; 2],
    /// Number of zeros that the crossings determine.
    zeros: u32,
    /// Standard deviation of the noise of a sample.
    noise: f64,
}

/// The sign of helix traces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HelixSign {
    /// Sign of the profiles.
    AsGiven,
    /// The opposite one.
    Turned,
    /// The crossings do not determine it.
    Undetermined,
}

impl Crossings {
    /// Returns the sign of the helix traces: the one that leaves clearly less than the other one,
    /// after separate zeros are subtracted, or else as the heights are.
    pub fn helix_sign(&self) -> HelixSign {
        let freedom = self.freedom();
        if freedom > 0.0 {
            let least = fisher::upper_quantile(WRONG_SIGN, freedom, KNOWN) * self.variance();
            let [as_given, turned] = self.rest.map(|rest| rest / freedom);
            let clearly = CLEARLY * CLEARLY;
            if as_given > least && turned < clearly * as_given {
                return HelixSign::Turned;
            }
            if turned > least && as_given < clearly * turned {
                return HelixSign::AsGiven;
            }
        }
        let least = NOISE * self.range;
        if self.turned > least && self.as_given < CLEARLY * self.turned {
            HelixSign::AsGiven
        } else if self.as_given > least && self.turned < CLEARLY * self.as_given && self.count >= FEWEST {
            HelixSign::Turned
        } else {
            HelixSign::Undetermined
        }
    }

    /// True if the helix traces count the other way.
    pub fn helices_are_turned(&self) -> bool {
        self.helix_sign() == HelixSign::Turned
    }

    /// True if all traces have one zero: separate zeros explain no more of the distances than noise
    /// does (F test), after helix traces that count the other way are turned.
    pub fn share_zero(&self) -> bool {
        let (distance, rest) = match self.helices_are_turned() {
            true => (self.turned, self.rest[1]),
            false => (self.as_given, self.rest[0]),
        };
        let (count, zeros) = (f64::from(self.count), f64::from(self.zeros));
        let explained = (count * distance * distance - rest) / zeros;
        explained <= fisher::upper_quantile(FALSE_ALARM, zeros, KNOWN) * self.variance()
    }

    fn freedom(&self) -> f64 {
        f64::from(self.count.saturating_sub(self.zeros))
    }

    /// Variance of the distance of two strokes over one point.
    fn variance(&self) -> f64 {
        2.0 * self.noise * self.noise + (REPEATABLE * self.range).powi(2)
    }

    /// Crossings of several teeth together; `None` without teeth.
    pub(super) fn pooled(teeth: &[Self]) -> Option<Self> {
        let count = teeth.iter().map(|one| one.count).sum();
        let rms = |of: fn(&Self) -> f64| {
            let sum: f64 = teeth.iter().map(|one| f64::from(one.count) * of(one).powi(2)).sum();
            (sum / f64::from(count)).sqrt()
        };
        let (as_given, turned) = (rms(|one| one.as_given), rms(|one| one.turned));
        let range = teeth.iter().map(|one| one.range).fold(0.0, f64::max);
        let rest = [0, 1].map(|k| teeth.iter().map(|one| one.rest[k]).sum());
        let zeros = teeth.iter().map(|one| one.zeros).sum();
        let noise = rms(|one| one.noise);
        (count > 0).then_some(Crossings { as_given, turned, range, count, rest, zeros, noise })
    }

    /// Takes samples of traces: roll length, place along the face and height, which may be NaN.
    /// `None` where nothing crosses.
    pub(super) fn of(samples: &[(Kind, [f64; 3])]) -> Option<Self> {
        let (mut helices, mut profiles) = (Vec::new(), Vec::new());
        let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        for ((kind, _), members) in traces(samples) {
            cancel::checkpoint();
            let fixed = usize::from(kind == Kind::Profile);
            let places = || members.iter().map(|k| samples[*k].1);
            let mut trace: Vec<(f64, f64)> = places().map(|place| (place[1 - fixed], place[2])).collect();
            trace.sort_unstable_by(cancel::comparing(|a: &(f64, f64), b: &(f64, f64)| a.0.total_cmp(&b.0)));
            for (_, height) in &trace {
                (least, greatest) = (least.min(*height), greatest.max(*height));
            }
            let at = places().map(|place| place[fixed]).sum::<f64>() / members.len() as f64;
            if kind == Kind::Helix { &mut helices } else { &mut profiles }.push((at, trace));
        }
        let noise = noise(helices.iter().chain(&profiles).map(|(_, trace)| &trace[..]));
        let [mut same, mut opposite] = [const { Vec::new() }; 2];
        for (i, (along, helix)) in helices.iter().take(MOST_TRACES).enumerate() {
            cancel::checkpoint();
            for (j, (across, profile)) in profiles.iter().take(MOST_TRACES).enumerate() {
                if let (Some(a), Some(b)) = (height(helix, *across), height(profile, *along)) {
                    same.push(Distance { helix: i, profile: j, value: a - b });
                    opposite.push(Distance { helix: i, profile: j, value: -a - b });
                }
            }
        }
        let count = u32::try_from(same.len()).ok().filter(|count| *count > 0)?;
        let rms = |all: &[Distance]| (all.iter().map(|one| one.value.powi(2)).sum::<f64>() / f64::from(count)).sqrt();
        let distinct = |of: fn(&Distance) -> usize| same.iter().map(of).collect::<BTreeSet<usize>>().len();
        let traces = distinct(|one| one.helix) + distinct(|one| one.profile);
        Some(Crossings {
            as_given: rms(&same),
            turned: rms(&opposite),
            range: greatest - least,
            count,
            rest: [left_by_zeros(&same), left_by_zeros(&opposite)],
            // a zero that all have in common changes no distance
            zeros: u32::try_from(traces - 1).unwrap_or(u32::MAX),
            noise,
        })
    }
}

/// The traces of samples by their kind and number, each with the numbers of its samples. Samples
/// without a height are left out. The fixed coordinate of a trace is measured, and scatters.
pub(super) fn traces(samples: &[(Kind, [f64; 3])]) -> BTreeMap<(Kind, usize), Vec<usize>> {
    let defined: Vec<usize> = (0..samples.len()).filter(|k| !samples[*k].1[2].is_nan()).collect();
    let span = |c: usize| {
        let places = defined.iter().map(|k| samples[*k].1[c]);
        let ends = places.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
        ends[1] - ends[0]
    };
    let spans = [span(0), span(1)];
    let mut found = BTreeMap::new();
    for kind in [Kind::Profile, Kind::Helix] {
        let fixed = usize::from(kind == Kind::Profile);
        let mut own: Vec<usize> = defined.iter().copied().filter(|k| samples[*k].0 == kind).collect();
        let at = |k: usize| samples[k].1[fixed];
        own.sort_by(cancel::comparing(|a: &usize, b: &usize| at(*a).total_cmp(&at(*b))));
        let (mut number, mut last) = (0, f64::NEG_INFINITY);
        for k in own {
            number += usize::from(at(k) - last > SAME_TRACE * spans[fixed]);
            last = at(k);
            found.entry((kind, number)).or_insert_with(Vec::new).push(k);
        }
    }
    found
}

/// Standard deviation of a sample's noise, by the median distance from the line through its
/// neighbours; 0 without any.
fn noise<'a>(traces: impl Iterator<Item = &'a [(f64, f64)]>) -> f64 {
    let mut distances: Vec<f64> = Vec::new();
    for trace in traces {
        cancel::checkpoint();
        distances.extend(trace.windows(3).filter(|window| window[2].0 > window[0].0).map(|window| {
            let share = (window[1].0 - window[0].0) / (window[2].0 - window[0].0);
            let between = window[0].1 + share * (window[2].1 - window[0].1);
            (window[1].1 - between).abs() / (1.0 + share * share + (1.0 - share).powi(2)).sqrt()
        }));
    }
    distances.sort_unstable_by(cancel::comparing(f64::total_cmp));
    // half of normal errors lie within 0.6745 standard deviations
    distances.get(distances.len() / 2).map_or(0.0, |median| median / 0.6745)
}

/// Height of a helix trace above a profile where they cross.
struct Distance {
    helix: usize,
    profile: usize,
    value: f64,
}

/// The sum of squares that the best zeros of all traces leave of the distances.
fn left_by_zeros(all: &[Distance]) -> f64 {
    let count = |of: fn(&Distance) -> usize| all.iter().map(of).max().map_or(0, |last| last + 1);
    let mut helices = vec![0.0; count(|one| one.helix)];
    let mut profiles = vec![0.0; count(|one| one.profile)];
    let means = |zeros: &mut [f64], of: fn(&Distance) -> usize, rest: &dyn Fn(&Distance) -> f64| {
        let mut sums = vec![(0.0, 0_u32); zeros.len()];
        for one in all {
            let (sum, count) = &mut sums[of(one)];
            *sum += rest(one);
            *count += 1;
        }
        zeros.iter_mut().zip(sums).for_each(|(zero, (sum, count))| *zero = sum / f64::from(count.max(1)));
    };
    for _ in 0..SWEEPS {
        cancel::checkpoint();
        means(&mut helices, |one| one.helix, &|one| one.value + profiles[one.profile]);
        means(&mut profiles, |one| one.profile, &|one| helices[one.helix] - one.value);
    }
    all.iter().map(|one| (one.value - helices[one.helix] + profiles[one.profile]).powi(2)).sum()
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
        let of = |helix: Vec<_>| Crossings::of(&[helix, profile(0.0), profile(2.0)].concat());
        let given = of(helix(1.0)).expect("crossings");
        assert_eq!((given.as_given, given.turned, given.range), (1.0, 17.0_f64.sqrt(), 4.0));
        let opposite = of(helix(-1.0)).expect("crossings");
        assert_eq!((opposite.as_given, opposite.turned), (given.turned, given.as_given));
        let one = |as_given, turned, count| Crossings {
            as_given,
            turned,
            range: 10.0,
            count,
            rest: [1.0, 2.0],
            zeros: 1,
            noise: 0.0,
        };
        let turned = |as_given, turned, count| one(as_given, turned, count).helices_are_turned();
        let pooled = Crossings::pooled(&[one(4.0, 0.0, 1), one(8.0, 1.0, 3)]).expect("crossings");
        let wanted = Crossings { rest: [2.0, 4.0], zeros: 2, ..one(52.0_f64.sqrt(), 0.75_f64.sqrt(), 4) };
        assert_eq!(pooled, wanted);
        assert!(turned(5.0, 0.9, 4) && !turned(5.0, 1.1, 4) && !turned(0.9, 5.0, 4));
        assert!(!turned(5.0, 0.9, 3), "a trace with its own zero may agree by chance");
        assert!(!turned(0.02, 0.0, 9), "traces that are zeroed where they cross differ there by rounding alone");
        assert_eq!(Crossings::of(&helix(1.0)), None);
        let undefined = sampled(Kind::Helix, [[1.0, 2.0, f64::NAN], [1.0, 0.0, f64::NAN]]);
        assert_eq!(of(undefined), None);
        let outside = sampled(Kind::Helix, [[3.0, 0.0, 1.0], [3.0, 2.0, 1.0]]);
        assert_eq!(of(outside), None);
    }

    /// Five helices and four profiles over a plane, with noise (a fixed sequence) and zeros.
    fn plane(noise: f64, zero: f64) -> Crossings {
        let mut state = 1.0_f64;
        let mut next = || {
            state = (state * 7919.0 + 0.37) % 1.0;
            noise * (state - 0.5)
        };
        let height = |u: f64, v: f64| 3.0 * u - 2.0 * v;
        let mut samples = Vec::new();
        for k in 0..5 {
            let u = 0.5 + f64::from(k);
            let own = zero * [1.0, -1.5, 0.5, 2.0, -1.0][k as usize];
            samples.extend((0..=4).map(f64::from).map(|v| (Kind::Helix, [u, v, height(u, v) + own + next()])));
        }
        for v in 0..4 {
            let v = f64::from(v);
            samples
                .extend((0..=10).map(|k| 0.5 * f64::from(k)).map(|u| (Kind::Profile, [u, v, height(u, v) + next()])));
        }
        Crossings::of(&samples).expect("crossings")
    }

    #[test]
    fn shared_zeros_are_distinguished_from_noise() {
        assert!(plane(0.0, 0.0).share_zero() && plane(1.0, 0.0).share_zero() && plane(5.0, 0.0).share_zero());
        assert!(!plane(0.0, 0.5).share_zero() && !plane(1.0, 1.5).share_zero());
        // the zeros are all that differs
        assert!(plane(0.0, 2.0).rest[0] < 1e-18);
        assert_eq!((plane(0.0, 2.0).count, plane(0.0, 2.0).zeros), (20, 8));
        let cross = |apart: f64| {
            let profile = [0.0, 1.0, 2.0].map(|u| (Kind::Profile, [u, 1.0, 10.0 * u]));
            let helix = [0.0, 1.0, 2.0].map(|v| (Kind::Helix, [1.0, v, 10.0 + apart]));
            Crossings::of(&[profile, helix].concat()).expect("crossings")
        };
        // 0.3 µm of the range of 20 µm, times the root of F(1, 100) at 0.01
        assert!(cross(0.7).share_zero() && !cross(0.9).share_zero());
    }
    /// Two profiles and two helices whose twist alone shows the sign, since each is zeroed at its
    /// own middle.
    #[test]
    fn signs_are_determined_behind_zeros() {
        let sign = |twist: f64, turn: f64| {
            let places = [-1.0, -0.5, 0.0, 0.5, 1.0];
            let height = |u: f64, v: f64| 3.0 * u - 2.0 * v + twist * u * v;
            let profile = |v: f64| places.map(|u| (Kind::Profile, [u, v, height(u, v) - height(0.0, v)]));
            let helix = |u: f64| places.map(|v| (Kind::Helix, [u, v, turn * (height(u, v) - height(u, 0.0))]));
            let samples = [profile(-0.5), profile(0.5), helix(-0.5), helix(0.5)].concat();
            let found = Crossings::of(&samples).expect("crossings");
            assert!(!found.share_zero());
            found.helix_sign()
        };
        assert_eq!([sign(4.0, 1.0), sign(4.0, -1.0)], [HelixSign::AsGiven, HelixSign::Turned]);
        assert_eq!([sign(0.0, 1.0), sign(0.0, -1.0)], [HelixSign::Undetermined; 2]);
    }

    #[test]
    fn fixed_coordinates_scatter() {
        let samples: Vec<(Kind, [f64; 3])> = (0..8)
            .map(f64::from)
            .flat_map(|k| {
                let jitter = 1e-4 * (3.0 * k).sin();
                [
                    (Kind::Profile, [k, 1.0 + jitter, 0.0]),
                    (Kind::Profile, [k, 5.0 - jitter, f64::NAN]),
                    (Kind::Helix, [2.0 + jitter, k, 0.0]),
                ]
            })
            .collect();
        let found = traces(&samples);
        assert_eq!(found.values().map(Vec::len).collect::<Vec<_>>(), [8, 8]);
    }
}
