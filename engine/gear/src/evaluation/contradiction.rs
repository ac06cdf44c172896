//! Whether the traces of a flank contradict their second-order surface.
//!
//! Whatever the flank is, each trace has a parabola of its own. What the surface leaves in addition
//! to those parabolas says that slopes and curvatures of the traces (and their levels, where they
//! share one zero) are not those of one surface of second order. Form, as waviness and reliefs, is
//! left by both and says nothing of the kind.

use nalgebra::{DMatrix, DVector};

use super::flank_surface::{Sample, Through, through};
use crate::Kind;
use flankfit_numerics::{cancel::Asking, distribution::fisher, qr_with_rhs};

/// Contradiction of traces and surface, rms in µm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Contradiction {
    pub apart: f64,
    /// Deviation of each trace from its own parabola.
    pub own: f64,
    /// The value with the helices turned, where that corrects it.
    pub turned: Option<f64>,
}

/// If all traces together leave so many times what each leaves of its own parabola, squared,
/// they contradict the surface. Waves of two periods and more over the range leave at most 0.2 of
/// it between traces.
const CONTRADICTION: f64 = 4.0;
/// No contradiction below, rms in µm: what files are rounded to.
const LEAST_CONTRADICTION: f64 = 0.1;
/// Probability of a contradiction that is noise.
const TAIL: f64 = 1e-3;
/// Fewest degrees of freedom that tell what traces leave of their own parabolas.
const FEWEST_FREE: f64 = 8.0;
/// Share of the contradiction that is left where the sign of the helices was wrong.
const MENDED: f64 = 0.25;

/// Deviation of each trace from its own parabola.
struct Own {
    /// Σ weight · residual², scaled to what it is expected to be without the parabolas.
    rss: f64,
    whole: f64,
    free: f64,
    /// Value between traces that is due to noise of that size.
    expected: f64,
    /// Σ weight · residual² itself.
    plain: f64,
}

impl Own {
    fn of(traces: &[Vec<Sample>], kinds: &[Kind]) -> Self {
        let mut own = Own { rss: 0.0, whole: 0.0, free: 0.0, expected: 0.0, plain: 0.0 };
        for (trace, kind) in traces.iter().zip(kinds) {
            let (n, weight) = (trace.len(), trace.iter().map(|sample| sample.weight).sum::<f64>());
            own.whole += weight;
            if n <= 3 {
                continue;
            }
            let mut columns = DMatrix::zeros(n, 3);
            let mut heights = DVector::zeros(n);
            for (i, sample) in trace.iter().enumerate().asking(10) {
                let (root, t) = (sample.weight.sqrt(), if *kind == Kind::Profile { sample.u } else { sample.v });
                for j in 0..3 {
                    columns[(i, j)] = root * t.powi(j as i32);
                }
                heights[i] = root * sample.deviation;
            }
            let rss = qr_with_rhs(columns, heights).rss;
            let free = (n - 3) as f64;
            own.plain += rss;
            own.rss += rss * n as f64 / free;
            own.free += free;
            own.expected += rss / free;
        }
        own
    }
}

/// Whether the traces contradict their surface, and whether they still do with the helices turned.
pub(super) fn contradiction(
    traces: &[Vec<Sample>],
    kinds: &[Kind],
    found: &Through,
    share_zero: bool,
) -> Option<Contradiction> {
    let own = Own::of(traces, kinds);
    if own.free < FEWEST_FREE {
        return None;
    }
    // of a trace slope and curvature can contradict the others
    let limit = 2.0 * fisher::upper_quantile(TAIL, 2.0, own.free) * own.expected;
    let least = (CONTRADICTION * own.rss).max(limit).max(own.whole * LEAST_CONTRADICTION * LEAST_CONTRADICTION);
    let apart = (found.rss - own.plain).max(0.0);
    if apart <= least {
        return None;
    }
    let mut turned = traces.to_vec();
    let helices = turned.iter_mut().zip(kinds).filter(|(_, kind)| **kind == Kind::Helix);
    helices.for_each(|(trace, _)| trace.iter_mut().for_each(|sample| sample.deviation = -sample.deviation));
    let left = through(&turned, share_zero).map(|found| (found.rss - own.plain).max(0.0));
    let rms = |sum: f64| (sum / own.whole).sqrt();
    let turned = left.filter(|left| *left <= MENDED * apart).map(rms);
    Some(Contradiction { apart: rms(apart), own: rms(own.plain), turned })
}
