//! Modifications of flanks on the wire.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::places::ProfileBody;
use crate::api::faults::Faults;
use flankfit_engine::gear::{
    Gear, Modifications,
    modification::{End, Flanks, Growth, Interpolation, Law, Modification, Range, Topography},
};

/// Modification of the involute flank. Amounts are µm along the normal, positive where material is
/// removed. They refer to the range given with them, over which u runs from root to tip and v from
/// the lower to the higher end, both from −1 to 1.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields, expecting = "an object")]
#[schema(as = FlankModification)]
pub enum ModificationBody {
    /// C_α u².
    ProfileCrowning {
        /// Greatest amount of removed material; negative values add material.
        amount_um: f64,
        flank: Option<Flanks>,
    },
    /// C_Hα u/2.
    ProfileSlope {
        /// Greatest amount of removed material; negative values add material.
        amount_um: f64,
        flank: Option<Flanks>,
    },
    /// From 0 at its start to C_αa at the tip end of the range.
    TipRelief {
        /// Greatest amount of removed material; negative values add material.
        amount_um: f64,
        /// Diameter where it begins; it does not change the flank from there to the root.
        start_diameter_mm: f64,
        form: Option<Growth>,
        flank: Option<Flanks>,
    },
    /// From 0 at its start to C_αf at the root end of the range.
    RootRelief {
        /// Greatest amount of removed material; negative values add material.
        amount_um: f64,
        /// Diameter where it begins; it does not change the flank from there to the tip.
        start_diameter_mm: f64,
        form: Option<Growth>,
        flank: Option<Flanks>,
    },
    /// C_β v².
    HelixCrowning {
        /// Greatest amount of removed material; negative values add material.
        amount_um: f64,
        flank: Option<Flanks>,
    },
    /// C_Hβ v/2.
    HelixSlope {
        /// Greatest amount of removed material; negative values add material.
        amount_um: f64,
        flank: Option<Flanks>,
    },
    /// C_βI or C_βII: from 0 at `length_mm` inside an end of the range to the amount there.
    EndRelief {
        /// Greatest amount of removed material; negative values add material.
        amount_um: f64,
        /// Distance from the end where it begins, along the axis.
        length_mm: f64,
        end: End,
        form: Option<Growth>,
        flank: Option<Flanks>,
    },
    /// S u v/4.
    Twist {
        /// Greatest amount of removed material; negative values add material.
        amount_um: f64,
        flank: Option<Flanks>,
    },
    /// Values on a grid, constant outside its border.
    Grid {
        profile: ProfileBody,
        /// z of the columns, ascending.
        face_width_positions_mm: Vec<f64>,
        /// A row for each profile value.
        relief_um: Vec<Vec<f64>>,
        interpolation: Option<Interpolation>,
        flank: Option<Flanks>,
    },
}

/// Range that the amounts of modifications refer to. By default the usable profile, and the face
/// width from z = 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = ModificationRange)]
pub struct ModificationRangeBody {
    /// From the root end to the tip end, as diameters. By default the usable profile.
    #[schema(min_items = 2, max_items = 2)]
    pub profile_diameter_range_mm: [f64; 2],
    /// `[from, to]` along the axis. By default the face width.
    #[schema(min_items = 2, max_items = 2)]
    pub helix_range_mm: [f64; 2],
}

/// The modifications at `/modifications` over the range at `/modification_range`; none where the
/// list is empty.
pub fn read(
    gear: &Gear,
    list: &[ModificationBody],
    range: Option<ModificationRangeBody>,
) -> Result<Option<Modifications>, Faults> {
    if list.is_empty() {
        return Ok(None);
    }
    let mut faults = Faults::default();
    let range = match range {
        Some(body) => Range::new(gear, body.profile_diameter_range_mm, body.helix_range_mm)
            .map_err(|more| faults.append(Faults::of_engine("/modification_range", &more)))
            .ok(),
        None => Range::whole(gear).or_else(|| {
            faults.push_missing("/modification_range", "missing: the gear has no face width, or no involute");
            None
        }),
    };
    let laws = laws(gear, list, "", &mut faults);
    let Some(range) = faults.into_result(range)? else { return Ok(None) };
    Modifications::new(gear, range, laws).map(Some).map_err(|more| Faults::of_engine("/modifications", &more))
}

/// Reads the modifications of the list at `{at}/modifications`.
pub fn laws(gear: &Gear, list: &[ModificationBody], at: &str, faults: &mut Faults) -> Vec<Modification> {
    let law = |(i, body): (usize, &ModificationBody)| body.law(gear, &format!("{at}/modifications/{i}"), faults);
    list.iter().enumerate().filter_map(law).collect()
}

impl ModificationBody {
    /// Returns the law of the modification at `at`.
    fn law(&self, gear: &Gear, at: &str, faults: &mut Faults) -> Option<Modification> {
        let (flank, law) = match *self {
            ModificationBody::ProfileCrowning { amount_um: amount, flank } => (flank, Law::ProfileCrowning { amount }),
            ModificationBody::ProfileSlope { amount_um: amount, flank } => (flank, Law::ProfileSlope { amount }),
            ModificationBody::TipRelief { amount_um: amount, start_diameter_mm: start_diameter, form, flank } => {
                (flank, Law::TipRelief { amount, start_diameter, growth: form.unwrap_or_default() })
            }
            ModificationBody::RootRelief { amount_um: amount, start_diameter_mm: start_diameter, form, flank } => {
                (flank, Law::RootRelief { amount, start_diameter, growth: form.unwrap_or_default() })
            }
            ModificationBody::HelixCrowning { amount_um: amount, flank } => (flank, Law::HelixCrowning { amount }),
            ModificationBody::HelixSlope { amount_um: amount, flank } => (flank, Law::HelixSlope { amount }),
            ModificationBody::EndRelief { amount_um: amount, length_mm: length, end, form, flank } => {
                (flank, Law::EndRelief { end, amount, length, growth: form.unwrap_or_default() })
            }
            ModificationBody::Twist { amount_um: amount, flank } => (flank, Law::Twist { amount }),
            ModificationBody::Grid {
                ref profile,
                ref face_width_positions_mm,
                ref relief_um,
                interpolation,
                flank,
            } => {
                let rolls = profile.roll_lengths(gear, &format!("{at}/profile/values"));
                let made = rolls.and_then(|rolls| {
                    let interpolation = interpolation.unwrap_or_default();
                    Topography::new(&rolls, face_width_positions_mm, relief_um, interpolation)
                        .map_err(|more| Faults::of_engine(at, &more))
                });
                (flank, Law::Topography(made.map_err(|more| faults.append(more)).ok()?))
            }
        };
        Some(Modification { flanks: flank.unwrap_or_default(), law })
    }
}
