//! Warnings about samples that deviate from their neighbours ([`super::outliers`]).

use super::{
    outliers::{
        Run,
        burrs::{self, Burr, Ends, FEWEST_TRACES},
        outliers,
    },
    samples::{self, Sample, Taken},
    spacing::LEAST_COVERED,
    subject::Subject,
    values::{FEWEST_SAMPLES, Suspect, Suspects},
    warning::TraceWarning,
};
use crate::{Kind, Side};

/// The burrs of each trace, lower end first: its ends are compared with those of the other traces
/// of the same flank and kind.
pub(super) fn burrs(subjects: &[Subject]) -> Vec<[Option<Burr>; 2]> {
    let mut found = vec![[None; 2]; subjects.len()];
    for kind in [Kind::Profile, Kind::Helix] {
        for side in [Side::Left, Side::Right] {
            let is_of = |i: &usize| subjects[*i].trace.kind == kind && subjects[*i].trace.side == side;
            let flank: Vec<usize> = (0..subjects.len()).filter(is_of).collect();
            if flank.len() < FEWEST_TRACES {
                continue;
            }
            let ends: Vec<Ends> = flank.iter().map(|&i| burrs::ends(&samples::defined(&subjects[i]).0)).collect();
            for (i, burrs) in flank.into_iter().zip(burrs::burrs(&ends)) {
                found[i] = burrs;
            }
        }
    }
    found
}

/// Marks the burrs and the outliers; returns the places of those that count otherwise.
pub(super) fn mark(all: &mut [Sample], burrs: [Option<Burr>; 2]) -> Vec<Run> {
    let column = |of: fn(&Sample) -> f64| all.iter().map(of).collect::<Vec<f64>>();
    let mut runs = outliers(&column(|s| s.at), &column(|s| s.deviation));
    for burr in burrs::runs(all, burrs) {
        let meets = |run: &Run| run.from < burr.to && burr.from < run.to;
        let whole = runs.iter().filter(|run| meets(run)).fold(burr, |whole, run| Run {
            from: whole.from.min(run.from),
            to: whole.to.max(run.to),
            ..whole
        });
        runs.retain(|run| !meets(run));
        runs.push(whole);
    }
    runs.sort_by_key(|run| run.from);
    runs.retain(|run| all[run.from..run.to].iter().any(|s| s.within || s.zone));
    for run in &runs {
        all[run.from..run.to].iter_mut().for_each(|sample| sample.suspect = true);
    }
    runs
}

/// The marked places, with the figures without them where they are not `excluded` anyway.
pub(super) fn suspects(subject: &Subject, all: &[Sample], runs: &[Run], excluded: bool) -> Suspects {
    let place = |run: &Run| Suspect {
        from_mm: all[run.from].at,
        to_mm: all[run.to - 1].at,
        samples: run.to - run.from,
        height_um: run.height,
        burr: run.burr,
    };
    let places = runs.iter().map(place).collect();
    let without = (!excluded).then(|| Taken::of(all, true));
    let is_determined = |taken: &Taken| {
        taken.u.len() >= FEWEST_SAMPLES && taken.spacing.places > 2 && taken.spacing.covered >= LEAST_COVERED
    };
    Suspects {
        places,
        without: without.filter(is_determined).map(|taken| subject.figures(&taken, taken.noise()).into()),
    }
}

impl Suspects {
    /// Returns the warning about them.
    pub(super) fn warning(&self, excluded: bool) -> TraceWarning {
        let places = self.places.iter().take(TraceWarning::NAMED).copied().collect();
        let more = self.places.len() > TraceWarning::NAMED;
        TraceWarning::OutliersSuspected { places, more, excluded, without: self.without }
    }
}
