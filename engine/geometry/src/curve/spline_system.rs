//! The equations of a cubic spline for the slopes at its nodes, and what their matrix does to
//! vectors.
//!
//! Row i says that the second derivative is continuous at node i; it is scaled to 2 on the
//! diagonal. The rows of the ends depend on [`Ends`]. Of a periodic spline the slope at node 0
//! is a border around a band.

use super::ends::{End, Ends};
use flankfit_numerics::{Banded, BandedLu, Dd, cancel::Asking, dot};

pub(super) type Slopes = Vec<[Dd; 3]>;

/// Widths of the spans.
pub(super) fn widths(nodes: &[f64]) -> Vec<Dd> {
    nodes.windows(2).map(|x| Dd::diff(x[1], x[0])).collect()
}

/// Continuity of the second derivative between two spans: factors of the slopes before, at and
/// after the node, and the right side.
pub(super) fn continuity(h: [Dd; 2], d: [Dd; 3], next: [Dd; 3]) -> ([Dd; 3], [Dd; 3]) {
    let sum = h[0] + h[1];
    let right = [0, 1, 2].map(|k| (d[k] * h[1] + next[k] * h[0]) * 3.0 / sum);
    ([h[1] / sum, Dd::from(2.0), h[0] / sum], right)
}

/// The matrix for the slopes, with rows of size 1, and the right sides.
pub(super) fn open_system(nodes: &[f64], secants: &[[Dd; 3]], start: &End, end: &End) -> (Banded<Dd>, Slopes) {
    let (n, h) = (nodes.len(), widths(nodes));
    let both = n == 3 && *start == End::NotAKnot && *end == End::NotAKnot;
    let reach = 1.min(n - 1);
    let mut a = Banded::zeros(n, reach, reach);
    let mut b = vec![[Dd::ZERO; 3]; n];
    for i in (1..n - 1).asking(50) {
        let (row, right) = continuity([h[i - 1], h[i]], secants[i - 1], secants[i]);
        (0..3).for_each(|k| a.set(i, i + k - 1, row[k]));
        b[i] = right;
    }
    let two = Dd::from(2.0);
    let mut condition = |end: &End, at: usize, next: usize, h: Dd, other: Option<Dd>, d: [[Dd; 3]; 2], sign: f64| {
        match (end, other) {
            (End::Slope(s), _) => {
                a.set(at, at, Dd::ONE);
                b[at] = [s.x, s.y, s.z].map(Dd::from);
            }
            (End::SecondDerivative(s), _) => {
                a.set(at, at, two);
                a.set(at, next, Dd::ONE);
                b[at] = [0, 1, 2].map(|k| d[0][k] * 3.0 - h * s[k] * (0.5 * sign));
            }
            // one span only: its third derivative is 0
            (End::NotAKnot, None) => {
                a.set(at, at, Dd::ONE);
                a.set(at, next, Dd::ONE);
                b[at] = d[0].map(|d| d + d);
            }
            (End::NotAKnot, Some(other)) => {
                let sum = h + other;
                a.set(at, at, other / sum);
                a.set(at, next, Dd::ONE);
                let right = |k: usize| ((h + sum + sum) * other * d[0][k] + h * h * d[1][k]) / sum / sum;
                b[at] = [0, 1, 2].map(right);
            }
        }
    };
    let last = n - 1;
    let other = |i: usize| (n > 2).then(|| h[i]);
    let second = |i: usize| if n > 2 { secants[i] } else { secants[0] };
    condition(start, 0, 1, h[0], other(1.min(n - 2)), [secants[0], second(1.min(n - 2))], 1.0);
    let before = n.saturating_sub(3);
    condition(end, last, last - 1, h[last - 1], other(before), [secants[last - 1], second(before)], -1.0);
    if both {
        // the two conditions say the same of three nodes: the parabola, whose third derivative is 0
        a.set(last, last, Dd::ONE);
        a.set(last, last - 1, Dd::ONE);
        b[last] = secants[last - 1].map(|d| d + d);
    }
    if n == 2 && *start == End::NotAKnot && *end == End::NotAKnot {
        // and of two nodes: the straight line
        a.set(0, 1, Dd::ZERO);
        b[0] = secants[0];
    }
    (a, b)
}

