//! Nodes by the tile: thirty-two of them, four side by side, and the Chebyshev polynomials of a
//! tile.
//!
//! Inner loops over a tile have a fixed length, so that what is done for each term (loads,
//! addresses, loop control) is shared by eight groups of four nodes.

use super::{
    axis::Axis,
    measurement_matrix::{Basis, Design},
};
use crate::data::Sample;
use flankfit_geometry::Mapping;
use flankfit_numerics::lanes::{F64x4, LANES, Lanes};

/// Groups of four nodes in a tile.
pub(crate) const GROUPS: usize = 8;
/// Nodes in a tile.
pub(crate) const TILE: usize = GROUPS * LANES;

/// Counted nodes side by side; places left over repeat a node with weight 0.
pub(crate) struct Tile {
    pub u: [F64x4; GROUPS],
    pub v: [F64x4; GROUPS],
    pub z: [F64x4; GROUPS],
    pub w: [F64x4; GROUPS],
    /// Number of places that hold nodes of their own.
    pub counted: usize,
}

impl Sample<'_> {
    /// The counted nodes from `start` on.
    #[inline(always)]
    pub(crate) fn tile(&self, start: usize) -> Tile {
        let none = [F64x4::ZERO; GROUPS];
        let mut tile = Tile { u: none, v: none, z: none, w: none, counted: (self.count() - start).min(TILE) };
        for g in 0..GROUPS {
            let four = self.four(start + g * LANES);
            (tile.u[g], tile.v[g]) = (F64x4::new(four.u), F64x4::new(four.v));
            (tile.z[g], tile.w[g]) = (F64x4::new(four.z), F64x4::new(four.w));
        }
        tile
    }
}

/// The two mapped axes of a product of Chebyshev polynomials.
pub(crate) struct Chebyshev<'a> {
    pub u: (Mapping, usize),
    pub v: (Mapping, usize),
    pub terms: &'a [(usize, usize)],
}

impl<'a> Chebyshev<'a> {
    /// Returns the axes of `design` if its working basis is a product of Chebyshev polynomials.
    pub(crate) fn of(design: &'a Design) -> Option<Self> {
        match &design.basis {
            Basis::Product {
                u: Axis::Polynomial { mapping: mu, size: p, .. },
                v: Axis::Polynomial { mapping: mv, size: q, .. },
            } => Some(Chebyshev { u: (*mu, *p), v: (*mv, *q), terms: &design.terms }),
            _ => None,
        }
    }

    /// Functions on each axis.
    pub(crate) fn shape(&self) -> (usize, usize) {
        (self.u.1, self.v.1)
    }
}

/// Chebyshev polynomials T₀, T₁, … at the mapped `x`, as many as `out` holds.
///
/// Loops, not `from_fn`: what is called and not inlined is not taken along by kernels that are
/// compiled twice.
#[inline(always)]
pub(crate) fn chebyshev<L: Lanes>(x: &[F64x4; GROUPS], mapping: Mapping, out: &mut [[L; GROUPS]]) {
    let mut t = [L::ZERO; GROUPS];
    for g in 0..GROUPS {
        t[g] = L::mapped(x[g], mapping.center, mapping.scale);
    }
    for i in 0..out.len() {
        let mut next = match i {
            0 => [L::from_doubles(F64x4::ONE); GROUPS],
            _ => t,
        };
        if i > 1 {
            for g in 0..GROUPS {
                next[g] = t[g].doubled().fma(out[i - 1][g], out[i - 2][g].neg());
            }
        }
        out[i] = next;
    }
}

/// `sum + Σ a b` over a tile.
#[inline(always)]
pub(crate) fn products<L: Lanes>(a: &[L; GROUPS], b: &[L; GROUPS], mut sum: L) -> L {
    for g in 0..GROUPS {
        sum = sum.accumulate(a[g], b[g]);
    }
    sum
}
