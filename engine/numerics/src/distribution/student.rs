//! Student's t, for any number of degrees of freedom ≥ 1, and the normal distribution as its limit.

use std::{cell::Cell, f64::consts::PI, sync::LazyLock};

use super::{
    beta::{fraction, half_step},
    normal,
};
use crate::quadrature::gauss_legendre;

/// Up to here the continued fraction of the incomplete beta function is quicker than the integral
/// of the density.
const BY_FRACTION: f64 = 100.0;

/// Place above which the tail is 0 in double precision for all degrees of freedom, and whose square
/// is a double.
const BEYOND: f64 = 1e150;

/// Student's t of a number of degrees of freedom.
///
/// ```
/// use flankfit_numerics::distribution::Student;
///
/// let t = Student::new(36.0);
/// // t(0.975; 36), of tables 2.0281
/// assert!((t.upper_quantile(0.025) - 2.028_094_000_980_451).abs() < 1e-14);
/// assert!((t.upper_tail(2.028_094_000_980_451) - 0.025).abs() < 1e-16);
/// // where σ is known
/// assert!((Student::NORMAL.upper_quantile(0.025) - 1.959_963_984_540_054).abs() < 1e-14);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Student {
    freedom: f64,
    /// The density at 0.
    peak: f64,
}

impl Default for Student {
    fn default() -> Self {
        Student::NORMAL
    }
}

impl Student {
    /// The limit of infinitely many degrees of freedom.
    pub const NORMAL: Student = Student { freedom: f64::INFINITY, peak: 0.398_942_280_401_432_7 };

    /// Distribution with `freedom` degrees of freedom, which need not be a whole number; infinity
    /// is the normal distribution.
    pub fn new(freedom: f64) -> Self {
        if freedom == f64::INFINITY {
            return Self::NORMAL;
        }
        Student { freedom, peak: half_step(0.5 * freedom) / (PI * freedom).sqrt() }
    }

    /// The number of degrees of freedom; infinity for the normal distribution.
    pub fn freedom(&self) -> f64 {
        self.freedom
    }

    /// The density.
    pub fn density(&self, t: f64) -> f64 {
        self.peak * libm::exp(-self.exponent(t))
    }

    /// `(1 + t²/ν)^(−(ν + more)/2)`; e^(−t²/2) for the normal distribution.
    pub fn power(&self, t: f64, more: f64) -> f64 {
        if self.freedom == f64::INFINITY {
            return libm::exp(-0.5 * t * t);
        }
        libm::exp(-0.5 * (self.freedom + more) * libm::log1p(t * t / self.freedom))
    }

    /// `√(2/ν) Γ((ν+1)/2) / Γ(ν/2)`; 1 for the normal distribution.
    pub fn mean_ratio(&self) -> f64 {
        (2.0 * PI).sqrt() * self.peak
    }

    /// −ln of the density over that at 0.
    fn exponent(&self, t: f64) -> f64 {
        if self.freedom == f64::INFINITY {
            return 0.5 * t * t;
        }
        0.5 * (self.freedom + 1.0) * libm::log1p(t * t / self.freedom)
    }

    /// P(T > t).
    pub fn upper_tail(&self, t: f64) -> f64 {
        if t < 0.0 {
            return 1.0 - self.upper_tail(-t);
        }
        if t > BEYOND {
            return 0.0;
        }
        if self.freedom == f64::INFINITY {
            return normal::upper_tail(t);
        }
        if self.freedom > BY_FRACTION {
            return self.integral_from(t);
        }
        // half of I_x(ν/2, ½), x = ν / (ν + t²)
        let (p, square) = (0.5 * self.freedom, t * t);
        if !(square > 0.0) {
            return 0.5;
        }
        let whole = self.freedom + square;
        let (x, y) = (self.freedom / whole, square / whole);
        let front = half_step(p) * libm::exp(-p * libm::log1p(square / self.freedom)) * (y / PI).sqrt();
        if x > (p + 1.0) / (p + 2.5) {
            0.5 - front * fraction(y, 0.5, p)
        } else {
            0.5 * front * fraction(x, p, 0.5) / p
        }
    }

