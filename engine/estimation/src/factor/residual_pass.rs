//! Passes over the nodes that form residuals of the working basis and their projections.
//!
//! Nodes are taken in chunks of a fixed size whose partial sums are added in order, so that results
//! do not depend on how many threads work.

use std::ops::Range;

use super::chunks::over_chunks;
use crate::{
    data::Sample,
    design::{
        Design, Row,
        tile::{self, Chebyshev, GROUPS, TILE},
    },
};
use flankfit_numerics::{
    Dd, Real,
    cancel::{self, Asking},
    lanes::{Ddx4, F64x4, Lanes},
    with_fma,
};

/// Sums of one pass over the residuals `z − Wc`.
pub(crate) struct ResidualPass {
    /// `WᵀΩr`.
    pub projected: Vec<Dd>,
    /// `Σ w r²`.
    pub rss: Dd,
    pub max_abs: f64,
    /// Residuals, if requested.
    pub values: Vec<f64>,
}

/// Precision of a residual pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Precision {
    Double,
    DoubleDouble,
}

/// From how many nodes on residuals, formed in double-double, are projected in double precision:
/// what that rounding leaves averages out below the rounding of the heights themselves.
const MANY: usize = 2_048;

/// Relative error that projecting residuals leaves in a double-double pass over `count` nodes.
pub(super) fn projection_error(count: usize, residual: f64, size: f64) -> f64 {
    if count >= MANY && size > 0.0 { f64::EPSILON * residual / size / (count as f64).sqrt() } else { 0.0 }
}

/// Results of a pass in addition to `Σ w r²` and `max |r|`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wanted {
    Sums,
    /// `WᵀΩr` as well.
    Projection,
    /// The same, in double-double for any number of nodes.
    SharpProjection,
    /// The residuals as well.
    Values,
}

impl Wanted {
    fn projects(self) -> bool {
        matches!(self, Wanted::Projection | Wanted::SharpProjection)
    }
}

/// Residuals of the working coefficients `c`, evaluated to `precision`.
pub(crate) fn residual_pass(
    design: &Design,
    sample: &Sample,
    c: &[Dd],
    precision: Precision,
    wanted: Wanted,
) -> ResidualPass {
    match (Chebyshev::of(design).filter(|_| !sample.is_white()), precision) {
        (Some(axes), Precision::Double) => tiled_residuals::<F64x4, F64x4>(&axes, sample, c, wanted),
        (Some(axes), Precision::DoubleDouble) if sample.count() >= MANY && wanted != Wanted::SharpProjection => {
            tiled_residuals::<Ddx4, F64x4>(&axes, sample, c, wanted)
        }
        (Some(axes), Precision::DoubleDouble) => tiled_residuals::<Ddx4, Ddx4>(&axes, sample, c, wanted),
        (None, Precision::Double) => row_residuals::<f64>(design, sample, c, wanted),
        (None, Precision::DoubleDouble) => row_residuals::<Dd>(design, sample, c, wanted),
    }
}

struct Part<S> {
    projected: Vec<S>,
    rss: Dd,
    max_abs: f64,
    values: Vec<f64>,
}

/// `L`: the arithmetic in which residuals are formed; `S`: in which they are projected.
fn tiled_residuals<L: Lanes, S: Lanes>(axes: &Chebyshev, sample: &Sample, c: &[Dd], wanted: Wanted) -> ResidualPass {
    let (p, q) = axes.shape();
    // coefficients as a table, column by column of v; absent terms (total degree) end a column
    // early
    let mut table = vec![L::ZERO; p * q];
    let mut heights = vec![0; q];
    for (&(i, j), &value) in axes.terms.iter().zip(c) {
        table[j * p + i] = L::splat(L::Number::of_dd(value));
        heights[j] = heights[j].max(i + 1);
    }
    let keep = wanted == Wanted::Values;
    let project = wanted.projects();
    let mut pass = ResidualPass {
        projected: vec![Dd::ZERO; if project { c.len() } else { 0 }],
        rss: Dd::ZERO,
        max_abs: 0.0,
        values: Vec::with_capacity(if keep { sample.count() } else { 0 }),
    };
    over_chunks(
        sample.count(),
        |range| tiled_chunk::<L, S>(axes, sample, &table, &heights, wanted, range),
        |part| {
            for (total, &(i, j)) in pass.projected.iter_mut().zip(axes.terms) {
                *total += part.projected[j * p + i].settled().sum_of_pairs().to_dd();
            }
            pass.rss += part.rss;
            pass.max_abs = pass.max_abs.max(part.max_abs);
            pass.values.extend(part.values);
        },
    );
    pass
}