/// The rows of inner nodes without the slope at node 0, which is also that of the last node.
pub(super) fn inner_system(nodes: &[f64], secants: &[[Dd; 3]]) -> (Banded<Dd>, Slopes, Vec<Dd>) {
    let (m, h) = (nodes.len() - 2, widths(nodes));
    let reach = 1.min(m - 1);
    let mut a = Banded::zeros(m, reach, reach);
    let mut border = vec![Dd::ZERO; m];
    let mut b = Vec::with_capacity(m);
    for i in (0..m).asking(50) {
        let (row, right) = continuity([h[i], h[i + 1]], secants[i], secants[i + 1]);
        a.set(i, i, row[1]);
        if i > 0 {
            a.set(i, i - 1, row[0]);
        } else {
            border[i] += row[0];
        }
        if i + 1 < m {
            a.set(i, i + 1, row[2]);
        } else {
            border[i] += row[2];
        }
        b.push(right);
    }
    (a, b, border)
}

/// Operator on the unknown slopes: a vector by the matrix or its inverse, or by their
/// transposes, for its condition.
pub(super) struct SlopeMatrix {
    matrix: Banded<f64>,
    lu: BandedLu<f64>,
    /// Row and column of node 0 of a periodic spline.
    border: Option<Border>,
}

struct Border {
    column: Vec<f64>,
    row: Vec<f64>,
    /// The inverse of the band times the column, and of its transpose times the row.
    solved_column: Vec<f64>,
    solved_row: Vec<f64>,
    corner: f64,
    pivot: f64,
}

impl SlopeMatrix {
    /// The matrix of the slopes of a spline at these nodes, rows scaled to a diagonal of 2.
    pub(crate) fn new(nodes: &[f64], ends: &Ends) -> Option<Self> {
        let secants = vec![[Dd::ZERO; 3]; nodes.len() - 1];
        match ends {
            Ends::Each { start, end } => {
                let matrix = open_system(nodes, &secants, start, end).0.map(Dd::to_f64);
                let lu = matrix.clone().factor().ok()?;
                Some(SlopeMatrix { matrix, lu, border: None })
            }
            Ends::Periodic if nodes.len() > 2 => {
                let h = widths(nodes);
                let (a, _, column) = inner_system(nodes, &secants);
                let matrix = a.map(Dd::to_f64);
                let lu = matrix.clone().factor().ok()?;
                let m = nodes.len() - 2;
                let (ends, _) = continuity([h[m], h[0]], secants[0], secants[0]);
                let mut row = vec![0.0; m];
                row[m - 1] += ends[0].to_f64();
                row[0] += ends[2].to_f64();
                let column: Vec<f64> = column.iter().map(|x| x.to_f64()).collect();
                let (mut solved_column, mut solved_row) = (column.clone(), row.clone());
                lu.solve(&mut solved_column);
                lu.solve_transposed(&mut solved_row);
                let corner = ends[1].to_f64();
                let pivot = corner - dot(&row, &solved_column);
                let border = Some(Border { column, row, solved_column, solved_row, corner, pivot });
                Some(SlopeMatrix { matrix, lu, border })
            }
            Ends::Periodic => None,
        }
    }

    /// How many unknowns there are; that of node 0 of a periodic spline is the last.
    pub(crate) fn size(&self) -> usize {
        self.matrix.size() + usize::from(self.border.is_some())
    }

    /// `x` by the matrix or its transpose.
    pub(crate) fn multiply(&self, x: &mut [f64], transposed: bool) {
        let m = self.matrix.size();
        let (inner, last) = x.split_at_mut(m);
        let mut product = if transposed { self.matrix.multiply_transposed(inner) } else { self.matrix.multiply(inner) };
        if let (Some(border), Some(last)) = (&self.border, last.first_mut()) {
            let (column, row) = if transposed { (&border.row, &border.column) } else { (&border.column, &border.row) };
            let corner = dot(row, inner) + border.corner * *last;
            product.iter_mut().zip(column).for_each(|(p, c)| *p += c * *last);
            *last = corner;
        }
        inner.copy_from_slice(&product);
    }

    /// `x` by the inverse of the matrix or of its transpose.
    pub(crate) fn solve(&self, x: &mut [f64], transposed: bool) {
        let (inner, last) = x.split_at_mut(self.matrix.size());
        if transposed {
            self.lu.solve_transposed(inner)
        } else {
            self.lu.solve(inner)
        }
        if let (Some(border), Some(last)) = (&self.border, last.first_mut()) {
            let (row, solved) =
                if transposed { (&border.column, &border.solved_row) } else { (&border.row, &border.solved_column) };
            *last = (*last - dot(row, inner)) / border.pivot;
            inner.iter_mut().zip(solved).for_each(|(x, s)| *x -= s * *last);
        }
    }
}
