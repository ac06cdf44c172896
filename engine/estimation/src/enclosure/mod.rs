//! Proved intervals of plain and weighted least squares.
//!
//! # The exact problem
//!
//! Every number is the real number that its double is. Over the counted nodes with heights zₖ and
//! weights wₖ the coefficients minimise `Σ wₖ (zₖ − Σⱼ cⱼ φⱼ(uₖ, vₖ))²`. The φⱼ are the posted
//! columns, or products of functions of u and v: powers `uⁱ`, or Chebyshev or Legendre polynomials
//! of `(2u − low − high)/(high − low)` with the doubles `low` and `high` of the domain. Filters
//! come before: the heights are then the doubles that they left. The solution is rational, and so
//! are the residual sum of squares and the squares of standard errors.
//!
//! # The proof
//!
//! With W the working columns, Ω the weights and S = R⁻¹ as computed (a good S makes intervals
//! short, any S proves them), `c = T⁻¹(c̃ + S M⁻¹ Sᵀ ρ)`, where c̃ is the estimate, ρ = WᵀΩ(z −
//! Wc̃), M = SᵀWᵀΩWS. ρ and M are formed in double-double, with bounds of what rounding leaves
//! ([`rounding`]). Then ‖M − I‖ ≤ η < 1 bounds M⁻¹, and everything after that is arithmetic of
//! intervals ([`Ball`]). `(WᵀΩW)⁻¹ = S M⁻¹ Sᵀ`, and by Pythagoras the residual sum of squares is
//! that of c̃ less `ρᵀ S M⁻¹ Sᵀ ρ`.

mod change;
mod grid;
mod near_identity;
mod nodes;
mod rounding;

use crate::{
    data::{Heights, Nodes},
    problem::{Evidence, LinearProblem},
    result::{Enclosure, NotEnclosed},
};
use flankfit_numerics::{
    Ball, Dd,
    ball::{ROUNDING, enlarged},
};

/// Proved results in the caller's terms.
struct Proved {
    coefficients: Vec<Ball>,
    /// `((XᵀΩX)⁻¹)ⱼⱼ`.
    leverages: Vec<Ball>,
    rss: Ball,
}

/// Encloses the least-squares results of `linear`, whose heights are `heights`. The variance is
/// that of `noise_sigma`, or that of the residuals with their degrees of freedom.
pub(crate) fn enclosure(
    linear: &LinearProblem,
    heights: &Heights,
    noise_sigma: Option<f64>,
    degrees_of_freedom: usize,
) -> Result<Enclosure, NotEnclosed> {
    let Evidence::Posted { sample, nodes } = linear.evidence else { return Err(NotEnclosed::OtherFit) };
    if sample.is_white() || !rounding::is_exact(linear.design) {
        return Err(NotEnclosed::OtherFit);
    }
    let proved = match (&linear.factor.separable, nodes) {
        (Some(separable), Nodes::Grid(grid)) => grid::proved(linear.design, separable, grid, heights),
        _ => nodes::proved(linear, sample, heights),
    };
    proved.and_then(|proved| proved.results(noise_sigma, degrees_of_freedom)).ok_or(NotEnclosed::NotProved)
}

impl Proved {
    /// `None` where ends leave the range of double.
    fn results(&self, noise_sigma: Option<f64>, degrees_of_freedom: usize) -> Option<Enclosure> {
        let variance = match noise_sigma {
            Some(sigma) => Some(Ball::from(sigma) * Ball::from(sigma)),
            None => (degrees_of_freedom > 0).then(|| self.rss.over(degrees_of_freedom as f64)),
        };
        let std_error = |variance: Ball| self.leverages.iter().map(|leverage| root(variance * *leverage)).collect();
        let [low, high] = self.rss.ends();
        let found = Enclosure {
            coefficients: self.coefficients.iter().map(|one| one.ends()).collect(),
            std_errors: variance.map(std_error),
            rss: [low.max(0.0), high],
        };
        let ends = found.coefficients.iter().chain(found.std_errors.iter().flatten()).chain([&found.rss]);
        let sound = ends.flatten().all(|end| end.is_finite());
        sound.then_some(found)
    }
}

/// The roots of numbers that are not negative.
fn root(square: Ball) -> [f64; 2] {
    let [low, high] = square.ends();
    [if low > 0.0 { low.sqrt().next_down() } else { 0.0 }, high.max(0.0).sqrt().next_up()]
}

/// An upper bound of the length of a vector.
fn length(entries: impl Iterator<Item = f64> + Clone) -> f64 {
    let largest = entries.clone().map(f64::abs).fold(0.0, f64::max);
    match largest > 0.0 {
        true => enlarged(entries.map(|x| (x / largest).powi(2)).sum::<f64>().sqrt() * largest),
        false => 0.0,
    }
}

/// `Σ aᵢ bᵢ`.
fn dot(a: &[Ball], b: impl Iterator<Item = Ball>) -> Ball {
    a.iter().zip(b).fold(Ball::ZERO, |sum, (&a, b)| sum + a * b)
}

/// Products with the transposed of an upper triangular matrix, and a bound of the length of what
/// rounding leaves of them.
fn transposed_product(s: &nalgebra::DMatrix<Dd>, x: &[Dd]) -> (Vec<Dd>, f64) {
    let n = x.len();
    let column = |j: usize| &s.as_slice()[j * n..j * n + j + 1];
    let product = |j: usize| column(j).iter().zip(x).fold(Dd::ZERO, |sum, (&s, &x)| sum + s * x);
    let moduli = |j: usize| column(j).iter().zip(x).map(|(s, x)| (s.hi * x.hi).abs()).sum::<f64>();
    let error = (n + 1) as f64 * ROUNDING * length((0..n).map(moduli));
    ((0..n).map(product).collect(), error)
}
