//! Pitches and run-out as characteristics.

use super::list::{List, flank};
use crate::api::gears::evaluation::pitch::PitchEvaluationBody;
use flankfit_engine::{formats::qdas::Characteristic, gear::tolerance};

/// Of both flanks f_p, F_p, F_pk and f_u, and of the gear F_r and f_e.
pub fn characteristics(found: &PitchEvaluationBody) -> Vec<Characteristic> {
    let mut list = List::default();
    for pitch in [&found.left, &found.right].into_iter().flatten() {
        let (letter, side) = flank(pitch.flank);
        let single = tolerance::Characteristic::SinglePitch.symbol();
        let cumulative = tolerance::Characteristic::CumulativePitch.symbol();
        for (symbol, words, value) in [
            (single, "single pitch deviation", pitch.single_pitch.map(|found| found.value_um)),
            (cumulative, "total cumulative pitch deviation", pitch.cumulative_pitch_um),
            ("F_pk", "cumulative pitch deviation of a sector", pitch.sector_pitch.map(|found| found.value_um)),
            ("f_u", "difference of neighbouring pitches", pitch.adjacent_pitch_difference.map(|found| found.value_um)),
        ] {
            list.push(&format!("{letter}-{symbol}"), format!("{symbol}, {words}, {side}"), value, [None; 2]);
        }
    }
    if let Some(runout) = &found.runout {
        let symbol = tolerance::Characteristic::Runout.symbol();
        list.push(symbol, format!("{symbol}, run-out"), Some(runout.runout_um), [None; 2]);
        let eccentricity = runout.eccentricity.map(|found| found.amount_um);
        list.push("f_e", "f_e, eccentricity".to_owned(), eccentricity, [None; 2]);
    }
    list.into_vec()
}
