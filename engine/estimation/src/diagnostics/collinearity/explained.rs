//! Share of one column that is explained by others.

use nalgebra::DMatrix;

use flankfit_numerics::{
    cancel::Asking,
    columns::dot,
    lanes::{self, F64x4, Lanes},
    with_fma,
};

/// The columns divided by their lengths, and how many lanes each has.
pub(super) fn unit_columns(plain: &DMatrix<f64>, length: &[f64]) -> (Vec<F64x4>, usize) {
    let stride = lanes::lanes_for(plain.nrows());
    let mut unit = vec![F64x4::ZERO; stride * length.len()];
    let columns = plain.as_slice().chunks_exact(plain.nrows());
    for ((to, from), length) in unit.chunks_exact_mut(stride).zip(columns).zip(length) {
        let inverse = 1.0 / length;
        for (to, from) in to.iter_mut().zip(from.chunks(lanes::LANES)) {
            from.iter().enumerate().for_each(|(k, x)| to.set(k, x * inverse));
        }
    }
    (unit, stride)
}

/// R² (about 0) of the first of `terms` on the others: modified Gram–Schmidt on the columns, the
/// first one last. `unit` has the columns of unit length, each of `stride` lanes.
pub(super) fn explained(unit: &[F64x4], stride: usize, terms: &[usize], room: &mut Vec<F64x4>) -> f64 {
    room.clear();
    for &j in terms[1..].iter().chain(&terms[..1]) {
        room.extend_from_slice(&unit[j * stride..(j + 1) * stride]);
    }
    // columns are taken four at a time: the last one is followed by columns of zeros
    room.resize((terms.len() + 3) * stride, F64x4::ZERO);
    let mut rest = &mut room[..];
    for _ in (1..terms.len()).asking(terms.len() * terms.len()) {
        let (direction, after) = rest.split_at_mut(stride);
        let square: f64 = dot(direction, direction);
        if square > 1e-30 {
            after.chunks_exact_mut(4 * stride).for_each(|four| remove(direction, -1.0 / square, four));
        }
        rest = after;
    }
    let last = &rest[..stride];
    1.0 - dot::<f64>(last, last)
}

/// `x += factor (d·x) d` for four columns x, one behind the other.
#[inline(never)]
fn remove(d: &[F64x4], factor: f64, columns: &mut [F64x4]) {
    remove_from_four(d, factor, columns)
}

with_fma! {
    fn remove_from_four(d: &[F64x4], factor: f64, columns: &mut [F64x4]) {
        let n = d.len();
        let (a, columns) = columns.split_at_mut(n);
        let (b, columns) = columns.split_at_mut(n);
        let (c, e) = columns.split_at_mut(n);
        let e = &mut e[..n];
        let mut along = [F64x4::ZERO; 4];
        for k in 0..n {
            let d = d[k];
            along = [
                along[0].accumulate_late(d, a[k]),
                along[1].accumulate_late(d, b[k]),
                along[2].accumulate_late(d, c[k]),
                along[3].accumulate_late(d, e[k]),
            ];
        }
        let along = along.map(|sum| sum.sum_of_halves() * factor);
        for k in 0..n {
            let d = d[k];
            a[k] = a[k].add_scaled(along[0], d);
            b[k] = b[k].add_scaled(along[1], d);
            c[k] = c[k].add_scaled(along[2], d);
            e[k] = e[k].add_scaled(along[3], d);
        }
    }
}

/// Condition index of two columns of unit length with this cosine, if there were no others.
pub(super) fn pair_index(cosine: f64) -> f64 {
    ((1.0 + cosine.abs()) / (1.0 - cosine.abs())).sqrt()
}
