//! B-spline basis functions by the Cox–de Boor recursion (Eqs. 7 and 8 of the paper).
//!
//! Knots are the full vector `k₀ ≤ … ≤ k_{n+p}`; the basis lives on `[k_p, k_n]`, the last span
//! being closed on the right. A basis of degree `p` (order `p + 1`) has `n = knots − p − 1`
//! functions, of which `p + 1` are not 0 at any place.

use flankfit_numerics::{
    Dd, Real,
    check::Faults,
    words::{Shown, counted},
};

/// A checked knot vector with its degree.
#[derive(Clone, Debug, PartialEq)]
pub struct BSplineBasis {
    degree: usize,
    knots: Vec<f64>,
}

impl BSplineBasis {
    /// Checks a full knot vector; a fault is placed from that vector.
    pub fn new(degree: usize, knots: Vec<f64>) -> Result<Self, Faults> {
        // a degree may be any number that a request holds
        let least = degree.saturating_add(1).saturating_mul(2);
        if knots.len() < least {
            let given = counted(knots.len(), "knot", "knots");
            return Err(Faults::one("", format_args!("{given}: degree {degree} needs at least {least}")));
        }
        for (index, &value) in knots.iter().enumerate() {
            let at = format_args!("[{index}]");
            if !value.is_finite() {
                return Err(Faults::one(at, format_args!("knot {index} is not finite")));
            }
            if index > 0 && value < knots[index - 1] {
                let (value, before) = (Shown(value), Shown(knots[index - 1]));
                return Err(Faults::one(
                    at,
                    format_args!("knot {index} ({value}) lies below the one before it ({before})"),
                ));
            }
            if index > degree && knots[index - degree - 1] == value {
                let (value, most) = (Shown(value), degree + 1);
                let message = format_args!("the knot {value} occurs more than degree + 1 = {most} times");
                return Err(Faults::one(at, message));
            }
        }
        let basis = BSplineBasis { degree, knots };
        let (low, high) = basis.domain();
        if low < high {
            return Ok(basis);
        }
        let (low, high) = (Shown(low), Shown(high));
        Err(Faults::one("", format_args!("the domain of the knots, [{low}, {high}], has no width")))
    }

    /// `spans` equal spans over `[low, high]`, the ends repeated degree + 1 times.
    pub fn uniform(degree: usize, spans: usize, low: f64, high: f64) -> Result<Self, Faults> {
        let inner = (1..spans).map(|i| {
            let s = i as f64 / spans as f64;
            low * (1.0 - s) + high * s
        });
        let ends = |value| std::iter::repeat_n(value, degree + 1);
        Self::new(degree, ends(low).chain(inner).chain(ends(high)).collect())
    }

    /// How many functions there are.
    pub fn size(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    /// Polynomial degree of the pieces.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// The full knot vector.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// Domain of the basis.
    pub fn domain(&self) -> (f64, f64) {
        (self.knots[self.degree], self.knots[self.size()])
    }

    /// The knots within the domain, both ends included, each once.
    pub fn distinct_knots(&self) -> Vec<f64> {
        let mut knots = self.knots[self.degree..=self.size()].to_vec();
        knots.dedup();
        knots
    }

    /// The span `s` with `k_s ≤ x < k_{s+1}`, the last one closed on the right.
    pub fn span(&self, x: f64) -> usize {
        let n = self.size();
        if x >= self.knots[n] {
            // the last span that has a width
            return (self.degree..n).rev().find(|&s| self.knots[s] < self.knots[s + 1]).unwrap_or(self.degree);
        }
        let above = self.knots[self.degree..=n].partition_point(|&k| k <= x);
        (self.degree + above).saturating_sub(1).clamp(self.degree, n - 1)
    }

    /// Values of the functions that are not 0 at `x` into `out` (length degree + 1); returns the
    /// first one's index.
    ///
    /// ```
    /// use flankfit_geometry::BSplineBasis;
    ///
    /// // Degree 2 over one span: (1 − x)², 2x (1 − x), x².
    /// let basis = BSplineBasis::uniform(2, 1, 0.0, 1.0)?;
    /// let mut values = [0.0; 3];
    /// assert_eq!(basis.values(0.25, &mut values), 0);
    /// assert_eq!(values, [0.5625, 0.375, 0.0625]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn values<T: Real>(&self, x: f64, out: &mut [T]) -> usize {
        let span = self.span(x);
        self.recurse(span, self.degree, x, out);
        span - self.degree
    }

