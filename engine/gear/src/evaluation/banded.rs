//! A trace's samples against the bands that are its.

use super::{
    band::{Band, BandPosition},
    settings::Outliers,
    subject::Subject,
    values::Suspects,
};
use flankfit_numerics::cancel::Asking;

/// Returns the positions in the bands of the trace that a sample lies in.
pub(super) fn all(subject: &Subject, suspects: Option<&Suspects>) -> Vec<BandPosition> {
    let bands = subject.settings.bands.iter().enumerate();
    bands.filter_map(|(k, band)| hold(k, band, subject, suspects)).collect()
}

fn hold(number: usize, band: &Band, subject: &Subject, suspects: Option<&Suspects>) -> Option<BandPosition> {
    let trace = subject.trace;
    if band.kind != trace.kind || band.side.is_some_and(|side| side != trace.side) {
        return None;
    }
    let scale = subject.to_material();
    let excluded = suspects.filter(|_| subject.settings.outliers == Outliers::Exclude);
    let left_out = |at: f64| {
        excluded.is_some_and(|all| all.places.iter().any(|place| (place.from_mm..=place.to_mm).contains(&at)))
    };
    let about = band.against.line(subject.design);
    let samples = trace.at.iter().zip(&trace.deviation).enumerate().asking(20);
    let samples = samples.map(|(i, (at, given))| [*at, scale * (given - about.map_or(0.0, |line| line[i]))]);
    band.found(number, subject.gear, samples.filter(|[at, deviation]| !deviation.is_nan() && !left_out(*at)))
}
