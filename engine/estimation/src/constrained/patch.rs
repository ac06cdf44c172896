//! The least value of a polynomial over a rectangle, between bounds.
//!
//! In Bernstein's basis a polynomial lies above its least coefficient, and has the coefficients at
//! the corners. The rectangle with the lowest bound is halved until that bound is near the lowest
//! value met: branch and bound. The bound is proved (to the rounding of doubles), the value is
//! reached.

use std::{cmp::Ordering, collections::BinaryHeap};

use flankfit_numerics::cancel;

/// Greatest number of rectangles; then the bound is used as it is.
const MOST: usize = 20_000;

/// Bernstein coefficients over part of a cell.
#[derive(Clone)]
pub(super) struct Patch {
    /// Rows run along u.
    pub coefficients: Vec<f64>,
    pub columns: usize,
    /// Position of the patch, in shares of the cell.
    pub from: [f64; 2],
    pub size: [f64; 2],
}

/// The least value of a polynomial over a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Least {
    /// The polynomial is nowhere below.
    pub bound: f64,
    /// A value that it has, and where, in shares of the cell.
    pub value: f64,
    pub at: [f64; 2],
}

/// A patch in the order of its bound.
struct Queued {
    bound: f64,
    patch: Patch,
}

impl PartialEq for Queued {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Queued {}

impl PartialOrd for Queued {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Queued {
    /// The lowest bound first; equal ones by their place, so that the order is always the same.
    fn cmp(&self, other: &Self) -> Ordering {
        let place = |one: &Queued| one.patch.from;
        let by_place = place(other)[0].total_cmp(&place(self)[0]).then(place(other)[1].total_cmp(&place(self)[1]));
        other.bound.total_cmp(&self.bound).then(by_place)
    }
}

impl Patch {
    /// The patch of a whole cell.
    pub(super) fn whole(coefficients: Vec<f64>, columns: usize) -> Self {
        Patch { coefficients, columns, from: [0.0; 2], size: [1.0; 2] }
    }

    pub(super) fn lowest(&self) -> f64 {
        self.coefficients.iter().copied().fold(f64::INFINITY, f64::min)
    }

    pub(super) fn largest(&self) -> f64 {
        self.coefficients.iter().fold(0.0, |most: f64, c| most.max(c.abs()))
    }

    fn rows(&self) -> usize {
        self.coefficients.len() / self.columns
    }

    /// Value and place of the lowest corner.
    fn corner(&self) -> (f64, [f64; 2]) {
        let (rows, columns) = (self.rows(), self.columns);
        let at = |i: usize, j: usize| {
            let value = self.coefficients[i * (rows - 1) * columns + j * (columns - 1)];
            (value, [self.from[0] + i as f64 * self.size[0], self.from[1] + j as f64 * self.size[1]])
        };
        [at(0, 1), at(1, 0), at(1, 1)].into_iter().fold(at(0, 0), |best, one| if one.0 < best.0 { one } else { best })
    }

    /// Both halves (de Casteljau) across an axis.
    fn halves(self, axis: impl Fn(&Patch) -> usize) -> [Patch; 2] {
        let (rows, columns, across) = (self.rows(), self.columns, axis(&self));
        let (length, lines, stride, offset) =
            if across == 0 { (rows, columns, columns, 1) } else { (columns, rows, 1, columns) };
        let (mut low, mut high) = (self.clone(), self);
        for line in 0..lines {
            let index = |k: usize| line * offset + k * stride;
            for turn in 0..length {
                low.coefficients[index(turn)] = high.coefficients[index(0)];
                for k in 0..length - 1 - turn {
                    high.coefficients[index(k)] = 0.5 * (high.coefficients[index(k)] + high.coefficients[index(k + 1)]);
                }
            }
        }
        low.size[across] *= 0.5;
        high.size[across] *= 0.5;
        high.from[across] += high.size[across];
        [low, high]
    }

    /// The patch in equal parts, 2 to the power of `turns`; fewer where it has no such axis.
    pub(super) fn parts(self, turns: usize) -> Vec<Patch> {
        let mut parts = vec![self];
        for _ in 0..turns {
            parts = parts.into_iter().flat_map(|part| part.halves(Patch::longest)).collect();
        }
        parts
    }

    /// The axis along which the patch is longer, of those along which it varies.
    fn longest(&self) -> usize {
        let length = |axis: usize, count: usize| if count > 1 { self.size[axis] } else { 0.0 };
        usize::from(length(1, self.columns) > length(0, self.rows()))
    }

