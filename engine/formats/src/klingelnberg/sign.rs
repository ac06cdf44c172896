//! The sign of stored deviations.
//!
//! Stored deviations count along the direction in which the probe is pressed, which is the same way
//! round the gear on both flanks: material standing out is **positive on right flanks and negative
//! on left ones**, for profiles and leads alike. On a measured spur gear the tip's rounding and the
//! last samples before the probe leaves the flank show it on both flanks and in both directions.
//!
//! What DIN calls a positive f_Hβ is a helix that turns to the right, on either flank: material
//! growing upwards on left flanks, shrinking on right ones. Code 165 prints just that as `L: + : R:
//! -`. With the two together, leads are stored with the opposite of DIN's sign on both flanks, and
//! profiles on left ones only; on all 17 traces of that gear the slopes then have the sign that the
//! instrument printed.

use super::{Rules, Sides};
use flankfit_gear::{Kind, Side};

/// Meaning of a positive deviation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SignConvention {
    /// Excess of material on the nominal flank, as everywhere in [`flankfit_gear`].
    Material,
    /// Slopes get the sign of DIN: profiles as [`SignConvention::Material`], leads positive where a
    /// positive slope turns the helix to the right.
    Din,
}

/// Factors from stored deviations to either convention, for the settings of a file.
///
/// The factors are known for a file with code 164 = 0 (flank names by DIN), 165 = 1 with `L: + : R:
/// -`, and 178 = 1 (sign of leads by DIN). For other settings the same factors are used as an
/// assumption, and [`Signs::is_known`] is false: 178 = 0 (VDI) should concern leads only, but no
/// such file has been seen. Profiles depend on neither 165 nor 178.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signs {
    helix_known: bool,
    profile_known: bool,
}

impl Signs {
    /// From the rules of a header.
    pub fn of(rules: &Rules) -> Self {
        let names = rules.flank_names.is_none_or(|names| names == 0);
        let signs = Sides { left: Some(true), right: Some(false) };
        let reference = rules.helix_slope_reference == Some(1) && rules.helix_slope_signs == signs;
        Signs { helix_known: names && reference && rules.helix_sign == Some(1), profile_known: names }
    }

    /// +1 or −1, by which a stored deviation is multiplied.
    pub fn factor(self, sense: SignConvention, kind: Kind, side: Side) -> f64 {
        match (sense, kind) {
            (SignConvention::Din, Kind::Helix) => -1.0,
            (SignConvention::Material, _) | (SignConvention::Din, Kind::Profile) => -side.sign(),
        }
    }

    /// True if the factors are known for the settings of the file; otherwise they are assumed.
    pub fn is_known(self, kind: Kind) -> bool {
        match kind {
            Kind::Profile => self.profile_known,
            Kind::Helix => self.helix_known,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_senses_differ_on_right_leads_only() {
        let signs = Signs::of(&Rules::default());
        assert!(!signs.is_known(Kind::Helix) && signs.is_known(Kind::Profile));
        for (kind, side, material, din) in [
            (Kind::Profile, Side::Left, -1.0, -1.0),
            (Kind::Profile, Side::Right, 1.0, 1.0),
            (Kind::Helix, Side::Left, -1.0, -1.0),
            (Kind::Helix, Side::Right, 1.0, -1.0),
        ] {
            let factors = [SignConvention::Material, SignConvention::Din].map(|sense| signs.factor(sense, kind, side));
            assert_eq!(factors, [material, din]);
        }
    }
}
