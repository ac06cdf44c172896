//! The affine map of an axis onto [-1, 1].

use flankfit_numerics::{Dd, Real};

/// `t = (x − center) · scale`. Both numbers are doubles and taken as exact: whoever maps and
/// whoever changes the basis uses the same two numbers, so that the rounding of the map is no error
/// at all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mapping {
    /// Centre of the axis, which maps onto 0.
    pub center: f64,
    /// Factor from the axis to [-1, 1]: one over half its width.
    pub scale: f64,
}

impl Mapping {
    /// Maps `[low, high]` onto [-1, 1] (to rounding). A box of zero width, or one too narrow for
    /// its reciprocal to be a double, gets scale 1.
    ///
    /// ```
    /// use flankfit_geometry::Mapping;
    ///
    /// // 33 lies half-way between the middle (32) and the upper end (34).
    /// assert_eq!(Mapping::over(30.0, 34.0).map::<f64>(33.0), 0.5);
    /// ```
    pub fn over(low: f64, high: f64) -> Self {
        let half = 0.5 * high - 0.5 * low;
        let scale = 1.0 / half;
        let scale = if half > 0.0 && scale.is_finite() && scale > 0.0 { scale } else { 1.0 };
        Mapping { center: 0.5 * low + 0.5 * high, scale }
    }

    /// The mapped value of `x`, exact up to the precision of `T`.
    #[inline(always)]
    pub fn map<T: Real>(&self, x: f64) -> T {
        T::of_dd(Dd::diff(x, self.center)).mul_f64(self.scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_of_the_box_map_to_plus_and_minus_one() {
        let map = Mapping::over(30.0, 34.0);
        assert_eq!(map.map::<f64>(30.0), -1.0);
        assert_eq!(map.map::<f64>(34.0), 1.0);
        assert_eq!(Mapping::over(5.0, 5.0).map::<f64>(5.0), 0.0);
    }
}
