//! Bands that traces must lie in: the upper and the lower line of a K-chart.
//!
//! Lines are drawn through points (place, deviation) and straight between them, deviations of
//! material in µm, transverse, about the unmodified flank or the design line. Measuring machines
//! zero each trace by itself, so a trace `δ` lies in the band if some shift of the whole trace
//! takes it there: `lower(x) ≤ δ(x) + s ≤ upper(x)` at every sample `x`, that is `max(lower − δ) ≤
//! s ≤ min(upper − δ)`. What is left between the two is the room of the trace, below 0 where it
//! has none. A line says nothing outside its ends. It is straight over the coordinate that its
//! points are given in: over diameters it is bent over roll lengths.

use super::{
    against::Against,
    spacing::{HOLE_DISTANCES, LONGEST_DISTANCE},
};
use crate::{Gear, Kind, ProfileAxis, Side};

/// A band.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// Kind of the traces.
    pub kind: Kind,
    /// Flank of the traces; `None` for both.
    pub side: Option<Side>,
    /// Line that its deviations are about.
    pub against: Against,
    /// Coordinate of places of profiles; those of helices are z.
    pub axis: ProfileAxis,
    /// Places (mm, of roll angles rad), ascending, and µm of material.
    pub upper: Vec<[f64; 2]>,
    /// The same of the lower line.
    pub lower: Vec<[f64; 2]>,
}

/// Position of a trace in a band.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = KBandFinding)
)]
pub struct BandPosition {
    /// Number of the band in `evaluation`, from 0.
    pub band: usize,
    /// True if some shift of the whole trace takes all its samples into the band; absent if one
    /// would, but more than 1/20 of the band in one stretch is without samples.
    pub within: Option<bool>,
    /// Distance that the trace can be shifted within the band; below 0 the height by which it is
    /// too high for it.
    pub clearance_um: f64,
    /// Shift that takes the trace to the middle of the band, positive towards where material
    /// protrudes.
    pub shift_um: f64,
    /// Roll lengths, or z of helices, where the trace is nearest to the upper and to the lower
    /// line.
    pub nearest_mm: [f64; 2],
}

impl Band {
    /// Returns the position of samples (roll length or z, µm), in any order, in this band, which
    /// has the number `band`.
    pub(super) fn found(
        &self,
        band: usize,
        gear: &Gear,
        samples: impl Iterator<Item = [f64; 2]>,
    ) -> Option<BandPosition> {
        let (mut most, mut least) = ([f64::INFINITY, f64::NAN], [f64::NEG_INFINITY, f64::NAN]);
        let mut places = Vec::new();
        for [at, deviation] in samples {
            let place = self.place(gear, at);
            let (upper, lower) = (height(&self.upper, place), height(&self.lower, place));
            if let Some(room) = upper.map(|upper| upper - deviation).filter(|room| *room < most[0]) {
                most = [room, at];
            }
            if let Some(room) = lower.map(|lower| lower - deviation).filter(|room| *room > least[0]) {
                least = [room, at];
            }
            if upper.is_some() || lower.is_some() {
                places.push(place);
            }
        }
        let room = most[0] - least[0];
        if !room.is_finite() {
            return None;
        }
        Some(BandPosition {
            band,
            clearance_um: room,
            shift_um: 0.5 * (most[0] + least[0]) + 0.0,
            nearest_mm: [most[1], least[1]],
            within: if room < 0.0 { Some(false) } else { self.is_covered(places).then_some(true) },
        })
    }

    /// Returns the place of a sample in the coordinate of the lines.
    fn place(&self, gear: &Gear, at: f64) -> f64 {
        match self.kind {
            Kind::Profile => self.axis.value(gear, at),
            Kind::Helix => at,
        }
    }

