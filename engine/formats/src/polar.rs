//! Other control points for the same spline, by the polar forms of [`flankfit_geometry::polar`].

use super::axis::Axis;
use flankfit_geometry::{BSplineBasis, polar::blossom};
use flankfit_numerics::cancel::Asking;

/// A control point with its weight, (w x, w y, w z, w): splines of these are not rational.
pub(super) type Homogeneous = [f64; 4];

/// The middle of the widest span of `knots` that function `j` lives on.
fn support(knots: &[f64], degree: usize, j: usize) -> f64 {
    let mut best = [knots[j], knots[j]];
    for k in j..=j + degree {
        if knots[k + 1] - knots[k] > best[1] - best[0] {
            best = [knots[k], knots[k + 1]];
        }
    }
    best[0] + (best[1] - best[0]) / 2.0
}

/// The same spline over the axis `finer`, of the same degree and with at least the knots that
/// `basis` has in its domain.
pub(super) fn refined(basis: &BSplineBasis, controls: &[Homogeneous], finer: &Axis) -> Vec<Homogeneous> {
    let (p, knots) = (finer.degree, &finer.knots);
    let one = |j: usize| {
        let span = basis.span(support(knots, p, j));
        blossom(basis, controls, span, &knots[j + 1..=j + p])
    };
    (0..finer.size()).asking(500).map(one).collect()
}

/// `t ↦ times(t, f(t))`, of one degree more, over the axis `higher`; `times` is affine in t and
/// linear in f(t).
///
/// The polar form of the product is the mean of `times(tᵢ, F(all others))` over i, where F is that
/// of f.
pub(super) fn raised(
    basis: &BSplineBasis,
    controls: &[Homogeneous],
    higher: &Axis,
    times: impl Fn(f64, Homogeneous) -> Homogeneous,
) -> Vec<Homogeneous> {
    let (p, knots) = (higher.degree, &higher.knots);
    let one = |j: usize| {
        let span = basis.span(support(knots, p, j));
        let arguments = &knots[j + 1..=j + p];
        let mut sum = [0.0; 4];
        for (i, t) in arguments.iter().enumerate() {
            let others = [&arguments[..i], &arguments[i + 1..]].concat();
            let part = times(*t, blossom(basis, controls, span, &others));
            (0..4).for_each(|k| sum[k] += part[k] / p as f64);
        }
        sum
    };
    (0..higher.size()).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(axis: &Axis, controls: &[Homogeneous], t: f64) -> Homogeneous {
        let basis = BSplineBasis::new(axis.degree, axis.knots.clone()).unwrap();
        let mut out = vec![0.0; axis.degree + 1];
        let first = basis.values(t, &mut out);
        std::array::from_fn(|k| out.iter().zip(&controls[first..]).map(|(n, c)| c[k] * n).sum())
    }

    /// Loose ends, a double knot and uneven spans.
    fn spline() -> (BSplineBasis, Axis, Vec<Homogeneous>) {
        let knots = vec![-1.0, -0.5, 0.0, 0.25, 1.0, 1.0, 2.5, 4.0, 4.5, 5.0, 6.0];
        let basis = BSplineBasis::new(3, knots).unwrap();
        let control = |i| {
            let x = f64::from(i);
            [x.sin(), (2.0 * x).cos(), x * 0.5 - 1.0, 1.0 + 0.25 * x]
        };
        (basis.clone(), Axis::from(&basis), (0..7).map(control).collect())
    }

    #[track_caller]
    fn same(a: Homogeneous, b: Homogeneous) {
        assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-13), "{a:?} {b:?}");
    }

    #[test]
    fn clamping_leaves_the_spline() {
        let (basis, axis, controls) = spline();
        let clamped = axis.clamped();
        assert_eq!(clamped.knots, [0.25, 0.25, 0.25, 0.25, 1.0, 1.0, 2.5, 4.0, 4.0, 4.0, 4.0]);
        let other = refined(&basis, &controls, &clamped);
        for k in 0..=60 {
            let t = 0.25 + 3.75 * f64::from(k) / 60.0;
            same(value(&axis, &controls, t), value(&clamped, &other, t));
        }
    }

    #[test]
    fn a_product_with_the_parameter() {
        let (basis, axis, controls) = spline();
        let times = |t: f64, [_, y, z, w]: Homogeneous| [t * w, y, z, w];
        let higher = axis.raised();
        assert_eq!(higher.knots, [[0.25; 5].as_slice(), &[1.0; 3], &[2.5; 2], &[4.0; 5]].concat());
        let product = raised(&basis, &controls, &higher, times);
        for k in 0..=60 {
            let t = 0.25 + 3.75 * f64::from(k) / 60.0;
            same(times(t, value(&axis, &controls, t)), value(&higher, &product, t));
        }
    }
}
