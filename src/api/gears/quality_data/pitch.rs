//! Pitches and run-out as characteristics.

use super::list::{List, flank};
use crate::api::gears::evaluation::pitch::{ExtremeBody, PitchEvaluationBody};
use flankfit_engine::{formats::qdas::Characteristic, gear::tolerance};

/// Of both flanks f_p, F_p, F_pk and f_u, and of the gear F_r and f_e.
pub fn characteristics(found: &PitchEvaluationBody) -> Vec<Characteristic> {
    let mut list = List::default();
    for pitch in [&found.left, &found.right].into_iter().flatten() {
        let (letter, side) = flank(pitch.flank);
        let single = tolerance::Characteristic::SinglePitch.symbol();
        let cumulative = tolerance::Characteristic::CumulativePitch.symbol();
        let value = |found: Option<ExtremeBody>| found.map(|found| found.value_um);
        for (symbol, words, value, limits) in [
            (single, "single pitch deviation", value(pitch.single_pitch), pitch.single_pitch_limits_um),
            (
                cumulative,
                "total cumulative pitch deviation",
                pitch.cumulative_pitch_um,
                pitch.cumulative_pitch_limits_um,
            ),
            ("F_pk", "cumulative pitch deviation of a sector", value(pitch.sector_pitch), None),
            ("f_u", "difference of neighbouring pitches", value(pitch.adjacent_pitch_difference), None),
        ] {
            list.push(&format!("{letter}-{symbol}"), format!("{symbol}, {words}, {side}"), value, ends(limits));
        }
    }
    if let Some(runout) = &found.runout {
        let symbol = tolerance::Characteristic::Runout.symbol();
        list.push(symbol, format!("{symbol}, run-out"), Some(runout.runout_um), ends(runout.limits_um));
        let eccentricity = runout.eccentricity.map(|found| found.amount_um);
        list.push("f_e", "f_e, eccentricity".to_owned(), eccentricity, [None; 2]);
    }
    list.into_vec()
}

fn ends(limits: Option<[f64; 2]>) -> [Option<f64>; 2] {
    limits.map_or([None; 2], |limits| limits.map(Some))
}