    /// Whether the samples reach the ends of the band and leave no hole, as it is with evaluation
    /// ranges.
    fn is_covered(&self, mut places: Vec<f64>) -> bool {
        let ends = [&self.upper, &self.lower].into_iter().flat_map(|line| line.first().into_iter().chain(line.last()));
        let [low, high] =
            ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], point| [low.min(point[0]), high.max(point[0])]);
        places.sort_by(f64::total_cmp);
        let mut gaps: Vec<f64> = places.windows(2).map(|pair| pair[1] - pair[0]).collect();
        gaps.sort_by(f64::total_cmp);
        let (longest, usual) = (LONGEST_DISTANCE * (high - low), gaps.get(gaps.len() / 2).copied().unwrap_or(0.0));
        let reached = places.first().is_some_and(|first| first - low <= longest)
            && places.last().is_some_and(|last| high - last <= longest);
        reached && gaps.last().is_none_or(|gap| *gap <= longest.max(HOLE_DISTANCES * usual))
    }
}

/// The height of a line; `None` outside its ends.
fn height(line: &[[f64; 2]], at: f64) -> Option<f64> {
    let behind = line.partition_point(|point| point[0] <= at);
    match (behind.checked_sub(1).map(|k| line[k]), line.get(behind)) {
        (Some([x, y]), Some([next_x, next_y])) => Some(y + (next_y - y) * ((at - x) / (next_x - x))),
        // the last point itself
        (Some([x, y]), None) => (x == at).then_some(y),
        (None, _) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::GearData;

    fn gear() -> Gear {
        Gear::new(GearData::spur(52, 1.0)).unwrap()
    }

    fn band() -> Band {
        Band {
            kind: Kind::Profile,
            side: None,
            against: Against::Involute,
            axis: ProfileAxis::RollLength,
            upper: vec![[0.0, 4.0], [8.0, 4.0], [10.0, 0.0]],
            lower: vec![[0.0, -2.0], [10.0, -8.0]],
        }
    }

    #[test]
    fn lines_are_straight_between_their_points_and_end_there() {
        let upper = band().upper;
        let heights = [-0.1, 0.0, 8.0, 9.0, 10.0, 10.1].map(|at| height(&upper, at));
        assert_eq!(heights, [None, Some(4.0), Some(4.0), Some(2.0), Some(0.0), None]);
    }

    #[test]
    fn a_trace_is_shifted_to_the_middle_of_its_clearance() {
        // the shift that a brute search finds, in steps of 0.01 µm
        let trace: Vec<[f64; 2]> = (0..=100).map(|k| 0.1 * f64::from(k)).map(|x| [x, 20.0 - 0.1 * x * x]).collect();
        let found = band().found(0, &gear(), trace.iter().copied()).unwrap();
        let fits = |shift: f64| {
            trace.iter().all(|[x, y]| {
                let (upper, lower) = (height(&band().upper, *x).unwrap(), height(&band().lower, *x).unwrap());
                (lower..=upper).contains(&(y + shift))
            })
        };
        let shifts: Vec<f64> = (-4000..0).map(|k| 0.01 * f64::from(k)).filter(|shift| fits(*shift)).collect();
        let (first, last) = (shifts[0], shifts[shifts.len() - 1]);
        assert!(
            (found.clearance_um - (last - first)).abs() < 0.03 && (found.shift_um - 0.5 * (first + last)).abs() < 0.03
        );
        assert_eq!(found.within, Some(true));
    }

    #[test]
    fn what_no_shift_takes_there_is_outside_and_what_is_not_measured_undecidable() {
        let steep: Vec<[f64; 2]> = (0..=100).map(|k| 0.1 * f64::from(k)).map(|x| [x, 2.0 * x]).collect();
        let found = band().found(0, &gear(), steep.iter().copied()).unwrap();
        // at x = 10 the upper line is at 0, at x = 0 the lower one at −2: 20 µm rise have 2 µm
        assert!((found.clearance_um - (0.0 - 20.0 + 2.0)).abs() < 1e-12 && found.within == Some(false));
        assert_eq!(found.nearest_mm, [10.0, 0.0]);
        let flat = |to: usize| (0..=to).map(|k| [0.1 * k as f64, -1.0]);
        assert_eq!(band().found(0, &gear(), flat(100)).unwrap().within, Some(true));
        assert_eq!(band().found(0, &gear(), flat(90)).unwrap().within, None);
        assert_eq!(band().found(0, &gear(), std::iter::once([11.0, 0.0])), None);
    }
}
