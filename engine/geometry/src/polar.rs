//! Polar forms (blossoms) of splines: the one mechanism behind knot insertion, degree elevation and
//! splitting.
//!
//! To every polynomial of degree p belongs one symmetric function of p arguments, affine in each,
//! that is the polynomial where all arguments are equal. The control points of a spline are its
//! polar form at p consecutive knots, so that a change of knots is an evaluation (Ramshaw 1987;
//! Boehm's knot insertion is the case of one knot more). Control points have N coordinates; those
//! of a rational spline are (w x, w y, w z, w).

use crate::BSplineBasis;
use flankfit_numerics::{Dd, Real};

/// The polar form of the polynomial on knot span `span` at `arguments` (as many as the degree).
pub fn blossom<T: Real, const N: usize>(
    basis: &BSplineBasis,
    controls: &[[T; N]],
    span: usize,
    arguments: &[f64],
) -> [T; N] {
    let p = basis.degree();
    local_blossom(&basis.knots()[span + 1 - p..=span + p], controls[span - p..=span].to_vec(), arguments)
}

/// The same of a span's own p + 1 control points `d` and the 2p `knots` about it.
pub(crate) fn local_blossom<T: Real, const N: usize>(knots: &[f64], mut d: Vec<[T; N]>, arguments: &[f64]) -> [T; N] {
    let p = d.len() - 1;
    for (r, &u) in arguments.iter().enumerate() {
        for i in (r + 1..=p).rev() {
            let (low, high) = (knots[i - 1], knots[p + i - r - 1]);
            let width = T::of_dd(Dd::diff(high, low));
            let (left, right) = (T::of_dd(Dd::diff(high, u)) / width, T::of_dd(Dd::diff(u, low)) / width);
            for k in 0..N {
                d[i][k] = left * d[i - 1][k] + right * d[i][k];
            }
        }
    }
    d[p]
}

/// The span of `old` that function `index` of `new` is read from: one that both share, as near to
/// the function's middle as there is.
fn source(old: &BSplineBasis, new: &BSplineBasis, index: usize) -> usize {
    let (p, knots) = (new.degree(), new.knots());
    let spans = p..new.size();
    let middle = index + p / 2;
    let wide = |j: &usize| knots[*j] < knots[j + 1];
    // a function whose support lies outside of the domain is read from the nearest span within
    let nearest = |j: usize| j.abs_diff(middle) * 2 + usize::from(j < middle);
    let span = spans.filter(wide).min_by_key(|j| nearest(*j)).unwrap_or(p);
    old.span(0.5 * knots[span] + 0.5 * knots[span + 1])
}

/// Control points over the knots of `new`, of the same degree: the same curve wherever every knot
/// of `old` is also one of `new`.
pub(crate) fn change_knots<T: Real, const N: usize>(
    old: &BSplineBasis,
    controls: &[[T; N]],
    new: &BSplineBasis,
) -> Vec<[T; N]> {
    let p = old.degree();
    let knots = new.knots();
    (0..new.size()).map(|i| blossom(old, controls, source(old, new, i), &knots[i + 1..=i + p])).collect()
}

/// Control points over the knots of `new`, whose degree is one higher and whose knots stand once
/// more each than those of `old`.
pub(crate) fn raise_degree<T: Real, const N: usize>(
    old: &BSplineBasis,
    controls: &[[T; N]],
    new: &BSplineBasis,
) -> Vec<[T; N]> {
    let q = new.degree();
    let knots = new.knots();
    let raised = |i: usize| {
        let span = source(old, new, i);
        let mut sum = [T::zero(); N];
        for omitted in 0..q {
            let mut arguments = knots[i + 1..=i + q].to_vec();
            arguments.remove(omitted);
            let part = blossom(old, controls, span, &arguments);
            (0..N).for_each(|k| sum[k] += part[k]);
        }
        sum.map(|x| x / T::of(q as f64))
    };
    (0..new.size()).map(raised).collect()
}