    /// First derivatives of the same functions.
    ///
    /// ```
    /// use flankfit_geometry::BSplineBasis;
    ///
    /// // (1 − x)², 2x (1 − x), x² have the slopes −2 (1 − x), 2 − 4x, 2x.
    /// let basis = BSplineBasis::uniform(2, 1, 0.0, 1.0)?;
    /// let mut slopes = [0.0; 3];
    /// basis.derivatives(0.25, &mut slopes);
    /// assert_eq!(slopes, [-1.5, 1.0, 0.5]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn derivatives(&self, x: f64, out: &mut [f64]) -> usize {
        let (span, p) = (self.span(x), self.degree);
        out.fill(0.0);
        if p == 0 {
            return span;
        }
        let mut lower = vec![0.0; p];
        self.recurse(span, p - 1, x, &mut lower);
        for (i, value) in lower.iter().enumerate() {
            // function number span − p + 1 + i of degree p − 1
            let j = span + 1 + i - p;
            let width = self.knots[j + p] - self.knots[j];
            if width > 0.0 {
                let slope = p as f64 * value / width;
                out[i + 1] += slope;
                out[i] -= slope;
            }
        }
        span - p
    }

    /// Derivatives of order `order` of the same functions, taken on the span that `x` lies in.
    pub fn derivatives_of<T: Real>(&self, order: usize, x: f64, out: &mut [T]) -> usize {
        let (span, p) = (self.span(x), self.degree);
        out.fill(T::of(0.0));
        if order > p {
            return span - p;
        }
        // values of degree p − order at the end of the slice, then raised degree by degree
        let low = p - order;
        self.recurse(span, low, x, &mut out[order..]);
        for d in low + 1..=p {
            for r in p - d + 1..=p {
                // function number span − p + r of degree d − 1
                let j = span + r - p;
                let width = T::of_dd(Dd::diff(self.knots[j + d], self.knots[j]));
                let slope = out[r].mul_f64(d as f64) / width;
                out[r - 1] += -slope;
                out[r] = slope;
            }
        }
        span - p
    }

    fn recurse<T: Real>(&self, span: usize, degree: usize, x: f64, out: &mut [T]) {
        let gap = |a: f64, b: f64| T::of_dd(Dd::diff(a, b));
        out[0] = T::of(1.0);
        for d in 1..=degree {
            let mut carried = T::of(0.0);
            for (r, value) in out[..d].iter_mut().enumerate() {
                let (high, low) = (self.knots[span + r + 1], self.knots[span + 1 + r - d]);
                let share = *value / gap(high, low);
                *value = carried + gap(high, x) * share;
                carried = gap(x, low) * share;
            }
            out[d] = carried;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Exact fractions of the basis of degree 2 on {0,0,0,1,2,3,4,4,5,5,5} at u = 5/2 (worked by
    /// hand from Eq. 8).
    #[test]
    fn quadratic_basis_by_hand() {
        let basis = BSplineBasis::new(2, vec![0., 0., 0., 1., 2., 3., 4., 4., 5., 5., 5.]).unwrap();
        let mut out = [0.0; 3];
        assert_eq!(basis.values(2.5, &mut out), 2);
        assert_eq!(out, [0.125, 0.75, 0.125]);
        assert_eq!(basis.derivatives(2.5, &mut out), 2);
        assert_eq!(out, [-0.5, 0.0, 0.5]);
    }

    #[test]
    fn errors_name_the_knot() {
        let message = |degree, knots: &[f64]| BSplineBasis::new(degree, knots.to_vec()).unwrap_err().to_string();
        assert_eq!(message(1, &[0., 1.]), "2 knots: degree 1 needs at least 4");
        for degree in [usize::MAX, usize::MAX / 2, isize::MAX as usize] {
            assert!(message(degree, &[0., 1.]).starts_with("2 knots: degree"), "{degree}");
        }
        assert!(message(1, &[0., 0., 2., 1., 3., 3.]).starts_with("[3]: knot 3 (1) lies below"));
        assert!(message(1, &[0., 0., 1., 1., 1., 3., 3.]).starts_with("[4]: the knot 1 occurs more"));
        assert!(BSplineBasis::new(0, vec![1., 1.]).is_err());
    }

    /// On one span the functions are polynomials: derivatives against differences of the derivative
    /// below.
    #[test]
    fn higher_derivatives_agree_with_differences() {
        let basis = BSplineBasis::new(3, vec![0., 0., 0., 0., 1., 1., 2.5, 4., 4., 4., 4.]).unwrap();
        let h = 1e-5;
        for order in 1..=3 {
            for x in [0.3, 1.7, 3.2] {
                let (mut low, mut high, mut here) = ([0.0; 4], [0.0; 4], [0.0; 4]);
                basis.derivatives_of(order - 1, x - h, &mut low);
                let first = basis.derivatives_of(order - 1, x + h, &mut high);
                assert_eq!(basis.derivatives_of(order, x, &mut here), first);
                for i in 0..4 {
                    let difference = (high[i] - low[i]) / (2.0 * h);
                    assert!((difference - here[i]).abs() < 1e-6 * here[i].abs().max(1.0), "{order} {x} {i}");
                }
            }
        }
        let mut above = [1.0; 4];
        basis.derivatives_of(4, 0.3, &mut above);
        assert_eq!(above, [0.0; 4]);
    }

    proptest! {
        #[test]
        fn partition_of_unity_and_zero_sum_of_slopes(p in 0usize..5, spans in 1usize..7, x in 0.0f64..=1.0) {
            let basis = BSplineBasis::uniform(p, spans, 0.0, 1.0).unwrap();
            let mut out = vec![0.0; p + 1];
            let first = basis.values(x, &mut out);
            prop_assert!(first + p < basis.size());
            prop_assert!(out.iter().all(|v| *v >= 0.0));
            prop_assert!((out.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            basis.derivatives(x, &mut out);
            prop_assert!(out.iter().sum::<f64>().abs() < 1e-11);
        }
    }
}
