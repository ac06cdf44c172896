//! B-splines of one axis span by span, as polynomials about the middle of the span.
//!
//! A million nodes ask for values without a division: `t = (x − middle) · 2ᵏ`, and each of the p +
//! 1 functions is a polynomial in t, its coefficients formed once in double-double from the
//! derivatives at the middle.

use flankfit_geometry::BSplineBasis;
use flankfit_numerics::{Dd, Real};

/// Highest degree: powers about the middle of a span keep their digits up to here.
pub(crate) const HIGHEST_DEGREE: usize = 9;

/// The spans of an axis.
#[derive(Clone, Debug)]
pub(crate) struct Pieces<T> {
    pub degree: usize,
    /// Functions.
    pub size: usize,
    /// Distinct knots of the domain.
    pub breaks: Vec<f64>,
    spans: Vec<Span<T>>,
}

#[derive(Clone, Debug)]
struct Span<T> {
    first: usize,
    middle: f64,
    scale: f64,
    /// Power by power, from the highest down, for all functions.
    powers: Vec<T>,
}

impl<T: Real> Pieces<T> {
    pub(crate) fn new(basis: &BSplineBasis) -> Self {
        let p = basis.degree();
        let breaks = basis.distinct_knots();
        let mut values = vec![Dd::ZERO; p + 1];
        let spans = breaks
            .windows(2)
            .map(|ends| {
                let middle = 0.5 * ends[0] + 0.5 * ends[1];
                // a power of 2, so that the map is exact
                let width = 0.5 * (ends[1] - ends[0]);
                let exponent = -(width.log2().ceil().clamp(-1000.0, 1000.0) as i32);
                let scale = 2f64.powi(exponent);
                let mut powers = vec![T::of(0.0); (p + 1) * (p + 1)];
                let (mut first, mut factor) = (0, Dd::ONE);
                for d in 0..=p {
                    if d > 0 {
                        factor = factor / Dd::from(d as f64) / Dd::from(scale);
                    }
                    first = basis.derivatives_of(d, middle, &mut values);
                    for (r, &value) in values.iter().enumerate() {
                        powers[(p - d) * (p + 1) + r] = T::of_dd(value * factor);
                    }
                }
                Span { first, middle, scale, powers }
            })
            .collect();
        Pieces { degree: p, size: basis.size(), breaks, spans }
    }

    /// Number of spans.
    pub(crate) fn count(&self) -> usize {
        self.spans.len()
    }

    /// The first function that is not 0 on span `s`.
    pub(crate) fn first(&self, s: usize) -> usize {
        self.spans[s].first
    }

    /// The span that `x` lies in; the last one is closed on the right.
    pub(crate) fn span_of(&self, x: f64) -> usize {
        self.breaks.partition_point(|&k| k <= x).clamp(1, self.spans.len()) - 1
    }

    /// Values of the p + 1 functions of span `s` at `x`.
    #[inline(always)]
    pub(crate) fn values(&self, s: usize, x: f64, out: &mut [T]) {
        let span = &self.spans[s];
        let t = T::of_dd(Dd::diff(x, span.middle)).mul_f64(span.scale);
        let width = out.len();
        out.copy_from_slice(&span.powers[..width]);
        for row in span.powers[width..].chunks_exact(width) {
            for (value, &power) in out.iter_mut().zip(row) {
                *value = value.mul_add(t, power);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_values_as_by_recursion() {
        for p in 0..=HIGHEST_DEGREE {
            let mut knots = vec![30.0; p + 1];
            knots.extend([30.25, 31.0, 31.0, 33.0]);
            knots.extend(vec![34.0; p + 1]);
            if p == 0 {
                knots.remove(2);
            }
            let basis = BSplineBasis::new(p, knots).unwrap();
            let (plain, wide) = (Pieces::<f64>::new(&basis), Pieces::<Dd>::new(&basis));
            for i in 0..=200 {
                let x = 30.0 + 4.0 * f64::from(i) / 200.0;
                let (mut truth, mut got) = (vec![Dd::ZERO; p + 1], vec![Dd::ZERO; p + 1]);
                let first = basis.values(x, &mut truth);
                let s = wide.span_of(x);
                assert_eq!(wide.first(s), first, "{p} {x}");
                wide.values(s, x, &mut got);
                let mut double = vec![0.0; p + 1];
                plain.values(s, x, &mut double);
                for r in 0..=p {
                    assert!((got[r] - truth[r]).to_f64().abs() < 1e-28, "{p} {x}");
                    assert!((double[r] - truth[r].to_f64()).abs() < 1e-14, "{p} {x}");
                }
            }
        }
    }
}
