//! Bands of K-charts on the wire.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{contract::Pair, faults::Faults};
use flankfit_engine::gear::{
    Gear, Kind, ProfileAxis, Side,
    evaluation::{Against, band::Band},
    trace::MOST_DEVIATION,
};

/// Most points of all lines of a request or of a job: they stand in every answer.
pub const MOST_POINTS_IN_ALL: usize = 4000;

/// A band that traces must lie in, as in a K-chart: an upper and a lower polyline through points
/// `[place, µm]`. Deviations are from the unmodified flank or the design, transverse, and positive
/// where material protrudes. Each trace may be shifted as a whole, since measuring machines zero
/// each by itself.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = KBand, example = json!({"kind": "profile", "profile_axis": "diameter",
    "upper": [[50.4, 2], [53.5, 2], [54.0, -4]], "lower": [[50.4, -8], [53.0, -4], [54.0, -14]]}))]
pub struct KBandBody {
    /// Kind of the traces.
    pub kind: Kind,
    /// Flank of the traces; both by default.
    pub flank: Option<Side>,
    /// Reference of the deviations. Default `involute`.
    pub against: Option<Against>,
    /// Coordinate of places of profiles. Default `roll_length`. Places of helices are z in mm.
    pub profile_axis: Option<ProfileAxis>,
    /// At least two points, places ascending. Samples outside its ends are not limited.
    #[schema(value_type = Vec<Pair>, min_items = 2, max_items = 1000)]
    pub upper: Vec<[f64; 2]>,
    /// Likewise; nowhere above the upper line.
    #[schema(value_type = Vec<Pair>, min_items = 2, max_items = 1000)]
    pub lower: Vec<[f64; 2]>,
}

/// Refuses bands that are none on any gear.
pub fn check_all(bands: &[KBandBody], at: &str, faults: &mut Faults) {
    let points: usize = bands.iter().map(|band| band.upper.len() + band.lower.len()).sum();
    if points > MOST_POINTS_IN_ALL {
        faults.push(at, format!("{points} points in all; at most {MOST_POINTS_IN_ALL} are allowed"));
        return;
    }
    for (k, band) in bands.iter().enumerate() {
        band.check(&format!("{at}/{k}"), faults);
    }
}

/// The bands on a gear.
pub fn on_all(bands: &[KBandBody], gear: &Gear, at: &str) -> Result<Vec<Band>, Faults> {
    let mut faults = Faults::default();
    let each = bands.iter().enumerate();
    let on =
        |(k, band): (usize, &KBandBody)| band.on(gear, &format!("{at}/{k}")).map_err(|more| faults.append(more)).ok();
    let bands = each.filter_map(on).collect();
    faults.into_result(bands)
}

impl KBandBody {
    /// True if its deviations are about the design.
    pub fn is_about_design(&self) -> bool {
        self.against == Some(Against::Design)
    }

    fn check(&self, at: &str, faults: &mut Faults) {
        if self.kind == Kind::Helix && self.profile_axis.is_some() {
            faults.push(format!("{at}/profile_axis"), "places of helices are z in mm; omit it");
        }
        let before = faults.count();
        for (name, line) in [("upper", &self.upper), ("lower", &self.lower)] {
            check_line(line, &format!("{at}/{name}"), faults);
        }
        if faults.count() == before
            && let Some(place) = self.crossing()
        {
            faults.push(format!("{at}/lower"), format!("it is above the upper line at {place}"));
        }
    }

    /// Returns a place where the lower line is above the upper one; a difference of lines is
    /// greatest at a point.
    fn crossing(&self) -> Option<f64> {
        let points = self.upper.iter().chain(&self.lower).map(|point| point[0]);
        let above = |at: f64| Some(height(&self.lower, at)? > height(&self.upper, at)?);
        points.into_iter().find(|at| above(*at) == Some(true))
    }

    /// Returns the band on a gear; places without an involute are errors.
    pub fn on(&self, gear: &Gear, at: &str) -> Result<Band, Faults> {
        let axis = self.profile_axis.unwrap_or_default();
        let mut faults = Faults::default();
        let mut line = |of: &str, points: &[[f64; 2]]| -> Vec<[f64; 2]> {
            let point = |(k, [x, y]): (usize, &[f64; 2])| match self.kind {
                Kind::Helix => [*x, *y],
                Kind::Profile => {
                    if axis.roll_length(gear, axis.requested(*x)).is_none() {
                        let why = format!("there is no involute at {x}, which is a {}", axis.name().replace('_', " "));
                        faults.push(format!("{at}/{of}/{k}/0"), why);
                    }
                    [axis.requested(*x), *y]
                }
            };
            points.iter().enumerate().map(point).collect()
        };
        let (upper, lower) = (line("upper", &self.upper), line("lower", &self.lower));
        let against = self.against.map_or(Against::Involute, Into::into);
        let (kind, side) = (self.kind, self.flank);
        let band = Band { kind, side, against, axis, upper, lower };
        faults.into_result(band)
    }
}

fn check_line(line: &[[f64; 2]], at: &str, faults: &mut Faults) {
    for (k, pair) in line.windows(2).enumerate() {
        if pair[0][0] >= pair[1][0] {
            faults.push(format!("{at}/{}/0", k + 1), format!("{} does not ascend after {}", pair[1][0], pair[0][0]));
        }
    }
    for (k, point) in line.iter().enumerate() {
        for (c, value) in point.iter().enumerate().filter(|(_, value)| value.abs() > MOST_DEVIATION) {
            faults.push(format!("{at}/{k}/{c}"), format!("{value} exceeds {MOST_DEVIATION}"));
        }
    }
}

/// Returns the height of a line; `None` outside its ends.
fn height(line: &[[f64; 2]], at: f64) -> Option<f64> {
    line.windows(2).find(|pair| (pair[0][0]..=pair[1][0]).contains(&at)).map(|pair| {
        let [[x, y], [next_x, next_y]] = [pair[0], pair[1]];
        y + (next_y - y) * ((at - x) / (next_x - x))
    })
}
