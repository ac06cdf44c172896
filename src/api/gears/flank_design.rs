//! Designed deviations of the flanks of a job from the involute.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::design::modification::{self, ModificationBody};
use crate::api::faults::Faults;
use flankfit_engine::gear::{
    Gear, Modifications, Side, correction::flank::Design, evaluation::flank_surface::FlankFigures, modification::Range,
};

/// Designed deviations of the flanks from the involute, in µm: figures with the signs of measured
/// ones and along the `direction` of the requirements, and further modifications along the normal.
/// All of them refer to one range. `{}` is the unmodified flank. Corrections use it as target.
#[skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = FlankDesign)]
pub struct DesignBody {
    #[serde(flatten)]
    #[schema(inline)]
    figures: FlankFigures,
    /// Figures of left flanks, which replace those for both.
    left: Option<FlankFigures>,
    /// Figures of right flanks, likewise.
    right: Option<FlankFigures>,
    /// Diameters between which slope, crowning and twist are defined. By default those of the
    /// measured nodes; they are scaled to a measurement of another range.
    #[schema(min_items = 2, max_items = 2)]
    pub profile_diameter_range_mm: Option<[f64; 2]>,
    /// Range in z of the helix figures, `[from, to]`. By default that of the measured nodes.
    #[schema(min_items = 2, max_items = 2)]
    pub helix_range_mm: Option<[f64; 2]>,
    /// Modifications as in `POST /v1/gears/flank`, superposed: tip and root relief, end relief and
    /// others.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(required = false, max_items = 100)]
    modifications: Vec<ModificationBody>,
}

/// Greatest magnitude of a figure, µm.
const MOST_UM: f64 = 1000.0;

impl DesignBody {
    /// True if a range that its figures refer to is left open.
    pub fn lacks_range(&self) -> bool {
        let figures = |side| self.of(side).named().iter().any(|(_, figure)| figure.is_some());
        let open = self.profile_diameter_range_mm.is_none() || self.helix_range_mm.is_none();
        open && (figures(Side::Left) || figures(Side::Right))
    }

    /// Returns the figures for a flank.
    fn of(&self, side: Side) -> FlankFigures {
        let own = match side {
            Side::Left => self.left,
            Side::Right => self.right,
        };
        own.unwrap_or_default().or(self.figures)
    }

    /// Returns the design for a flank of a gear; `at` is its place in the request.
    pub fn on(&self, gear: &Gear, side: Side, at: &str) -> Result<Design, Faults> {
        let mut faults = Faults::default();
        let profile = self.profile_diameter_range_mm.and_then(|diameters| {
            match diameters.map(|diameter| gear.roll_length(diameter)) {
                [Some(from), Some(to)] => Some([from, to]),
                _ => {
                    let detail = format!(
                        "the gear has no involute there: its base circle has {:.3} mm",
                        2.0 * gear.base_radius()
                    );
                    faults.push(format!("{at}/profile_diameter_range_mm"), detail);
                    None
                }
            }
        });
        let modifications = modification::laws(gear, &self.modifications, at, &mut faults);
        faults.into_result(Design { figures: self.of(side), modifications, profile, helix: self.helix_range_mm })
    }

    /// Refuses a design that is impossible for any flank or, if there is a gear, for that gear.
    pub fn check(&self, gear: Option<&Gear>, at: &str, faults: &mut Faults) {
        let before = faults.count();
        for (place, figures) in [("", Some(self.figures)), ("/left", self.left), ("/right", self.right)] {
            for (name, figure) in figures.unwrap_or_default().named() {
                if let Some(figure) = figure.filter(|figure| figure.abs() > MOST_UM) {
                    let detail = format!("{figure} µm exceeds the {MOST_UM} µm allowed for a design");
                    faults.push(format!("{at}{place}/{name}_um"), detail);
                }
            }
        }
        let ranges =
            [("profile_diameter_range_mm", self.profile_diameter_range_mm), ("helix_range_mm", self.helix_range_mm)];
        for (name, range) in ranges {
            if range.is_some_and(|[from, to]| from == to) {
                faults.push(format!("{at}/{name}"), "the range has no length: give two different ends");
            }
        }
        let Some(gear) = gear.filter(|_| faults.count() == before) else { return };
        match self.on(gear, Side::Left, at) {
            Err(found) => faults.append(found),
            // the measured nodes may span less than the whole flank, but not more
            Ok(design) => {
                let whole = Range::whole(gear);
                let profile = design.profile.or(whole.map(|range| range.profile()));
                let helix = design.helix.or(whole.map(|range| range.helix()));
                let (Some(profile), Some(helix)) = (profile, helix) else { return };
                match Range::of_roll_lengths(gear, profile, helix) {
                    Err(found) => faults.append(Faults::of_engine(at, &found)),
                    Ok(range) => {
                        if let Err(found) = Modifications::new(gear, range, design.modifications) {
                            faults.append(Faults::of_engine(&format!("{at}/modifications"), &found));
                        }
                    }
                }
            }
        }
    }
}
