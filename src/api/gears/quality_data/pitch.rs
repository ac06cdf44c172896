//! Pitches and run-out as characteristics.

use super::list::{List, flank};
use crate::api::gears::evaluation::pitch::{PitchEvaluationBody, RunoutBody};
use flankfit_engine::{
    formats::qdas::Characteristic,
    gear::{evaluation::pitch::Extreme, tolerance},
};

/// Returns f_p, F_p, F_pk, F_pSk, R_p and f_u of both flanks, and R_s, F_r and f_e of the gear.
pub fn characteristics(found: &PitchEvaluationBody) -> Vec<Characteristic> {
    let mut list = List::default();
    for pitch in [&found.left, &found.right].into_iter().flatten() {
        let (letter, side) = flank(pitch.flank);
        let single = tolerance::Characteristic::SinglePitch.symbol();
        let cumulative = tolerance::Characteristic::CumulativePitch.symbol();
        let value = |found: Option<Extreme>| found.map(|found| found.value_um);
        for (symbol, words, value, limits) in [
            (single, "single pitch deviation", value(pitch.single_pitch), pitch.single_pitch_limits_um),
            (
                cumulative,
                "total cumulative pitch deviation",
                pitch.cumulative_pitch_um,
                pitch.cumulative_pitch_limits_um,
            ),
            ("F_pk", "sector pitch deviation of ISO 1328-1:2013", value(pitch.sector_pitch_2013), None),
            ("F_pSk", "sum of a sector of ISO 1328-1:2013", value(pitch.sector_sum_2013), None),
            ("F_pk_1995", "sector pitch deviation of ISO 1328-1:1995", value(pitch.sector_pitch_1995), None),
            ("R_p", "range of single pitch deviations", pitch.single_pitch_range_um, None),
            ("f_u", "difference of neighbouring pitches", value(pitch.adjacent_pitch_difference), None),
        ] {
            list.push(&format!("{letter}-{symbol}"), format!("{symbol}, {words}, {side}"), value, ends(limits));
        }
    }
    if let Some(variation) = found.tooth_thickness_variation_um {
        list.push("R_s", "R_s, variation of tooth thickness".to_owned(), Some(variation), [None; 2]);
    }
    if let Some(RunoutBody { result: runout, .. }) = &found.runout {
        let symbol = tolerance::Characteristic::Runout.symbol();
        list.push(
            symbol,
            format!("{symbol}, run-out"),
            Some(runout.runout_um),
            ends(runout.held.map(|held| held.limits_um)),
        );
        let eccentricity = runout.eccentricity.map(|found| found.amount_um);
        list.push("f_e", "f_e, eccentricity".to_owned(), eccentricity, [None; 2]);
    }
    list.into_vec()
}

fn ends(limits: Option<[f64; 2]>) -> [Option<f64>; 2] {
    limits.map_or([None; 2], |limits| limits.map(Some))
}
