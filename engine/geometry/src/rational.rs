//! The denominator of a rational B-spline basis, `Rᵢⱼ = wᵢⱼ NᵢNⱼ / W` with `W(u, v) = Σ wᵢⱼ Nᵢ(u)
//! Nⱼ(v)` (Eq. 9).
//!
//! A curve has one row of weights along u and the single function 1 along v. Who fits with given
//! weights computes in `NᵢNⱼ / W`, from which `Rᵢⱼ` differs by the factor wᵢⱼ alone.

use crate::space::in_rows;
use flankfit_numerics::{Real, check::Faults, words::Shown};

/// Largest ratio of two weights.
const WIDEST: f64 = 1e12;

/// A checked net of positive weights, the last axis running fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct WeightNet {
    weights: Vec<f64>,
    columns: usize,
}

impl WeightNet {
    /// Checks weights for `rows × columns` control points; a fault is placed in their list, or in
    /// their rows of a `surface`.
    pub fn new(weights: Vec<f64>, rows: usize, columns: usize, surface: bool) -> Result<Self, Faults> {
        let wanted = rows * columns;
        if weights.len() != wanted {
            return Err(Faults::one("", format_args!("{} weights for {wanted} control points", weights.len())));
        }
        if let Some(index) = weights.iter().position(|w| !(w.is_finite() && *w > 0.0)) {
            let place = if surface { in_rows(columns)(index) } else { format!("[{index}]") };
            return Err(Faults::one(
                place,
                format_args!(
                    "the weight {} is not a finite number greater than 0, so its control point is undetermined",
                    Shown(weights[index])
                ),
            ));
        }
        let (least, largest) = weights.iter().fold((f64::INFINITY, 0.0f64), |(a, b), w| (a.min(*w), b.max(*w)));
        if !(largest / least <= WIDEST) {
            let (least, largest) = (Shown(least), Shown(largest));
            let message = format_args!("weights from {least} to {largest} are too far apart for double precision");
            return Err(Faults::one("", message));
        }
        Ok(WeightNet { weights, columns })
    }

    /// The weights, row by row.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Whether weights differ along rows (u), and along columns (v): where they do not, W is
    /// constant that way.
    ///
    /// ```
    /// use flankfit_geometry::WeightNet;
    ///
    /// // Two rows (u) of two columns (v): weights differ along u alone.
    /// let net = WeightNet::new(vec![1.0, 1.0, 2.0, 2.0], 2, 2, true)?;
    /// assert_eq!(net.varies(), [true, false]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn varies(&self) -> [bool; 2] {
        let rows = || self.weights.chunks_exact(self.columns.max(1));
        let along_u = rows().zip(rows().skip(1)).any(|(one, next)| one != next);
        let along_v = rows().any(|row| row.windows(2).any(|pair| pair[0] != pair[1]));
        [along_u, along_v]
    }

    /// Largest over least weight.
    pub fn spread(&self) -> f64 {
        let (least, largest) = self.weights.iter().fold((f64::INFINITY, 0.0f64), |(a, b), w| (a.min(*w), b.max(*w)));
        largest / least
    }

    /// `Σ wᵢⱼ u[i] v[j]` for functions, or derivatives of functions, along the axes; zeros cost
    /// nothing.
    pub fn sum<T: Real>(&self, u: &[T], v: &[T]) -> T {
        let zero = T::of(0.0);
        let mut total = zero;
        for (row, &along) in self.weights.chunks_exact(self.columns).zip(u) {
            if along == zero {
                continue;
            }
            let mut sum = zero;
            for (&weight, &across) in row.iter().zip(v) {
                if across != zero {
                    sum += across.mul_f64(weight);
                }
            }
            total += along * sum;
        }
        total
    }

    /// Calls `each(column, ∂u, ∂v)` with the slopes of every `NᵢNⱼ / W` that is not 0 around; `u`
    /// and `v` hold values and first derivatives along the axes.
    pub fn slopes(&self, u: [&[f64]; 2], v: [&[f64]; 2], mut each: impl FnMut(usize, f64, f64)) {
        let whole = self.sum(u[0], v[0]);
        let (along_u, along_v) = (self.sum(u[1], v[0]) / whole, self.sum(u[0], v[1]) / whole);
        for i in 0..u[0].len() {
            if u[0][i] == 0.0 && u[1][i] == 0.0 {
                continue;
            }
            for j in 0..v[0].len() {
                let value = u[0][i] * v[0][j];
                let slope_u = (u[1][i] * v[0][j] - value * along_u) / whole;
                let slope_v = (u[0][i] * v[1][j] - value * along_v) / whole;
                if slope_u != 0.0 || slope_v != 0.0 {
                    each(i * self.columns + j, slope_u, slope_v);
                }
            }
        }
    }
}

/// Derivatives of order 0 to `order` (at most 3) of n / w from those of n and of w, by Leibniz'
/// rule.
pub fn quotient<T: Real>(order: usize, n: [T; 4], w: [T; 4]) -> [T; 4] {
    const BINOMIAL: [[f64; 4]; 4] =
        [[1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [1.0, 2.0, 1.0, 0.0], [1.0, 3.0, 3.0, 1.0]];
    let mut out = [T::of(0.0); 4];
    for k in 0..=order.min(3) {
        let mut left = n[k];
        for a in 1..=k {
            left -= (w[a] * out[k - a]).mul_f64(BINOMIAL[k][a]);
        }
        out[k] = left / w[0];
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refused_weights() {
        let message = |weights: &[f64], rows, columns| {
            WeightNet::new(weights.to_vec(), rows, columns, false).unwrap_err().to_string()
        };
        assert_eq!(message(&[1.0; 3], 2, 2), "3 weights for 4 control points");
        assert!(message(&[1.0, 0.0], 2, 1).starts_with("[1]: the weight 0 is not"));
        assert!(message(&[1.0, f64::NAN], 1, 2).starts_with("[1]: the weight NaN is not"));
        assert!(message(&[1e-7, 1e7], 1, 2).contains("too far apart"));
    }

    /// 1 / (1 + x) = n / w with n = 1: derivatives (−1)ᵏ k! / (1 + x)ᵏ⁺¹.
    #[test]
    fn derivatives_of_a_quotient() {
        let x = 0.5f64;
        let got = quotient(3, [1.0, 0.0, 0.0, 0.0], [1.0 + x, 1.0, 0.0, 0.0]);
        let truth = [1.0 / 1.5, -1.0 / 1.5f64.powi(2), 2.0 / 1.5f64.powi(3), -6.0 / 1.5f64.powi(4)];
        assert!(got.iter().zip(truth).all(|(a, b)| (a - b).abs() < 1e-15), "{got:?}");
    }

    #[test]
    fn slopes_agree_with_differences() {
        let net = WeightNet::new(vec![1.0, 2.0, 0.5, 3.0], 2, 2, true).unwrap();
        let hat = |x: f64| [1.0 - x, x];
        let value = |x: f64, y: f64, k: usize| hat(x)[k / 2] * hat(y)[k % 2] / net.sum(&hat(x), &hat(y));
        let (x, y, h) = (0.3, 0.6, 1e-6);
        net.slopes([&hat(x), &[-1.0, 1.0]], [&hat(y), &[-1.0, 1.0]], |k, su, sv| {
            assert!((su - (value(x + h, y, k) - value(x - h, y, k)) / (2.0 * h)).abs() < 1e-9);
            assert!((sv - (value(x, y + h, k) - value(x, y - h, k)) / (2.0 * h)).abs() < 1e-9);
        });
    }
}
