//! Traces of a flank on the wire.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::faults::Faults;
use flankfit_engine::{
    gear::{
        Gear, Kind, Side, Trace,
        tooth::{Position, check_name},
    },
    words::{Shown, entries},
};

/// Deviations along a profile or along the helix.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = GearTrace)]
pub struct TraceBody {
    /// Number of the tooth from 1, followed by a letter for traces off the middle: `1k` and `1f`
    /// are helices near the tip and near the root, `1u` and `1o` profiles at the lower and at the
    /// upper end. These count for the twist, not in the means. Leading zeros are refused.
    pub tooth: String,
    pub flank: Side,
    pub kind: Kind,
    /// For a profile: positions of its samples as diameters …
    pub diameter_mm: Option<Vec<f64>>,
    /// … or as roll lengths.
    pub roll_length_mm: Option<Vec<f64>>,
    /// For a helix: z of its samples.
    pub z_mm: Option<Vec<f64>>,
    /// `null` where undefined. The sign is `deviation_sign` of the evaluation. By default (`din`)
    /// profiles are positive where material protrudes, helices where the flank is turned
    /// counterclockwise: material on left and space on right flanks. Material-positive helices of
    /// right flanks need `"deviation_sign": "material"`.
    pub deviation_um: Vec<Option<f64>>,
    /// True for samples that count. By default all that are defined.
    pub valid: Option<Vec<bool>>,
    /// The design line of a modified flank at the samples, in the sign of the deviations. It is
    /// subtracted from them.
    pub design_um: Option<Vec<f64>>,
    /// For a profile: its z.
    pub section_z_mm: Option<f64>,
    /// For a helix: its diameter.
    pub section_diameter_mm: Option<f64>,
}

impl From<&Trace> for TraceBody {
    /// With positions as roll lengths or z, undefined samples as `null`.
    fn from(trace: &Trace) -> Self {
        let at = Some(trace.at.clone());
        let (roll_length_mm, z_mm, section_z_mm, section_diameter_mm) = match trace.kind {
            Kind::Profile => (at, None, trace.section, None),
            Kind::Helix => (None, at, None, trace.section),
        };
        TraceBody {
            tooth: trace.tooth.clone(),
            flank: trace.side,
            kind: trace.kind,
            diameter_mm: None,
            roll_length_mm,
            z_mm,
            deviation_um: trace.deviation.iter().map(|d| Some(*d).filter(|d| !d.is_nan())).collect(),
            valid: None,
            design_um: None,
            section_z_mm,
            section_diameter_mm,
        }
    }
}

impl TraceBody {
    /// Returns the trace; pointers of errors begin with `at`.
    pub fn read(&self, gear: &Gear, at: &str, faults: &mut Faults) -> Option<Trace> {
        let before = faults.count();
        let kind = self.kind;
        let (section, stranger) = match kind {
            Kind::Profile => (self.section_z_mm, self.section_diameter_mm.map(|_| "section_diameter_mm")),
            Kind::Helix => (self.section_diameter_mm, self.section_z_mm.map(|_| "section_z_mm")),
        };
        if let Some(name) = stranger {
            let kind = if kind == Kind::Profile { "profile" } else { "helix" };
            faults.push(format!("{at}/{name}"), format!("a {kind} has none"));
        }
        let teeth = gear.data().teeth;
        if let Err(fault) = check_name(&self.tooth) {
            faults.push(format!("{at}/tooth"), fault.to_string());
        } else if Position::number(&self.tooth).is_some_and(|number| !(1..=u64::from(teeth)).contains(&number)) {
            let shown: String = self.tooth.chars().take(20).collect();
            let detail = format!("`{shown}` is not within 1 and {teeth}, the number of teeth");
            faults.push(format!("{at}/tooth"), detail);
        }
        let positions = self.positions(kind, gear, at, faults);
        if let Some(valid) = self.valid.as_ref().filter(|valid| valid.len() != self.deviation_um.len()) {
            let detail = format!("{} for {} deviations", entries(valid.len()), self.deviation_um.len());
            faults.push(format!("{at}/valid"), detail);
        }
        let counts = |k: usize| self.valid.as_ref().is_none_or(|valid| valid.get(k).is_some_and(|valid| *valid));
        let each = self.deviation_um.iter().enumerate();
        let deviation = each.map(|(k, d)| d.filter(|_| counts(k)).unwrap_or(f64::NAN)).collect();
        let at = positions.filter(|_| faults.count() == before)?;
        Some(Trace { tooth: self.tooth.clone(), side: self.flank, kind, at, section, deviation })
    }

    /// Roll lengths of a profile, z of a helix.
    fn positions(&self, kind: Kind, gear: &Gear, at: &str, faults: &mut Faults) -> Option<Vec<f64>> {
        match (kind, &self.diameter_mm, &self.roll_length_mm, &self.z_mm) {
            (Kind::Profile, None, Some(lengths), None) => Some(lengths.clone()),
            (Kind::Helix, None, None, Some(z)) => Some(z.clone()),
            (Kind::Profile, Some(diameters), None, None) => {
                let mut lengths = Vec::with_capacity(diameters.len());
                for (k, &diameter) in diameters.iter().enumerate() {
                    match gear.roll_length(diameter) {
                        Some(length) => lengths.push(length),
                        None => faults.push(
                            format!("{at}/diameter_mm/{k}"),
                            format!(
                                "{} mm lies below the base circle of {} mm, where there is no involute",
                                Shown(diameter),
                                Shown(2.0 * gear.base_radius())
                            ),
                        ),
                    }
                }
                Some(lengths)
            }
            (Kind::Profile, ..) => {
                faults.push(at, "a profile has its samples at either `diameter_mm` or `roll_length_mm`");
                None
            }
            (Kind::Helix, ..) => {
                faults.push(at, "a helix has its samples at `z_mm`");
                None
            }
        }
    }
}
