//! Other control points for the same spline, by polar forms.
//!
//! On a span, a polynomial f of degree p has one symmetric polar form F of p arguments, affine in each, with F(t, …, t) = f(t).
//! Control point j of a spline is F at the knots j + 1 … j + p, with the F of any span that the basis function j lives on
//! (Ramshaw, "Blossoms are polar forms", 1989). So new knots ask for nothing but values of F.

use nalgebra::Vector4;

use super::axis::Axis;

/// A control point with its weight, (w x, w y, w z, w): splines of these are not rational.
pub(super) type Homogeneous = Vector4<f64>;

/// F of the polynomial on `span`, by the de Boor recursion with another argument in each step.
fn polar(axis: &Axis, controls: &[Homogeneous], span: usize, arguments: impl Iterator<Item = f64>) -> Homogeneous {
    let (p, knots) = (axis.degree, &axis.knots);
    let mut points = controls[span - p..=span].to_vec();
    for (step, t) in arguments.enumerate() {
        for j in (step + 1..=p).rev() {
            let i = span - p + j;
            let (low, high) = (knots[i], knots[i + p - step]);
            let share = (t - low) / (high - low);
            points[j] = points[j - 1] * (1.0 - share) + points[j] * share;
        }
    }
    points[p]
}

/// The span of `axis`, among those that have a width, that holds the middle of [low, high].
fn span_of(axis: &Axis, low: f64, high: f64) -> usize {
    let middle = low + (high - low) / 2.0;
    let (knots, p) = (&axis.knots, axis.degree);
    let above = knots.partition_point(|k| *k <= middle);
    let mut span = above.saturating_sub(1).clamp(p, axis.size() - 1);
    while span > p && !(knots[span] < knots[span + 1]) {
        span -= 1;
    }
    span
}

/// Where the new function `j` of `degree` is asked for: the widest span of `knots` that it lives on.
fn support(knots: &[f64], degree: usize, j: usize) -> [f64; 2] {
    let mut best = [knots[j], knots[j]];
    for k in j..=j + degree {
        if knots[k + 1] - knots[k] > best[1] - best[0] {
            best = [knots[k], knots[k + 1]];
        }
    }
    best
}

/// The same spline over the axis `finer`, of the same degree and with at least the knots that `axis` has in its domain.
pub(super) fn refined(axis: &Axis, controls: &[Homogeneous], finer: &Axis) -> Vec<Homogeneous> {
    let (p, knots) = (axis.degree, &finer.knots);
    let one = |j: usize| {
        let [low, high] = support(knots, p, j);
        polar(axis, controls, span_of(axis, low, high), knots[j + 1..=j + p].iter().copied())
    };
    (0..finer.size()).map(one).collect()
}

/// `t ↦ times(t, f(t))`, over the axis `higher` of one degree more; `times` is affine in t and linear in f(t).
///
/// The polar form of the product is the mean of `times(tᵢ, F(all the others))` over i.
pub(super) fn raised(
    axis: &Axis,
    controls: &[Homogeneous],
    higher: &Axis,
    times: impl Fn(f64, &Homogeneous) -> Homogeneous,
) -> Vec<Homogeneous> {
    let (p, knots) = (higher.degree, &higher.knots);
    let one = |j: usize| {
        let [low, high] = support(knots, p, j);
        let span = span_of(axis, low, high);
        let arguments = &knots[j + 1..=j + p];
        let sum: Homogeneous = (0..p)
            .map(|i| {
                let others = arguments.iter().enumerate().filter(|(k, _)| *k != i).map(|(_, t)| *t);
                times(arguments[i], &polar(axis, controls, span, others))
            })
            .sum();
        sum / p as f64
    };
    (0..higher.size()).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::BSplineBasis;

    fn value(axis: &Axis, controls: &[Homogeneous], t: f64) -> Homogeneous {
        let basis = BSplineBasis::new(axis.degree, axis.knots.clone()).unwrap();
        let mut out = vec![0.0; axis.degree + 1];
        let first = basis.values(t, &mut out);
        out.iter().zip(&controls[first..]).map(|(n, c)| c * *n).sum()
    }

    /// Loose ends, a double knot and uneven spans.
    fn spline() -> (Axis, Vec<Homogeneous>) {
        let axis = Axis { degree: 3, knots: vec![-1.0, -0.5, 0.0, 0.25, 1.0, 1.0, 2.5, 4.0, 4.5, 5.0, 6.0] };
        let controls = (0..axis.size()).map(|i| {
            let x = i as f64;
            Homogeneous::new(x.sin(), (2.0 * x).cos(), x * 0.5 - 1.0, 1.0 + 0.25 * x)
        });
        let controls = controls.collect();
        (axis, controls)
    }

    #[test]
    fn clamping_leaves_the_spline() {
        let (axis, controls) = spline();
        let clamped = axis.clamped();
        assert_eq!(clamped.knots, [0.25, 0.25, 0.25, 0.25, 1.0, 1.0, 2.5, 4.0, 4.0, 4.0, 4.0]);
        let other = refined(&axis, &controls, &clamped);
        for k in 0..=60 {
            let t = 0.25 + 3.75 * f64::from(k) / 60.0;
            assert!((value(&axis, &controls, t) - value(&clamped, &other, t)).norm() < 1e-14);
        }
    }

    #[test]
    fn a_product_with_the_parameter() {
        let (axis, controls) = spline();
        let times = |t: f64, f: &Homogeneous| Homogeneous::new(t * f.w, f.y, f.z, f.w);
        let higher = axis.raised();
        assert_eq!(higher.knots, [[0.25; 5].as_slice(), &[1.0; 3], &[2.5; 2], &[4.0; 5]].concat());
        let product = raised(&axis, &controls, &higher, times);
        for k in 0..=60 {
            let t = 0.25 + 3.75 * f64::from(k) / 60.0;
            let (here, there) = (value(&axis, &controls, t), value(&higher, &product, t));
            assert!((times(t, &here) - there).norm() < 1e-13, "{t}");
        }
    }
}
