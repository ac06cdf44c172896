//! Loss functions of M-estimators, of `u = r/s` (pure number): ρ(u), its derivative ψ, the weight
//! ψ(u)/u, and ψ′.
//!
//! All are scaled so that ρ(u) ≈ u²/2 and weight 1 near 0; tuning constants are in units of the
//! scale and, by default, give 95 % efficiency at normal errors (Hampel's 2, 4, 8 more).

use std::f64::consts::PI;

/// A loss with its tuning constants.
///
/// ```
/// use flankfit_estimation::spec::Loss;
///
/// // A residual of 2.69 scales is twice Huber's k: it has half the weight.
/// assert_eq!(Loss::HUBER.weight(2.69), 0.5);
/// assert_eq!(Loss::HUBER.psi(2.69), 1.345);
/// // Tukey's biweight leaves it out above 4.685 scales.
/// assert_eq!(Loss::TUKEY.weight(5.0), 0.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Loss {
    /// Huber (1964): ρ = u²/2 for |u| ≤ k, else k|u| − k²/2; ψ = max(−k, min(k, u)); weight min(1,
    /// k/|u|). Convex.
    Huber {
        /// Residuals up to k scales count by their squares.
        k: f64,
    },
    /// Tukey's biweight (Beaton and Tukey 1974): ρ = c²/6·(1 − (1 − (u/c)²)³) up to c, then c²/6; ψ
    /// = u(1 − (u/c)²)²; weight (1 − (u/c)²)², 0 above c.
    Tukey {
        /// Residuals above c scales have weight 0.
        c: f64,
    },
    /// Hampel (1974), three parts: ψ = u up to a, a·sign(u) up to b, falling to 0 at c; ρ ends at
    /// a(b + c − a)/2.
    Hampel {
        /// End of the part where ψ = u.
        a: f64,
        /// End of the part where ψ is constant.
        b: f64,
        /// Beyond c scales the weight is 0.
        c: f64,
    },
    /// Andrews' sine (1974): ρ = a²(1 − cos(u/a)), ψ = a·sin(u/a), weight sin(u/a)/(u/a) up to aπ;
    /// then 2a², 0, 0.
    Andrews {
        /// Residuals above aπ scales have weight 0.
        a: f64,
    },
}

impl Loss {
    /// Huber with k = 1.345.
    pub const HUBER: Loss = Loss::Huber { k: 1.345 };
    /// Tukey's biweight with c = 4.685.
    pub const TUKEY: Loss = Loss::Tukey { c: 4.685 };
    /// Hampel with 2, 4, 8.
    pub const HAMPEL: Loss = Loss::Hampel { a: 2.0, b: 4.0, c: 8.0 };
    /// Andrews with a = 1.339.
    pub const ANDREWS: Loss = Loss::Andrews { a: 1.339 };

    /// True if the tuning constants are the usual ones.
    pub fn is_usual(self) -> bool {
        [Self::HUBER, Self::TUKEY, Self::HAMPEL, Self::ANDREWS].contains(&self)
    }

    /// ρ(u).
    pub fn rho(self, u: f64) -> f64 {
        let x = u.abs();
        match self {
            Loss::Huber { k } => {
                if x <= k {
                    0.5 * x * x
                } else {
                    k * (x - 0.5 * k)
                }
            }
            Loss::Tukey { c } => {
                let left = (1.0 - (x / c) * (x / c)).max(0.0);
                c * c / 6.0 * (1.0 - left * left * left)
            }
            Loss::Hampel { a, b, c } => {
                if x <= a {
                    0.5 * x * x
                } else if x <= b {
                    a * (x - 0.5 * a)
                } else {
                    let left = (c - x).max(0.0);
                    0.5 * a * (b + c - a) - if c > b { 0.5 * a * left * left / (c - b) } else { 0.0 }
                }
            }
            // 1 − cos t = 2 sin²(t/2), which does not cancel
            Loss::Andrews { a } => 2.0 * a * a * (0.5 * (x / a).min(PI)).sin().powi(2),
        }
    }

    /// ψ(u)/u, which is 1 at 0.
    pub fn weight(self, u: f64) -> f64 {
        let x = u.abs();
        match self {
            Loss::Huber { k } => {
                if x <= k {
                    1.0
                } else {
                    k / x
                }
            }
            Loss::Tukey { c } => (1.0 - (x / c) * (x / c)).max(0.0).powi(2),
            Loss::Hampel { a, b, c } => {
                if x <= a {
                    1.0
                } else if x <= b {
                    a / x
                } else if x < c {
                    a * (c - x) / ((c - b) * x)
                } else {
                    0.0
                }
            }
            Loss::Andrews { a } => {
                let t = x / a;
                if t < 1e-9 {
                    1.0
                } else if t < PI {
                    t.sin() / t
                } else {
                    0.0
                }
            }
        }
    }

    /// ψ(u).
    pub fn psi(self, u: f64) -> f64 {
        u * self.weight(u)
    }

    /// ψ′(u), from the inside at kinks.
    pub fn psi_slope(self, u: f64) -> f64 {
        let x = u.abs();
        match self {
            Loss::Huber { k } => f64::from(u8::from(x <= k)),
            Loss::Tukey { c } => {
                let t = (x / c) * (x / c);
                if t < 1.0 { (1.0 - t) * (1.0 - 5.0 * t) } else { 0.0 }
            }
            Loss::Hampel { a, b, c } => {
                if x <= a {
                    1.0
                } else if x <= b || x > c {
                    0.0
                } else {
                    -a / (c - b)
                }
            }
            Loss::Andrews { a } => {
                let t = x / a;
                if t < PI { t.cos() } else { 0.0 }
            }
        }
    }

    /// True if ρ is convex, so that no start can lead astray.
    pub fn is_convex(self) -> bool {
        matches!(self, Loss::Huber { .. })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn psi_is_the_slope_of_rho_and_psi_slope_that_of_psi() {
        for loss in [Loss::HUBER, Loss::TUKEY, Loss::HAMPEL, Loss::ANDREWS] {
            for i in 0..200 {
                let u = -10.05 + 0.1 * f64::from(i);
                let h = 1e-6;
                let slope = (loss.rho(u + h) - loss.rho(u - h)) / (2.0 * h);
                assert!((slope - loss.psi(u)).abs() < 1e-6, "{loss:?} ψ({u})");
                let curvature = (loss.psi(u + h) - loss.psi(u - h)) / (2.0 * h);
                assert!((curvature - loss.psi_slope(u)).abs() < 1e-4, "{loss:?} ψ′({u})");
                assert!((0.0..=1.0).contains(&loss.weight(u)));
                assert_eq!(loss.rho(u), loss.rho(-u));
            }
            assert_eq!((loss.rho(0.0), loss.weight(0.0), loss.psi_slope(0.0)), (0.0, 1.0, 1.0));
        }
    }

    #[test]
    fn rho_far_out_agrees_with_the_literature() {
        assert_eq!(Loss::HUBER.rho(10.0), 1.345 * (10.0 - 0.6725));
        assert!((Loss::TUKEY.rho(50.0) - 4.685f64.powi(2) / 6.0).abs() < 1e-14);
        assert_eq!(Loss::HAMPEL.rho(50.0), 10.0);
        assert!((Loss::ANDREWS.rho(50.0) - 2.0 * 1.339f64.powi(2)).abs() < 1e-14);
    }
}
