//! Meaning of the five digits of a result's code.
//!
//! The first three name the characteristic and where on the flank it was measured; the fourth is
//! odd for left and even for right: 1, 2 single teeth, 3, 4 mean, 5, 6 variation, 7, 8 maximum, 9,
//! 0 minimum; the last counts the measured teeth. Characteristics of the whole gear have the same
//! fourth digits without a flank.

use flankfit_gear::Side;

/// Quantity of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Characteristic {
    /// f_Hβ.
    HelixSlope,
    /// F_β.
    HelixTotal,
    /// f_fβ.
    HelixForm,
    /// f_Hα.
    ProfileSlope,
    /// F_α.
    ProfileTotal,
    /// f_fα.
    ProfileForm,
    /// Root diameter d_f.
    RootDiameter,
    /// Tip diameter d_a.
    TipDiameter,
    /// f_p.
    SinglePitch,
    /// f_u, the difference of adjacent pitches.
    PitchStep,
    /// R_p, the greatest single pitch minus the least.
    PitchRange,
    /// F_p.
    CumulativePitch,
    /// F_pz/8, cumulative pitch over an eighth of the teeth.
    SectorPitch,
    /// F_r.
    Runout,
    /// R_s, variation of the tooth thickness.
    ToothThicknessVariation,
    /// M_d, dimension over or between two balls.
    DimensionOverBalls,
    /// W_k, span measurement over k teeth.
    Span,
}

impl Characteristic {
    /// The symbol of ISO 1328-1 or the instrument's own.
    pub fn symbol(self) -> &'static str {
        match self {
            Characteristic::HelixSlope => "f_Hbeta",
            Characteristic::HelixTotal => "F_beta",
            Characteristic::HelixForm => "f_fbeta",
            Characteristic::ProfileSlope => "f_Halpha",
            Characteristic::ProfileTotal => "F_alpha",
            Characteristic::ProfileForm => "f_falpha",
            Characteristic::RootDiameter => "d_f",
            Characteristic::TipDiameter => "d_a",
            Characteristic::SinglePitch => "f_p",
            Characteristic::PitchStep => "f_u",
            Characteristic::PitchRange => "R_p",
            Characteristic::CumulativePitch => "F_p",
            Characteristic::SectorPitch => "F_pz/8",
            Characteristic::Runout => "F_r",
            Characteristic::ToothThicknessVariation => "R_s",
            Characteristic::DimensionOverBalls => "M_dK",
            Characteristic::Span => "W_k",
        }
    }
}

/// Place on the flank of a measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = FilePosition)
)]
pub enum MeasuringPosition {
    /// In the middle of the flank.
    Middle,
    /// Leads on the inner circle (`f`), profiles low on the face width (`u`).
    First,
    /// Leads on the outer circle (`k`), profiles high on the face width (`o`).
    Second,
}

