//! Making rows of a measurement matrix white.

use super::{lines::Lines, process::Whitening};
use crate::{
    data::{Heights, Sample, WhiteRows},
    design::{Design, Row},
};
use flankfit_numerics::{Dd, cancel::Asking};

/// `L⁻¹[W y 1]`: rows of `sample` times the roots of its weights, made white along `lines`.
pub(crate) fn white_rows(design: &Design, sample: &Sample, lines: &Lines, whitening: &Whitening) -> WhiteRows {
    let n = design.size();
    let width = n + 2;
    let mut along = vec![Dd::ZERO; sample.count() * width];
    let mut row = Row::<Dd>::new(design);
    for (to, &k) in along.chunks_exact_mut(width).zip(&lines.nodes).asking(50 * n) {
        row.at(design, sample, k);
        let weight = sample.w(k);
        let root = if weight == 1.0 { Dd::ONE } else { Dd::from(weight).sqrt() };
        for (&j, &x) in row.index.iter().zip(&row.values) {
            to[j] = x * root;
        }
        (to[n], to[n + 1]) = (root * sample.z(k), root);
    }
    whitening.whiten(&mut along, width);
    let mut rows = vec![Dd::ZERO; along.len()];
    for (from, &k) in along.chunks_exact(width).zip(&lines.nodes) {
        rows[k * width..][..width].copy_from_slice(from);
    }
    WhiteRows { width, rows }
}

/// Sums over white heights, with the constant fitted by generalised least squares as their mean.
pub(crate) fn white_heights(white: &WhiteRows, posted: &Heights) -> Heights {
    let (mut ones, mut mixed, mut squares, mut largest) = (Dd::ZERO, Dd::ZERO, Dd::ZERO, 0.0f64);
    for k in (0..white.count()).asking(20) {
        let (z, one) = (white.height(k), white.one(k));
        ones += one * one;
        mixed += one * z;
        squares += z * z;
        largest = largest.max(z.to_f64().abs());
    }
    Heights {
        weight: ones.to_f64(),
        about_mean: (squares - mixed * mixed / ones).to_f64().max(0.0),
        about_zero: squares.to_f64(),
        largest,
        largest_plain: posted.largest_plain,
    }
}
