//! The derivative that one constraint is about, over its part of the domain.

use nalgebra::DMatrix;

use super::{
    patch::{Least, Patch},
    pieces::{Piece, Pieces},
};
use crate::{
    design::{Axis, Basis, Design},
    spec::{Constraint, Domain, FilterAxis},
};
use flankfit_numerics::{Dd, cancel::Asking};

/// Each cell is looked at in 2 to the power of this many parts, so that a line along which a
/// derivative vanishes is met at many places at once.
const HALVINGS: usize = 4;

/// The derivative of one constraint, signed so that it must not be below 0.
pub(super) struct Field {
    pub along: FilterAxis,
    pub domain: Domain,
    sign: f64,
    u: Pieces,
    v: Pieces,
    /// Unit in which the derivative is measured.
    pub scale: f64,
}

/// A place within a piece of a field.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    pub field: usize,
    pub cell: [usize; 2],
    /// In shares of the cell.
    pub at: [f64; 2],
}

impl Field {
    /// Returns the field of a checked constraint.
    pub(super) fn new(design: &Design, constraint: &Constraint) -> Option<Self> {
        let Basis::Product { u: axis_u, v: axis_v } = &design.basis else { return None };
        let whole = design.domain?;
        let own = constraint.domain.unwrap_or_default();
        let (range_u, range_v) = (own.u.or(whole.u)?, own.v.or(whole.v));
        let along = constraint.along.unwrap_or(FilterAxis::U);
        let order = constraint.kind.order();
        let pieces = |axis: &Axis, range: [f64; 2], own: FilterAxis| {
            Pieces::new(axis, range, if own == along { order } else { 0 })
        };
        Some(Field {
            along,
            domain: Domain { u: Some(range_u), v: range_v },
            sign: constraint.kind.sign(),
            u: pieces(axis_u, range_u, FilterAxis::U),
            v: pieces(axis_v, range_v.unwrap_or_default(), FilterAxis::V),
            scale: 1.0,
        })
    }

    /// Width of the range along which the derivative is.
    pub(super) fn width(&self) -> f64 {
        let range = if self.along == FilterAxis::U { self.domain.u } else { self.domain.v };
        range.map_or(1.0, |[low, high]| high - low)
    }

    fn cells(&self) -> impl Iterator<Item = [usize; 2]> {
        let columns = self.v.pieces.len();
        (0..self.u.pieces.len() * columns).map(move |k| [k / columns, k % columns])
    }

    /// The derivative over a cell, in units of the scale; `net` holds the coefficients of the
    /// products of working functions.
    fn patch(&self, net: &DMatrix<Dd>, [i, j]: [usize; 2]) -> Patch {
        let (u, v) = (&self.u.pieces[i], &self.v.pieces[j]);
        let own = net.view((u.first, v.first), (u.change.ncols(), v.change.ncols()));
        let product = &u.change * own * v.change.transpose();
        let factor = self.sign / self.scale;
        let by_rows = product.transpose().iter().map(|c| c.to_f64() * factor).collect();
        Patch::whole(by_rows, product.ncols())
    }

    /// The largest coefficient of the derivative.
    pub(super) fn largest(&self, net: &DMatrix<Dd>) -> f64 {
        self.cells().map(|cell| self.patch(net, cell).largest()).fold(0.0, f64::max)
    }

    /// The lowest places of the parts of each cell where the derivative falls below `enough`, with
    /// their values.
    pub(super) fn lows(&self, net: &DMatrix<Dd>, enough: f64, near: impl Fn(f64) -> f64) -> Vec<([usize; 2], Least)> {
        let mut lows = Vec::new();
        for cell in self.cells().asking(1000) {
            let patch = self.patch(net, cell);
            if patch.lowest() >= enough {
                continue;
            }
            for part in patch.parts(HALVINGS).into_iter().filter(|part| part.lowest() < enough) {
                let least = part.least(enough, &near);
                if least.value < enough {
                    lows.push((cell, least));
                }
            }
        }
        lows
    }

    /// Lower bound of the least value over all cells.
    pub(super) fn bound(&self, net: &DMatrix<Dd>, near: impl Fn(f64) -> f64) -> f64 {
        let bounds = self.cells().asking(1000).map(|cell| self.patch(net, cell).least(f64::INFINITY, &near).bound);
        bounds.fold(f64::INFINITY, f64::min)
    }

    fn on(&self, spot: &Spot) -> (&Piece, &Piece) {
        (&self.u.pieces[spot.cell[0]], &self.v.pieces[spot.cell[1]])
    }

    /// The derivative at a spot as a row of the working matrix, in units of the scale.
    pub(super) fn row(&self, design: &Design, spot: &Spot) -> Vec<Dd> {
        let (u, v) = self.on(spot);
        let (along_u, along_v) = (u.row(spot.at[0]), v.row(spot.at[1]));
        let of = |row: &[Dd], first: usize, index: usize| {
            index.checked_sub(first).and_then(|k| row.get(k)).copied().unwrap_or(Dd::ZERO)
        };
        let factor = self.sign / self.scale;
        let term = |&(i, j): &(usize, usize)| of(&along_u, u.first, i) * of(&along_v, v.first, j) * factor;
        design.terms.iter().map(term).collect()
    }

    /// u and v of a spot.
    pub(super) fn place(&self, spot: &Spot) -> [f64; 2] {
        let (u, v) = self.on(spot);
        [u.place(spot.at[0]), v.place(spot.at[1])]
    }
}

/// The coefficients of the products of working functions; those of terms that take no part are 0.
pub(super) fn net(design: &Design, working: &[Dd]) -> DMatrix<Dd> {
    let (rows, columns) = match &design.basis {
        Basis::Product { u, v } => (u.size(), v.size()),
        Basis::Columns { .. } => (0, 0),
    };
    let mut net = DMatrix::from_element(rows, columns, Dd::ZERO);
    for (&(i, j), value) in design.terms.iter().zip(working) {
        net[(i, j)] = *value;
    }
    net
}