/// Teeth of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = FileStatistic)
)]
pub enum Statistic {
    /// One measured tooth.
    Tooth,
    /// Mean of the measured teeth.
    Mean,
    /// Variation over the measured teeth: greatest minus least.
    Variation,
    /// Greatest of the measured teeth.
    Max,
    /// Least of the measured teeth.
    Min,
    /// A value of the gear as a whole.
    Gear,
    /// The code has no known meaning.
    Unknown,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Meaning {
    pub characteristic: Characteristic,
    pub place: MeasuringPosition,
    pub statistic: Statistic,
    pub side: Option<Side>,
}

/// Characteristics that are measured flank by flank, at up to three places.
const OF_FLANKS: [(u32, Characteristic); 6] = [
    (101, Characteristic::HelixSlope),
    (104, Characteristic::HelixTotal),
    (107, Characteristic::HelixForm),
    (201, Characteristic::ProfileSlope),
    (204, Characteristic::ProfileTotal),
    (207, Characteristic::ProfileForm),
];

const OF_TEETH: [(u32, Characteristic); 2] = [(264, Characteristic::RootDiameter), (267, Characteristic::TipDiameter)];

/// Results of the whole gear; with a flank each where `true`.
const OF_GEAR: [(u32, Characteristic, bool, Statistic); 13] = [
    (301, Characteristic::SinglePitch, true, Statistic::Max),
    (304, Characteristic::PitchStep, true, Statistic::Max),
    (307, Characteristic::PitchRange, true, Statistic::Gear),
    (310, Characteristic::CumulativePitch, true, Statistic::Gear),
    (313, Characteristic::SectorPitch, true, Statistic::Gear),
    (316, Characteristic::Runout, false, Statistic::Gear),
    (319, Characteristic::ToothThicknessVariation, false, Statistic::Gear),
    (328, Characteristic::DimensionOverBalls, false, Statistic::Mean),
    (331, Characteristic::DimensionOverBalls, false, Statistic::Min),
    (334, Characteristic::DimensionOverBalls, false, Statistic::Max),
    (346, Characteristic::Span, false, Statistic::Mean),
    (349, Characteristic::Span, false, Statistic::Min),
    (352, Characteristic::Span, false, Statistic::Max),
];

/// The meaning of a code, as far as it is known.
pub(super) fn code_of(code: u32) -> Option<Meaning> {
    if !(10_000..100_000).contains(&code) {
        return None;
    }
    let (group, which) = (code / 100, code / 10 % 10);
    let side = if which % 2 == 1 { Side::Left } else { Side::Right };
    let statistic = match which {
        1 | 2 => Statistic::Tooth,
        3 | 4 => Statistic::Mean,
        5 | 6 => Statistic::Variation,
        7 | 8 => Statistic::Max,
        _ => Statistic::Min,
    };
    let at = |first: u32| {
        (first..first + 3).contains(&group).then(|| match group - first {
            0 => MeasuringPosition::Middle,
            1 => MeasuringPosition::First,
            _ => MeasuringPosition::Second,
        })
    };
    if let Some((characteristic, place)) = OF_FLANKS.iter().find_map(|(first, name)| Some((*name, at(*first)?))) {
        return Some(Meaning { characteristic, place, statistic, side: Some(side) });
    }
    if let Some((characteristic, place)) = OF_TEETH.iter().find_map(|(first, name)| Some((*name, at(*first)?))) {
        return Some(Meaning { characteristic, place, statistic, side: None });
    }
    let (_, characteristic, sided, statistic) = OF_GEAR.iter().find(|(first, ..)| *first == group)?;
    let side = sided.then_some(side);
    Some(Meaning { characteristic: *characteristic, place: MeasuringPosition::Middle, statistic: *statistic, side })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn result_codes_are_decoded() {
        let is = |code: u32| code_of(code).map(|m| (m.characteristic.symbol(), m.place, m.statistic, m.side));
        assert_eq!(is(10113), Some(("f_Hbeta", MeasuringPosition::Middle, Statistic::Tooth, Some(Side::Left))));
        assert_eq!(is(10100), Some(("f_Hbeta", MeasuringPosition::Middle, Statistic::Min, Some(Side::Right))));
        assert_eq!(is(10321), Some(("f_Hbeta", MeasuringPosition::Second, Statistic::Tooth, Some(Side::Right))));
        assert_eq!(is(10460), Some(("F_beta", MeasuringPosition::Middle, Statistic::Variation, Some(Side::Right))));
        assert_eq!(is(20811), Some(("f_falpha", MeasuringPosition::First, Statistic::Tooth, Some(Side::Left))));
        assert_eq!(is(26450), Some(("d_f", MeasuringPosition::Middle, Statistic::Variation, None)));
        assert_eq!(is(26911), Some(("d_a", MeasuringPosition::Second, Statistic::Tooth, None)));
        assert_eq!(is(31020), Some(("F_p", MeasuringPosition::Middle, Statistic::Gear, Some(Side::Right))));
        assert_eq!(is(33410), Some(("M_dK", MeasuringPosition::Middle, Statistic::Max, None)));
        assert_eq!([is(21611), is(7), is(999_999)], [None, None, None]);
    }
}