    /// The axis along which the coefficients differ most.
    fn steepest(&self) -> usize {
        let (rows, columns) = (self.rows(), self.columns);
        let step = |across: usize| {
            let ahead = if across == 0 { columns } else { 1 };
            let pairs = (0..rows * columns - ahead).filter(|k| across == 0 || (k + 1) % columns != 0);
            pairs.map(|k| (self.coefficients[k + ahead] - self.coefficients[k]).abs()).fold(0.0, f64::max)
        };
        // changes between the corners of the net, whatever its degree
        let swing = |across: usize, count: usize| if count > 1 { step(across) * (count - 1) as f64 } else { -1.0 };
        usize::from(swing(1, columns) > swing(0, rows))
    }

    /// The least value: bound and value differ by at most `near(value)`, or the bound reaches
    /// `enough`, or it takes too many rectangles.
    pub(super) fn least(self, enough: f64, near: impl Fn(f64) -> f64) -> Least {
        let (value, at) = self.corner();
        let mut found = Least { bound: f64::NEG_INFINITY, value, at };
        let mut queue = BinaryHeap::from([Queued { bound: self.lowest(), patch: self }]);
        let mut count = 0;
        while let Some(Queued { bound, patch }) = queue.pop() {
            found.bound = bound;
            count += 1;
            let done = bound >= enough || found.value - bound <= near(found.value);
            if done || count > MOST || patch.coefficients.len() == 1 {
                break;
            }
            cancel::every(patch.coefficients.len() * 20, count);
            for half in patch.halves(Patch::steepest) {
                let (value, at) = half.corner();
                if value < found.value {
                    (found.value, found.at) = (value, at);
                }
                queue.push(Queued { bound: half.lowest(), patch: half });
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (s − 0.3)² + (t − 0.6)² − 1e-3, in Bernstein's basis of degree 2 by 2.
    fn bowl() -> Patch {
        let parabola = |c: f64| [c * c, c * c - c, (1.0 - c) * (1.0 - c)];
        let (a, b) = (parabola(0.3), parabola(0.6));
        Patch::whole((0..9).map(|k| a[k / 3] + b[k % 3] - 1e-3).collect(), 3)
    }

    #[test]
    fn the_bottom_of_a_bowl_is_found_and_bounded() {
        let least = bowl().least(0.0, |_| 1e-12);
        assert!((least.value + 1e-3).abs() < 1e-12 && least.bound <= least.value && least.value - least.bound <= 1e-12);
        assert!((least.at[0] - 0.3).abs() < 1e-5 && (least.at[1] - 0.6).abs() < 1e-5, "{least:?}");
        // what is far from 0 is not looked into
        let above = Patch { coefficients: bowl().coefficients.iter().map(|c| c + 1.0).collect(), ..bowl() };
        let least = above.least(0.0, |_| 1e-12);
        assert!(least.bound >= 0.0 && least.bound < 1.0 && least.value > 0.999);
    }

    #[test]
    fn parts_are_the_whole() {
        let parts = bowl().parts(3);
        assert_eq!(parts.len(), 8);
        assert!((parts.iter().map(|part| part.size[0] * part.size[1]).sum::<f64>() - 1.0).abs() < 1e-15);
        let least = |patch: Patch| patch.least(f64::INFINITY, |_| 1e-9).value;
        let lowest = parts.into_iter().map(least).fold(f64::INFINITY, f64::min);
        assert!((lowest + 1e-3).abs() < 1e-9);
        assert!(Patch::whole(vec![0.0, -0.5, 0.0], 3).parts(2).iter().all(|part| part.size == [1.0, 0.25]));
    }

    #[test]
    fn along_a_line_and_over_constants() {
        // t² − t over a curve: the first axis is not there
        let line = Patch::whole(vec![0.0, -0.5, 0.0], 3);
        let least = line.least(1.0, |_| 1e-10);
        assert!((least.value + 0.25).abs() < 1e-10 && (least.at[1] - 0.5).abs() < 1e-5);
        let column = Patch::whole(vec![0.0, -0.5, 0.0], 1);
        assert!((column.least(1.0, |_| 1e-10).at[0] - 0.5).abs() < 1e-5);
        let least = Patch::whole(vec![-2.0], 1).least(0.0, |_| 0.0);
        assert_eq!((least.bound, least.value), (-2.0, -2.0));
    }
}
