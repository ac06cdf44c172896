//! Derivatives of ln Γ.

/// From here on the asymptotic series have no error left in double precision.
const FAR: f64 = 12.0;

/// ψ(x), the derivative of ln Γ, for x > 0.
///
/// ```
/// use flankfit_numerics::distribution::gamma::digamma;
///
/// // −γ, Euler's constant
/// assert!((digamma(1.0) + 0.577_215_664_901_532_9).abs() < 1e-15);
/// ```
pub fn digamma(mut x: f64) -> f64 {
    let mut below = 0.0;
    while x < FAR {
        below += 1.0 / x;
        x += 1.0;
    }
    let q = 1.0 / (x * x);
    let series = q
        * (1.0 / 12.0
            - q * (1.0 / 120.0
                - q * (1.0 / 252.0 - q * (1.0 / 240.0 - q * (1.0 / 132.0 - q * (691.0 / 32_760.0 - q / 12.0))))));
    libm::log(x) - 0.5 / x - series - below
}

/// ψ′(x), for x > 0.
///
/// ```
/// use flankfit_numerics::distribution::gamma::trigamma;
///
/// // π²/6
/// assert!((trigamma(1.0) - 1.644_934_066_848_226_4).abs() < 1e-14);
/// ```
pub fn trigamma(mut x: f64) -> f64 {
    let mut below = 0.0;
    while x < FAR {
        below += 1.0 / (x * x);
        x += 1.0;
    }
    let q = 1.0 / (x * x);
    let series = q
        * (1.0 / 6.0
            - q * (1.0 / 30.0
                - q * (1.0 / 42.0 - q * (1.0 / 30.0 - q * (5.0 / 66.0 - q * (691.0 / 2730.0 - q * 7.0 / 6.0))))));
    (1.0 + series + 0.5 / x) / x + below
}

#[cfg(test)]
mod tests {
    use super::*;

    /// mpmath 1.3, 30 digits: `psi(0, x)`, `psi(1, x)`.
    #[test]
    fn values_of_mpmath() {
        for (x, first, second) in [
            (0.125, -8.388492663295855, 65.38813344498803),
            (0.5, -1.9635100260214235, 4.934802200544679),
            (1.25, -0.22745353337626542, 1.1973291545071107),
            (3.0, 0.9227843350984671, 0.39493406684822646),
            (7.5, 1.9467574842460869, 0.1426158966967038),
            (11.75, 2.4206968934226323, 0.08883052207962387),
            (40.0, 3.676327374034843, 0.02531510384129103),
            (1000.0, 6.907255195648812, 0.0010005001666666333),
        ] {
            assert!((digamma(x) - first).abs() <= 4e-15 * first.abs().max(1.0), "{x}: {}", digamma(x));
            assert!((trigamma(x) / second - 1.0).abs() <= 4e-15, "{x}: {}", trigamma(x));
        }
    }
}
