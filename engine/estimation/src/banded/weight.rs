//! The weight λ of a penalty on a big surface: what each λ gives, and the search.
//!
//! `edf(λ) = trace(F (F + λP)⁻¹)` needs the inverse within the band only, which is exact; where
//! even that costs too much, a fixed set of random signs estimates it (Hutchinson 1990), and the
//! answer says so.

use rand_chacha::{
    ChaCha8Rng,
    rand_core::{RngCore, SeedableRng},
};

use super::system::{Penalty, Solved, System};
use crate::smoothing::choice::{ChosenLambda, Figures, Problem, Smoothing, find, unsolved};
use flankfit_numerics::{band_cholesky::SymmetricBand, check::Faults};

/// From how many operations (n · bandwidth²) on the trace is estimated.
const EXACT: f64 = 4e9;
/// Random vectors of an estimated trace, and their seed.
pub(crate) const PROBES: usize = 32;
pub(crate) const SEED: u64 = 0x5e_ed0f_7ace;
/// λ is searched in units of trace(F)/trace(P), within these natural logarithms.
const RANGE: [f64; 2] = [-23.0, 16.0];

/// Method by which the trace of the smoother was computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trace {
    /// From the inverse within the band, to rounding.
    Exact,
    /// The mean over so many random vectors of a fixed seed.
    Estimated {
        /// Number of the random vectors.
        probes: usize,
        /// Seed that they were drawn from.
        seed: u64,
    },
}

/// Method by which traces of this system are computed.
pub(crate) fn trace_of(system: &System) -> Trace {
    let (n, w) = (system.size() as f64, system.normal.fisher.width() as f64);
    if n * w * w <= EXACT { Trace::Exact } else { Trace::Estimated { probes: PROBES, seed: SEED } }
}

/// λ in units of which the two matrices are alike.
fn alike(system: &System, matrix: &SymmetricBand<f64>) -> f64 {
    let trace = |m: &SymmetricBand<f64>| (0..m.size()).map(|j| m.get(j, j)).sum::<f64>();
    trace(&system.normal.fisher) / trace(matrix)
}

/// Finds λ.
pub(crate) fn choose(
    system: &System,
    matrix: &SymmetricBand<f64>,
    asked: Smoothing,
    variance: Option<f64>,
) -> Result<ChosenLambda, Faults> {
    if let Smoothing::Parameter(crate::spec::Parameter::Fixed(_)) = asked {
        let problem = Problem { count: 1, coordinates: 1, variance, range: [0.0, 1.0] };
        return find(asked, &problem, |_| None);
    }
    let unit = alike(system, matrix);
    if !(unit > 0.0 && unit.is_finite()) {
        return Err(unsolved());
    }
    // sums about one solution of a medium λ, so that RSS of another is no difference of large
    // numbers
    let reference = system.solve(Some(Penalty { lambda: 1e-4 * unit, matrix })).map_err(|_| unsolved())?;
    let about = Reference::new(&reference);
    let problem = Problem {
        count: system.cells.count(),
        coordinates: system.normal.rhs.len(),
        variance,
        range: RANGE.map(|x| x + unit.ln()),
    };
    let probes = probes(system);
    find(asked, &problem, |lambda| figures(system, matrix, lambda, &about, &probes))
}

struct Reference {
    coefficients: Vec<Vec<f64>>,
    /// `XᵀΩr`.
    projected: Vec<Vec<f64>>,
    rss: f64,
}

impl Reference {
    fn new(solved: &Solved) -> Self {
        let plain = |columns: &[Vec<flankfit_numerics::dd::Dd>]| -> Vec<Vec<f64>> {
            columns.iter().map(|column| column.iter().map(|x| x.to_f64()).collect()).collect()
        };
        Reference {
            coefficients: plain(&solved.coefficients),
            projected: plain(&solved.residuals.projected),
            rss: solved.residuals.rss.iter().map(|rss| rss.to_f64()).sum(),
        }
    }
}

fn probes(system: &System) -> Vec<Vec<f64>> {
    let Trace::Estimated { probes, seed } = trace_of(system) else { return Vec::new() };
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut signs = || if random.next_u32() >> 31 == 0 { 1.0 } else { -1.0 };
    (0..probes).map(|_| (0..system.size()).map(|_| signs()).collect()).collect()
}

fn figures(
    system: &System,
    matrix: &SymmetricBand<f64>,
    lambda: f64,
    about: &Reference,
    probes: &[Vec<f64>],
) -> Option<Figures> {
    let factor = system.plain_factor(Some(Penalty { lambda, matrix }))?;
    let fisher = &system.normal.fisher;
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (mut rss, mut roughness, mut slope) = (about.rss, 0.0, 0.0);
    for (d, rhs) in system.normal.rhs.iter().enumerate() {
        let mut c = rhs.clone();
        factor.solve(&mut c);
        let moved: Vec<f64> = c.iter().zip(&about.coefficients[d]).map(|(c, r)| c - r).collect();
        rss += fisher.form(&moved, &moved) - 2.0 * dot(&about.projected[d], &moved);
        let pulled = matrix.multiply(&c);
        roughness += dot(&c, &pulled);
        let mut answer = pulled.clone();
        factor.solve(&mut answer);
        slope -= 2.0 * dot(&pulled, &answer);
    }
    let effective = if probes.is_empty() {
        fisher.trace_of_product(&factor.inverse_band())
    } else {
        let each = probes.iter().map(|probe| {
            let mut x = probe.clone();
            factor.solve(&mut x);
            dot(&fisher.multiply(probe), &x)
        });
        each.sum::<f64>() / probes.len() as f64
    };
    Some(Figures { rss: rss.max(0.0), roughness, roughness_slope: slope, effective })
}

/// `trace(F (F + λP)⁻¹)` of a solution.
pub(crate) fn effective(system: &System, solved: &Solved) -> f64 {
    let probes = probes(system);
    let fisher = &system.normal.fisher;
    if probes.is_empty() {
        return fisher.trace_of_product(&solved.factor.inverse_band());
    }
    let each = probes.iter().map(|probe| {
        let mut x = probe.clone();
        solved.factor.solve(&mut x);
        fisher.multiply(probe).iter().zip(&x).map(|(a, b)| a * b).sum::<f64>()
    });
    each.sum::<f64>() / probes.len() as f64
}