    /// ∫ of the density from t ≥ 0 on, by Gauss's formula as far as the density is more than e⁻⁴⁰
    /// of that at t: everything that follows.
    fn integral_from(&self, t: f64) -> f64 {
        static RULE: LazyLock<Vec<(f64, f64)>> =
            LazyLock::new(|| gauss_legendre(48).iter().map(|(x, w)| (x.to_f64(), w.to_f64())).collect());
        let growth = libm::expm1(80.0 / (self.freedom + 1.0));
        // the last place is √(t² + (ν + t²) growth); its distance from t, without cancellation
        let far = (self.freedom + t * t) * growth;
        let half = 0.5 * far / ((t * t + far).sqrt() + t);
        half * RULE.iter().map(|&(x, w)| w * self.density(t + half * (1.0 + x))).sum::<f64>()
    }

    /// t with P(T > t) = `tail`, 0 < tail < 1.
    pub fn upper_quantile(&self, tail: f64) -> f64 {
        if tail > 0.5 {
            return -self.upper_quantile(1.0 - tail);
        }
        let n = self.freedom;
        if n == f64::INFINITY {
            return normal::upper_quantile(tail);
        }
        if n == 1.0 {
            return 1.0 / libm::tan(PI * tail);
        }
        if n == 2.0 {
            return (1.0 - 2.0 * tail) / (2.0 * tail * (1.0 - tail)).sqrt();
        }
        recently(n, tail, || self.searched(tail))
    }

    /// The quantile where there is no formula, `tail` at most 0.5.
    fn searched(&self, tail: f64) -> f64 {
        let n = self.freedom;
        let mut t = self.start(tail);
        for _ in 0..8 {
            // the third order, as the density's slope is −t (ν + 1) / (ν + t²) of itself
            let step = (self.upper_tail(t) - tail) / self.density(t);
            let curved = 0.5 * step * t * (n + 1.0) / (n + t * t);
            let next = t + step / (1.0 - curved.clamp(-0.5, 0.5));
            let moved = (next - t).abs();
            t = next.max(0.0);
            // what is left is the third power of this step
            if moved <= 1e-6 * t || moved < 1e-16 {
                break;
            }
        }
        t
    }

    /// Hill's approximation (Algorithm 396 of the ACM, 1970), right to six digits mostly.
    fn start(&self, tail: f64) -> f64 {
        let n = self.freedom;
        let a = 1.0 / (n - 0.5);
        let b = 48.0 / (a * a);
        let mut c = ((20_700.0 * a / b - 98.0) * a - 16.0) * a + 96.36;
        let d = ((94.5 / (b + c) - 3.0) / b + 1.0) * (0.5 * PI * a).sqrt() * n;
        let x = d * 2.0 * tail;
        let mut y = libm::exp(2.0 / n * libm::log(x));
        if y > 0.05 + a {
            let x = -normal::upper_quantile(tail);
            y = x * x;
            if n < 5.0 {
                c += 0.3 * (n - 4.5) * (x + 0.6);
            }
            c += (((0.05 * d * x - 5.0) * x - 7.0) * x - 2.0) * x + b;
            y = (((((0.4 * y + 6.3) * y + 36.0) * y + 94.5) / c - y - 3.0) / b + 1.0) * x;
            y = libm::expm1(a * y * y);
        } else {
            y = ((1.0 / (((n + 6.0) / (n * y) - 0.089 * d - 0.822) * (n + 2.0) * 3.0) + 0.5 / (n + 4.0)) * y - 1.0)
                * (n + 1.0)
                / (n + 2.0)
                + 1.0 / y;
        }
        (n * y).sqrt()
    }
}

/// Degrees of freedom, tail, and the quantile that was found for them.
type Remembered = (f64, f64, f64);