with_fma! {
    /// The pass over one chunk of nodes; `table` has the coefficients, column by column of v, of
    /// which each has so many `heights`.
    fn tiled_chunk<L: Lanes, S: Lanes>(
        axes: &Chebyshev,
        sample: &Sample,
        table: &[L],
        heights: &[usize],
        wanted: Wanted,
        range: Range<usize>,
    ) -> Part<S> {
        let (p, q) = axes.shape();
        let (keep, project) = (wanted == Wanted::Values, wanted.projects());
        let mut part = Part {
            projected: vec![S::ZERO; if project { p * q } else { 0 }],
            rss: Dd::ZERO,
            max_abs: 0.0,
            values: Vec::with_capacity(if keep { range.len() } else { 0 }),
        };
        let (mut a, mut b) = (vec![[L::ZERO; GROUPS]; p], vec![[L::ZERO; GROUPS]; q]);
        let mut narrow_a = vec![[S::ZERO; GROUPS]; if project { p } else { 0 }];
        let (mut rss, mut largest) = ([L::ZERO; GROUPS], [F64x4::ZERO; GROUPS]);
        for start in range.clone().step_by(TILE) {
            cancel::every(4 * TILE * axes.terms.len(), (start - range.start) / TILE);
            let nodes = sample.tile(start);
            tile::chebyshev(&nodes.u, axes.u.0, &mut a);
            tile::chebyshev(&nodes.v, axes.v.0, &mut b);
            let mut fitted = [L::ZERO; GROUPS];
            for (j, b) in b.iter().enumerate() {
                let column = &table[j * p..j * p + heights[j]];
                // as many sums at a time as registers hold
                for half in [0, GROUPS / 2] {
                    let mut sum = [L::ZERO; GROUPS / 2];
                    for (c, a) in column.iter().zip(&a) {
                        for g in 0..GROUPS / 2 {
                            sum[g] = sum[g].accumulate(*c, a[half + g]);
                        }
                    }
                    for g in 0..GROUPS / 2 {
                        fitted[half + g] = fitted[half + g].accumulate(sum[g].settled(), b[half + g]);
                    }
                }
            }
            let mut weighted = [L::ZERO; GROUPS];
            let mut plain = [F64x4::ZERO; GROUPS];
            for g in 0..GROUPS {
                let residual = L::from_doubles(nodes.z[g]).sub(fitted[g].settled());
                weighted[g] = residual.mul_doubles(nodes.w[g]);
                rss[g] = weighted[g].fma(residual, rss[g]);
                plain[g] = residual.to_doubles();
                // places left over repeat a node, so they change no maximum
                largest[g] = plain[g].abs().larger(largest[g]);
            }
            if keep {
                let plain = plain.map(F64x4::to_array);
                part.values.extend_from_slice(&plain.as_flattened()[..nodes.counted]);
            }
            if project {
                narrow_a.iter_mut().zip(&a).for_each(|(to, from)| *to = from.map(narrow));
                let weighted = weighted.map(narrow::<L, S>);
                for (j, b) in b.iter().enumerate() {
                    let mut share = [S::ZERO; GROUPS];
                    for g in 0..GROUPS {
                        share[g] = weighted[g].mul(narrow(b[g]));
                    }
                    for (sum, a) in part.projected[j * p..j * p + heights[j]].iter_mut().zip(&narrow_a) {
                        *sum = tile::products(&share, a, *sum);
                    }
                }
            }
        }
        part.rss = rss.into_iter().fold(Dd::ZERO, |sum, rss| sum + rss.sum_of_pairs().to_dd());
        part.max_abs = largest.into_iter().flat_map(F64x4::to_array).fold(0.0, f64::max);
        part
    }
}

/// The same numbers in the arithmetic of the projection.
#[inline(always)]
fn narrow<L: Lanes, S: Lanes>(x: L) -> S {
    let (hi, lo) = x.parts();
    S::from_parts(hi, lo)
}

fn row_residuals<T: Real>(design: &Design, sample: &Sample, c: &[Dd], wanted: Wanted) -> ResidualPass {
    let keep = wanted == Wanted::Values;
    let n = c.len();
    let c: Vec<T> = c.iter().map(|&c| T::of_dd(c)).collect();
    let mut pass = ResidualPass { projected: vec![Dd::ZERO; n], rss: Dd::ZERO, max_abs: 0.0, values: Vec::new() };
    over_chunks(
        sample.count(),
        |range| {
            let mut part = Part { projected: vec![T::of(0.0); n], rss: Dd::ZERO, max_abs: 0.0, values: Vec::new() };
            let mut row = Row::<T>::new(design);
            let mut rss = T::of(0.0);
            for k in range.asking(20 * n) {
                row.at(design, sample, k);
                let mut residual: T = sample.height(k);
                for (&j, &x) in row.index.iter().zip(&row.values) {
                    residual -= x * c[j];
                }
                let weighted = residual.mul_f64(sample.w(k));
                rss += weighted * residual;
                for (&j, &x) in row.index.iter().zip(&row.values) {
                    part.projected[j] += x * weighted;
                }
                let plain = residual.to_f64();
                part.max_abs = part.max_abs.max(plain.abs());
                if keep {
                    part.values.push(plain);
                }
            }
            part.rss = rss.to_dd();
            part
        },
        |part| {
            for (total, part) in pass.projected.iter_mut().zip(part.projected) {
                *total += part.to_dd();
            }
            pass.rss += part.rss;
            pass.max_abs = pass.max_abs.max(part.max_abs);
            pass.values.extend(part.values);
        },
    );
    pass
}
