//! The sign of stored deviations.

use super::{Rules, Sides};
use crate::gear::{Kind, Side};

/// What turns stored deviations into the sign in which the instrument prints its slopes by DIN.
///
/// Known from a measured spur gear (a file with flank names by DIN, code 164 = 0; reference of f_Hβ 1 with `L: + : R: -`, code 165; sign of
/// leads 1, code 178), on all of whose 17 traces the printed f_Hα and f_Hβ come back: −1 for every lead and for profiles of left flanks, +1 for
/// profiles of right flanks. On profiles that sign is + for material standing out: the tip's rounding is negative on both flanks.
///
/// With other settings the same factors are used, and [`DinSign::is_known`] is false: code 178 = 0 (VDI) should concern leads only,
/// but no such file has been seen. Profiles do not depend on codes 165 and 178.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DinSign {
    helix_known: bool,
    profile_known: bool,
}

impl DinSign {
    /// From the rules of a header.
    pub fn of(rules: &Rules) -> Self {
        let names = rules.flank_names.is_none_or(|names| names == 0);
        let signs = Sides { left: Some(true), right: Some(false) };
        let reference = rules.helix_slope_reference == Some(1) && rules.helix_slope_signs == signs;
        DinSign { helix_known: names && reference && rules.helix_sign == Some(1), profile_known: names }
    }

    /// +1 or −1, by which a stored deviation is multiplied.
    pub fn factor(self, kind: Kind, side: Side) -> f64 {
        match (kind, side) {
            (Kind::Profile, Side::Right) => 1.0,
            (Kind::Profile, Side::Left) | (Kind::Helix, _) => -1.0,
        }
    }

    /// Whether the factor is known for the settings of the file, or else assumed.
    pub fn is_known(self, kind: Kind) -> bool {
        match kind {
            Kind::Profile => self.profile_known,
            Kind::Helix => self.helix_known,
        }
    }
}
