//! What is said of samples that stand out of their neighbours ([`super::outliers`]).

use super::{
    outliers::{Run, outliers},
    samples::{Sample, Taken},
    subject::{FEWEST_SAMPLES, Subject, Values},
};
use crate::fault::words::Shown;

/// A place that stands out of its neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Suspect {
    /// Roll lengths or z of its first and last sample, mm.
    pub from: f64,
    /// Roll length or z of its last sample, mm.
    pub to: f64,
    /// Samples in it.
    pub samples: usize,
    /// How far it stands out at most, µm of material.
    pub height: f64,
}

/// Places that stand out of their neighbours, within what is looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Suspects {
    /// In ascending order.
    pub places: Vec<Suspect>,
    /// The figures without them, where they count and the samples that are left tell them.
    pub without: Option<Values>,
}

/// Marks what stands out of its neighbours; the places of it that count otherwise.
pub(super) fn mark(all: &mut [Sample]) -> Vec<Run> {
    let column = |of: fn(&Sample) -> f64| all.iter().map(of).collect::<Vec<f64>>();
    let mut runs = outliers(&column(|s| s.at), &column(|s| s.deviation));
    runs.retain(|run| all[run.from..run.to].iter().any(|s| s.within || s.zone));
    for run in &runs {
        all[run.from..run.to].iter_mut().for_each(|sample| sample.suspect = true);
    }
    runs
}

/// The marked places, with the figures without them where they are not `excluded` anyway.
pub(super) fn suspects(subject: &Subject, all: &[Sample], runs: &[Run], excluded: bool) -> Suspects {
    let place = |run: &Run| Suspect {
        from: all[run.from].at,
        to: all[run.to - 1].at,
        samples: run.to - run.from,
        height: run.height,
    };
    let places = runs.iter().map(place).collect();
    let without = (!excluded).then(|| Taken::of(all, true));
    let told =
        |taken: &Taken| taken.u.len() >= FEWEST_SAMPLES && taken.spacing.places > 2 && taken.spacing.tells_figures();
    Suspects { places, without: without.filter(told).map(|taken| subject.figures(&taken)) }
}

/// The notice of them.
pub(super) fn suspicion(suspects: &Suspects, excluded: bool) -> String {
    const NAMED: usize = 5;
    // to a µm along and to a tenth of a µm across
    let along = |x: f64| Shown((x * 1e3).round() / 1e3);
    let across = |x: f64| Shown((x * 10.0).round() / 10.0);
    let one = |p: &Suspect| match p.samples {
        1 => format!("at {} mm ({} µm)", along(p.from), across(p.height)),
        _ => format!("from {} to {} mm ({} µm)", along(p.from), along(p.to), across(p.height)),
    };
    let mut places = suspects.places.iter().take(NAMED).map(one).collect::<Vec<_>>().join(", ");
    if suspects.places.len() > NAMED {
        places.push_str(" and others");
    }
    let found = format!("samples stand far out of their neighbours, as dust does: {places}");
    match (excluded, suspects.without) {
        (true, _) => format!("{found}; they are left out"),
        (false, Some(w)) => format!(
            "{found}; they count. Without them slope {}, form {}, total {} µm",
            across(w.slope),
            across(w.form),
            across(w.total)
        ),
        (false, None) => format!("{found}; they count"),
    }
}
