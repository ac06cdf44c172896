//! Limits of figures, and whether figures conform to them, on the wire.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::api::faults::Faults;
pub use flankfit_engine::estimation::inference::Decision as DecisionName;
use flankfit_engine::{
    estimation::inference::Conformity,
    gear::{
        Side,
        evaluation::{SidedLimits, ToleranceLimits, no_class, not_ascending_limits},
    },
};

/// Declares limits of figures, with more members before them.
macro_rules! limits {
    ($(#[$doc:meta])* $name:ident { $($(#[$more_doc:meta])* $more:ident: $of:ty,)* }) => {
        #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
        #[serde(deny_unknown_fields)]
        $(#[$doc])*
        pub struct $name {
            $($(#[$more_doc])* #[serde(default, skip_serializing_if = "Option::is_none")] pub $more: Option<$of>,)*
            /// Of f_Hα over the reference length (of surfaces: the evaluation range).
            #[serde(default, skip_serializing_if = "Option::is_none")]
            #[schema(min_items = 2, max_items = 2)]
            pub profile_slope_um: Option<[f64; 2]>,
            /// Of f_Hβ over the reference length (of surfaces: the face width).
            #[serde(default, skip_serializing_if = "Option::is_none")]
            #[schema(min_items = 2, max_items = 2)]
            pub helix_slope_um: Option<[f64; 2]>,
            /// Of C_α.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            #[schema(min_items = 2, max_items = 2)]
            pub profile_crowning_um: Option<[f64; 2]>,
            /// Of C_β.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            #[schema(min_items = 2, max_items = 2)]
            pub helix_crowning_um: Option<[f64; 2]>,
            /// Of the twist of surfaces.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            #[schema(min_items = 2, max_items = 2)]
            pub twist_um: Option<[f64; 2]>,
            /// Of f_fα of traces.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            #[schema(min_items = 2, max_items = 2)]
            pub profile_form_um: Option<[f64; 2]>,
            /// Of f_fβ of traces.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            #[schema(min_items = 2, max_items = 2)]
            pub helix_form_um: Option<[f64; 2]>,
            /// Of F_α of traces.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            #[schema(min_items = 2, max_items = 2)]
            pub profile_total_um: Option<[f64; 2]>,
            /// Of F_β of traces.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            #[schema(min_items = 2, max_items = 2)]
            pub helix_total_um: Option<[f64; 2]>,
        }

        impl From<$name> for ToleranceLimits {
            /// Without a class.
            fn from(limits: $name) -> Self {
                ToleranceLimits {
                    class: None,
                    profile_slope: limits.profile_slope_um,
                    helix_slope: limits.helix_slope_um,
                    profile_crowning: limits.profile_crowning_um,
                    helix_crowning: limits.helix_crowning_um,
                    twist: limits.twist_um,
                    profile_form: limits.profile_form_um,
                    helix_form: limits.helix_form_um,
                    profile_total: limits.profile_total_um,
                    helix_total: limits.helix_total_um,
                }
            }
        }

        impl $name {
            /// Leaves out limits of slopes, crownings and twist, which are of the flank and not of
            /// its distance from the design.
            fn without_shapes(self) -> Self {
                $name {
                    profile_slope_um: None,
                    helix_slope_um: None,
                    profile_crowning_um: None,
                    helix_crowning_um: None,
                    twist_um: None,
                    ..self
                }
            }

            /// Refuses limits that do not ascend.
            fn check_order(&self, at: &str, faults: &mut Faults) {
                let told = [
                    ("profile_slope_um", self.profile_slope_um),
                    ("helix_slope_um", self.helix_slope_um),
                    ("profile_crowning_um", self.profile_crowning_um),
                    ("helix_crowning_um", self.helix_crowning_um),
                    ("twist_um", self.twist_um),
                    ("profile_form_um", self.profile_form_um),
                    ("helix_form_um", self.helix_form_um),
                    ("profile_total_um", self.profile_total_um),
                    ("helix_total_um", self.helix_total_um),
                ];
                check_ascending(&told, at, faults);
            }

            /// Refuses limits that only traces have figures for.
            fn refuse_of_traces(&self, at: &str, faults: &mut Faults) {
                for (name, limits) in [
                    ("profile_form_um", self.profile_form_um),
                    ("helix_form_um", self.helix_form_um),
                    ("profile_total_um", self.profile_total_um),
                    ("helix_total_um", self.helix_total_um),
                ] {
                    if limits.is_some() {
                        let detail = "form and total deviations are of traces, and nothing here is held against \
                            their limits; leave it out, or evaluate traces";
                        faults.push(format!("{at}/{name}"), detail);
                    }
                }
            }
        }
    };
}

limits! {
    /// What figures must lie within, `[low, high]` in µm, in the sign and the direction in which
    /// they are answered. Each figure that has limits is answered with whether it lies within, and
    /// with its conformity where it has an interval.
    #[schema(as = ToleranceLimits)]
    ToleranceLimitsBody {
        /// Class 1 to 11 of ISO 1328-1:2013: its tolerances bound the slopes, and of traces the
        /// forms and totals, that no limits are given for here (the standard has none of crownings
        /// and twist).
        #[schema(minimum = 1, maximum = 11)]
        class: u8,
        /// Of left flanks: each limit here goes before the one for both.
        left: FlankLimitsBody,
        /// Of right flanks, likewise.
        right: FlankLimitsBody,
    }
}

limits! {
    /// What figures of one flank must lie within, `[low, high]` in µm and in the sign in which they
    /// are answered.
    #[schema(as = FlankLimits)]
    FlankLimitsBody {}
}

impl ToleranceLimitsBody {
    /// Those of a flank.
    pub fn of(&self, side: Side) -> ToleranceLimits {
        let own: ToleranceLimits = match side {
            Side::Left => self.left,
            Side::Right => self.right,
        }
        .unwrap_or_default()
        .into();
        let both = ToleranceLimits::from(*self);
        ToleranceLimits {
            class: self.class,
            profile_slope: own.profile_slope.or(both.profile_slope),
            helix_slope: own.helix_slope.or(both.helix_slope),
            profile_crowning: own.profile_crowning.or(both.profile_crowning),
            helix_crowning: own.helix_crowning.or(both.helix_crowning),
            twist: own.twist.or(both.twist),
            profile_form: own.profile_form.or(both.profile_form),
            helix_form: own.helix_form.or(both.helix_form),
            profile_total: own.profile_total.or(both.profile_total),
            helix_total: own.helix_total.or(both.helix_total),
        }
    }

    /// Returns the limits of figures about the design.
    pub fn about_design(self) -> Self {
        let of = |own: Option<FlankLimitsBody>| own.map(FlankLimitsBody::without_shapes);
        ToleranceLimitsBody { left: of(self.left), right: of(self.right), ..self.without_shapes() }
    }

    pub fn sided(&self) -> SidedLimits {
        SidedLimits { left: self.of(Side::Left), right: self.of(Side::Right) }
    }

    /// Refuses what no gear could mend.
    pub fn check(&self, at: &str, faults: &mut Faults) {
        check_class(self.class, at, faults);
        self.check_order(at, faults);
        for (name, own) in [("left", self.left), ("right", self.right)] {
            if let Some(own) = own {
                own.check_order(&format!("{at}/{name}"), faults);
            }
        }
    }
}

impl ToleranceLimitsBody {
    /// Refuses limits that only traces have figures for.
    pub fn check_for_surface(&self, at: &str, faults: &mut Faults) {
        self.refuse_of_traces(at, faults);
        for (name, own) in [("left", self.left), ("right", self.right)] {
            if let Some(own) = own {
                own.refuse_of_traces(&format!("{at}/{name}"), faults);
            }
        }
    }
}

/// Refuses a class that there is not.
pub fn check_class(class: Option<u8>, at: &str, faults: &mut Faults) {
    if let Some(message) = class.and_then(no_class) {
        faults.push(format!("{at}/class"), message);
    }
}

/// Refuses limits that do not ascend.
pub fn check_ascending(told: &[(&str, Option<[f64; 2]>)], at: &str, faults: &mut Faults) {
    for (name, limits) in told {
        if let Some(message) = limits.and_then(not_ascending_limits) {
            faults.push(format!("{at}/{name}"), message);
        }
    }
}

/// A figure against its limits, by its standard error (ISO 14253-1): the limits are drawn in by a
/// guard band, so that a part at a limit is found to conform in about one measurement of twenty,
/// and one that lies within not to in one of twenty at most, where errors are as the fit takes them
/// (docs/explanation/intervals.md). It counts noise only: what is the same all over a flank
/// (alignment, temperature, calibration) is in no residual.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Conformity)]
pub struct ConformityBody {
    /// The limits that were compared with, µm.
    #[schema(min_items = 2, max_items = 2)]
    pub limits_um: [f64; 2],
    /// Least and greatest probability that the true figure lies within the limits, by Student's
    /// distribution about the estimate; they differ where the estimate may be biased.
    #[schema(min_items = 2, max_items = 2)]
    pub probability: [f64; 2],
    pub decision: DecisionName,
}

impl From<Conformity> for ConformityBody {
    fn from(found: Conformity) -> Self {
        ConformityBody { limits_um: found.limits, probability: found.probability, decision: found.decision }
    }
}