/// Returns the result of `search`, or a recent one on this thread: consecutive fits mostly have the
/// same nodes and level, and a search takes some per cent of the time of a small fit.
fn recently(freedom: f64, tail: f64, search: impl FnOnce() -> f64) -> f64 {
    thread_local! {
        static FOUND: Cell<[Remembered; 4]> = const { Cell::new([(0.0, 0.0, 0.0); 4]) };
    }
    let mut found = FOUND.get();
    if let Some((.., quantile)) = found.iter().find(|(n, p, _)| (*n, *p) == (freedom, tail)) {
        return *quantile;
    }
    let quantile = search();
    found.rotate_right(1);
    found[0] = (freedom, tail, quantile);
    FOUND.set(found);
    quantile
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn cached_quantiles_equal_searched_ones() {
        for round in 0..3 {
            for k in 0..7 {
                let (student, tail) = (Student::new(3.0 + f64::from(k % 5)), 0.025 / f64::from(1 + k % 2));
                assert_eq!(student.upper_quantile(tail), student.searched(tail), "{round} {k}");
            }
        }
    }

    /// Reference values of mpmath with 40 digits.
    #[test]
    fn tails_of_mpmath() {
        for (t, freedom, want) in [
            (0.1, 1.0, 0.468_274_482_569_446_4),
            (2.0, 1.0, 0.147_583_617_650_433_26),
            (0.2, 2.5, 0.428_304_842_014_512_74),
            (0.5, 3.0, 0.325_723_982_424_075_5),
            (4.0, 3.0, 0.014_004_228_005_073_083),
            (0.3, 36.0, 0.382_951_326_832_991_2),
            (12.0, 36.0, 1.922_754_944_598_956_2e-14),
            (1.3, 99.5, 0.098_302_220_545_459_45),
            (0.7, 101.0, 0.242_768_272_459_990_1),
            (2.5, 101.0, 0.007_014_660_676_282_063),
            (9.0, 101.0, 7.128_227_725_188_83e-15),
            (0.01, 1000.0, 0.496_011_640_966_093_6),
            (1.96, 1000.0, 0.025_136_592_477_874_357),
            (6.0, 1000.0, 1.377_684_586_688_734_5e-9),
            (3.1, 1e6, 0.000_967_630_075_662_040_8),
        ] {
            let found = Student::new(freedom).upper_tail(t);
            assert!((found / want - 1.0).abs() < 5e-14, "{t} of {freedom}: {found:e} is not {want:e}");
        }
    }

    #[test]
    fn quantiles_of_mpmath() {
        for (tail, freedom, want) in [
            (0.025, 1.0, 12.706_204_736_174_705),
            (0.025, 2.0, 4.302_652_729_749_464),
            (0.025, 3.0, 3.182_446_305_283_709_5),
            (0.005, 4.5, 4.272_823_993_011_293),
            (0.025, 5.0, 2.570_581_835_636_315_5),
            (1e-6, 10.0, 9.751_995_490_940_58),
            (0.0005, 36.0, 3.582_149_701_456_337),
            (0.025, 36.0, 2.028_094_000_980_451),
            (0.3, 36.0, 0.529_076_148_504_535),
            (0.025, 101.0, 1.983_731_002_955_606_1),
            (0.025, 1000.0, 1.962_339_080_826_408_5),
            (1e-7, 1000.0, 5.235_998_469_292_347),
            (0.025, 1e6, 1.959_966_356_814_107),
        ] {
            let found = Student::new(freedom).upper_quantile(tail);
            assert!((found / want - 1.0).abs() < 1e-14, "{tail} of {freedom}: {found} is not {want}");
        }
    }

    proptest! {
        #[test]
        fn the_quantile_has_the_tail(tail in -12.0..-0.31f64, freedom in 0.0..7.0f64) {
            let (tail, t) = (10f64.powf(tail), Student::new(10f64.powf(freedom)));
            let found = t.upper_quantile(tail);
            prop_assert!((t.upper_tail(found) / tail - 1.0).abs() < 1e-12, "{} {tail} {found}", t.freedom());
        }

        #[test]
        fn tails_join_where_the_method_changes(t in 0.0..10.0f64) {
            let (low, high) = (Student::new(100.0), Student::new(100.0f64.next_up()));
            prop_assert!((low.upper_tail(t) / high.upper_tail(t) - 1.0).abs() < 1e-13);
        }
    }
}
