//! Designed deviations of the flanks of a job from the involute.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::design::modification::{self, ModificationBody};
use crate::api::faults::Faults;
use flankfit_engine::gear::{
    Gear, Modifications, Side,
    correction::flank::Design,
    evaluation::flank_surface::FlankFigures,
    modification::{MOST, Range},
};

/// Declares figures of a design, followed by further members.
macro_rules! design {
    ($(#[$doc:meta])* $name:ident { $($(#[$more_doc:meta])* $more:ident: $of:ty,)* }) => {
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
        #[serde(deny_unknown_fields)]
        $(#[$doc])*
        pub struct $name {
            /// f_Hα: positive where material grows from root to tip. Default 0, as of each figure.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub profile_slope_um: Option<f64>,
            /// f_Hβ, by DIN: positive towards the right hand.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub helix_slope_um: Option<f64>,
            /// C_α: positive where material stands out half-way between root and tip.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub profile_crowning_um: Option<f64>,
            /// C_β: positive where material stands out half-way between the ends.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub helix_crowning_um: Option<f64>,
            /// S, with the sign of f_Hβ: how much more the profile slope is at the end of great z
            /// than at that of small z.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub twist_um: Option<f64>,
            $($(#[$more_doc])* pub $more: $of,)*
        }

        impl $name {
            fn figures(&self) -> FlankFigures {
                FlankFigures {
                    profile_slope: self.profile_slope_um,
                    helix_slope: self.helix_slope_um,
                    profile_crowning: self.profile_crowning_um,
                    helix_crowning: self.helix_crowning_um,
                    twist: self.twist_um,
                }
            }

            /// Refuses figures that no flank can have.
            fn check_figures(&self, at: &str, faults: &mut Faults) {
                for (name, figure) in self.figures().named() {
                    if let Some(figure) = figure.filter(|figure| figure.abs() > MOST_UM) {
                        let detail = format!("{figure} µm is more than a design has: {MOST_UM} µm at most");
                        faults.push(format!("{at}/{name}_um"), detail);
                    }
                }
            }
        }
    };
}

design! {
    /// How the flanks are meant to deviate from the involute, in µm: figures in the signs in which
    /// they are measured and along the `direction` of the requirements, and further modifications
    /// along the normal. All of them refer to one range. `{}` is the unmodified flank. Corrections
    /// aim at it.
    #[schema(as = FlankDesign)]
    DesignBody {
        /// Of left flanks: each figure here goes before the one for both.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        left: Option<SideDesignBody>,
        /// Of right flanks, likewise.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        right: Option<SideDesignBody>,
        /// Diameters between which slope, crowning and twist are meant. By default those of the
        /// measured nodes; a measurement of another range has its share of them by the curvature.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schema(min_items = 2, max_items = 2)]
        profile_diameter_range_mm: Option<[f64; 2]>,
        /// z between which they are meant, `[from, to]`. By default that of the measured nodes.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schema(min_items = 2, max_items = 2)]
        helix_range_mm: Option<[f64; 2]>,
        /// Superposed, as `POST /v1/gears/flank` takes them: tip and root relief, end relief and
        /// others.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        #[schema(required = false, max_items = 100)]
        modifications: Vec<ModificationBody>,
    }
}

design! {
    /// How one flank is meant to deviate from the involute, in µm along the `direction` of the
    /// requirements.
    #[schema(as = SideDesign)]
    SideDesignBody {}
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
            Side::Left => &self.left,
            Side::Right => &self.right,
        };
        let own = own.as_ref().map(SideDesignBody::figures).unwrap_or_default();
        let both = self.figures();
        FlankFigures {
            profile_slope: own.profile_slope.or(both.profile_slope),
            helix_slope: own.helix_slope.or(both.helix_slope),
            profile_crowning: own.profile_crowning.or(both.profile_crowning),
            helix_crowning: own.helix_crowning.or(both.helix_crowning),
            twist: own.twist.or(both.twist),
        }
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
        self.check_figures(at, faults);
        for (name, own) in [("left", &self.left), ("right", &self.right)] {
            if let Some(own) = own {
                own.check_figures(&format!("{at}/{name}"), faults);
            }
        }
        let ranges =
            [("profile_diameter_range_mm", self.profile_diameter_range_mm), ("helix_range_mm", self.helix_range_mm)];
        for (name, range) in ranges {
            if range.is_some_and(|[from, to]| from == to) {
                faults.push(format!("{at}/{name}"), "the range has no length: give two different ends");
            }
        }
        if self.modifications.len() > MOST {
            faults.push(format!("{at}/modifications"), format!("at most {MOST} modifications"));
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
