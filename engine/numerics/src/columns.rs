//! Inner loops over columns, which are slices of lanes.

use super::{
    lanes::{Laned, Lanes},
    with_fma,
};

with_fma! {
    /// The scalar product of two columns of equal length.
    pub fn dot<T: Laned>(x: &[T::Lanes], y: &[T::Lanes]) -> T {
        let mut even = T::Lanes::ZERO;
        let mut odd = T::Lanes::ZERO;
        let (x_pairs, x_rest) = x.as_chunks::<2>();
        let (y_pairs, y_rest) = y.as_chunks::<2>();
        for (x, y) in x_pairs.iter().zip(y_pairs) {
            even = even.accumulate_late(x[0], y[0]);
            odd = odd.accumulate_late(x[1], y[1]);
        }
        if let ([x], [y]) = (x_rest, y_rest) {
            even = even.accumulate_late(*x, *y);
        }
        even.join(odd).settled().sum_of_halves()
    }

    /// `y += factor * x`.
    pub fn axpy<T: Laned>(factor: T, x: &[T::Lanes], y: &mut [T::Lanes]) {
        for (x, y) in x.iter().zip(y) {
            *y = y.add_scaled(factor, *x);
        }
    }

    /// `x <- x + t y` and `y <- y - t x`: the plane rotation by `atan t` without its common factor
    /// `cos`.
    pub fn shear<T: Laned>(t: f64, x: &mut [T::Lanes], y: &mut [T::Lanes]) {
        for (x, y) in x.iter_mut().zip(y) {
            let old = *x;
            *x = old.add_scaled_f64(t, *y);
            *y = y.add_scaled_f64(-t, old);
        }
    }

    /// The plane rotation `x <- c (x + t y)`, `y <- c (y - t x)`. Equal columns and `t = 1` leave
    /// exact zeros in `y`.
    pub fn rotate<T: Laned>(t: f64, c: T, x: &mut [T::Lanes], y: &mut [T::Lanes]) {
        let c = T::Lanes::splat(c);
        for (x, y) in x.iter_mut().zip(y) {
            let old = *x;
            *x = old.add_scaled_f64(t, *y).mul(c);
            *y = y.add_scaled_f64(-t, old).mul(c);
        }
    }
}
