//! Sums over the spectrum that follow from a filter: residuals, norm, trace, bias and predicted
//! mean squared error, with their derivatives.

use std::ops::Range;

use super::filter::Rule;
use flankfit_numerics::{
    lanes::{F64x4, LANES, Lanes},
    with_fma,
};

/// Quantities of a fit that every criterion needs, laid out for repeated summation.
pub(crate) struct Spectral<'a> {
    /// λᵢ ascending, 0 where numerically zero.
    pub lambda: &'a [f64],
    /// σ², where there is one.
    pub variance: Option<f64>,
    /// σ² where it was given, and is no estimate.
    pub given_variance: Option<f64>,
    /// Residual sum of squares of least squares.
    pub rss: f64,
    /// m.
    pub count: usize,
    /// Coefficients outside the filter (the constant of standardised columns).
    pub unpenalised: usize,
    /// Directions before this one are numerically zero and take no part.
    first: usize,
    blocks: Vec<Block>,
    /// Sums over direction i and all above it, for those that a filter leaves alone.
    above: Vec<Above>,
}

/// Four directions' shares in the sums, side by side; directions that take no part have shares 0.
#[derive(Clone, Copy)]
struct Block {
    lambda: [f64; LANES],
    /// aᵢ².
    square: [f64; LANES],
    /// σ²/λᵢ.
    noise: [f64; LANES],
    /// max(aᵢ² − σ²/λᵢ, 0).
    real: [f64; LANES],
    /// 1 where there is a direction.
    ones: [f64; LANES],
}

impl Block {
    const EMPTY: Block = Block {
        lambda: [1.0; LANES],
        square: [0.0; LANES],
        noise: [0.0; LANES],
        real: [0.0; LANES],
        ones: [0.0; LANES],
    };

    /// Only the first `count` directions.
    #[inline(always)]
    fn first(mut self, count: usize) -> Self {
        for k in count..LANES {
            (self.square[k], self.noise[k], self.real[k], self.ones[k]) = (0.0, 0.0, 0.0, 0.0);
        }
        self
    }

    /// Direction `k` four times.
    #[inline(always)]
    fn repeated(&self, k: usize) -> Self {
        Block {
            lambda: [self.lambda[k]; LANES],
            square: [self.square[k]; LANES],
            noise: [self.noise[k]; LANES],
            real: [self.real[k]; LANES],
            ones: [self.ones[k]; LANES],
        }
    }
}

#[derive(Clone, Copy, Default)]
struct Above {
    square: f64,
    noise: f64,
    count: f64,
}

/// Sums over the spectrum at one parameter; derivatives are by ln λ*.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {
    /// `‖Y − X Â_B‖²` and its derivatives.
    pub rss: [f64; 3],
    /// `‖Â_B‖²` and its derivatives.
    pub norm: [f64; 3],
    /// `Σ fᵢ`, unpenalised coefficients counted as 1, and its derivative.
    pub trace: [f64; 2],
    /// `Σ (1−fᵢ)² max(aᵢ² − σ²/λᵢ, 0) + σ² fᵢ²/λᵢ` and its derivative.
    pub mse: [f64; 2],
    /// `‖Â − Â_B‖²`.
    pub bias: f64,
}

/// Sums carried per lane.
const CARRIED: usize = 11;

/// Sums over the touched directions at four parameters, as they were carried:
/// [`Spectral::sums_of`] makes those of one of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SumsAtFour([F64x4; CARRIED]);

impl<'a> Spectral<'a> {
    /// Lays out a problem with coefficients `a` along the directions of `lambda`.
    pub(crate) fn new(
        lambda: &'a [f64],
        a: &[f64],
        variance: Option<f64>,
        rss: f64,
        count: usize,
        unpenalised: usize,
    ) -> Self {
        let n = lambda.len();
        let mut blocks = vec![Block::EMPTY; n.div_ceil(LANES)];
        for (i, (&lambda, &a)) in lambda.iter().zip(a).enumerate().filter(|(_, (lambda, _))| **lambda > 0.0) {
            let (block, k) = (&mut blocks[i / LANES], i % LANES);
            let (square, noise) = (a * a, variance.unwrap_or(0.0) / lambda);
            block.lambda[k] = lambda;
            block.square[k] = square;
            block.noise[k] = noise;
            block.real[k] = (square - noise).max(0.0);
            block.ones[k] = 1.0;
        }
        let mut above = vec![Above::default(); n + 1];
        for i in (0..n).rev() {
            let (block, k, next) = (&blocks[i / LANES], i % LANES, above[i + 1]);
            above[i] = Above {
                square: next.square + block.square[k],
                noise: next.noise + block.noise[k],
                count: next.count + block.ones[k],
            };
        }
        let first = lambda.partition_point(|l| *l <= 0.0);
        Spectral { lambda, variance, given_variance: None, rss, count, unpenalised, first, blocks, above }
    }

    /// The same with a σ that was given.
    pub(crate) fn with_sigma(self, sigma: Option<f64>) -> Self {
        Spectral { given_variance: sigma.map(|sigma| sigma * sigma), ..self }
    }

    /// aᵢ².
    pub(super) fn square(&self, i: usize) -> f64 {
        self.blocks[i / LANES].square[i % LANES]
    }

    /// Directions that `rule` touches at `parameter`.
    fn touched(&self, rule: Rule, parameter: f64) -> Range<usize> {
        let end = match rule {
            Rule::Spectral { count, .. } => self.lambda[..count].partition_point(|l| *l < parameter).max(self.first),
            _ if rule.is_penalty() => self.lambda.len(),
            _ => self.first,
        };
        self.first..end
    }

    /// The sums at λ* (or k) = `parameter`.
    pub(crate) fn sums(&self, rule: Rule, parameter: f64) -> Sums {
        self.sums_touching(rule, parameter, self.touched(rule, parameter))
    }

    /// Stretches of ln λ* between the eigenvalues, with the directions that are touched inside: at
    /// their ends the slope of every sum changes.
    pub(crate) fn stretches(&self, rule: Rule, [low, high]: [f64; 2]) -> Vec<([f64; 2], Range<usize>)> {
        let mut stretches = Vec::new();
        let mut from = low;
        if let Rule::Spectral { count, .. } = rule {
            for (i, &lambda) in self.lambda.iter().enumerate().take(count).skip(self.first + 1) {
                if lambda > from {
                    stretches.push(([from.ln(), lambda.ln()], self.first..i));
                    from = lambda;
                }
            }
            stretches.push(([from.ln(), high.ln()], self.first..count.max(self.first)));
        } else {
            stretches.push(([low.ln(), high.ln()], self.touched(rule, high)));
        }
        stretches
    }

    /// The sums with the touched directions given, so that a stretch's ends can be seen from
    /// inside: four directions at a time. Inlined, so that a caller pays only for the sums that it
    /// reads.
    #[inline(always)]
    pub(crate) fn sums_touching(&self, rule: Rule, parameter: f64, touched: Range<usize>) -> Sums {
        sums_touching(self, rule, parameter, touched)
    }

    /// The same at four parameters side by side.
    pub(crate) fn sums_at_four(&self, rule: Rule, parameters: [f64; LANES], touched: Range<usize>) -> SumsAtFour {
        sums_at_four(self, rule, parameters, touched)
    }

    /// Sums of the parameter in lane `k`, where the directions before `end` were touched. Inlined,
    /// like [`Self::sums_touching`].
    #[inline(always)]
    pub(crate) fn sums_of(&self, SumsAtFour(sums): &SumsAtFour, k: usize, end: usize) -> Sums {
        self.finished(std::array::from_fn(|i| sums[i].as_array()[k]), end)
    }

    /// Adds to the sums over the touched directions what the others (those from `end` on)
    /// contribute.
    #[inline(always)]
    fn finished(&self, sums: [f64; CARRIED], end: usize) -> Sums {
        let [rss0, rss1, rss2, norm0, norm1, norm2, trace0, trace1, mse0, mse1, bias] = sums;
        let rest = self.above[end];
        Sums {
            rss: [self.rss + rss0, -2.0 * rss1, 2.0 * rss2],
            norm: [rest.square + norm0, 2.0 * norm1, 2.0 * norm2],
            trace: [self.unpenalised as f64 + rest.count + trace0, trace1],
            mse: [rest.noise + mse0, 2.0 * mse1],
            bias,
        }
    }

    /// Condition of the regularised matrix at `parameter`; `None` where an eigenvalue stays 0.
    pub(crate) fn condition(&self, rule: Rule, parameter: f64) -> Option<f64> {
        let (mut low, mut high) = (f64::INFINITY, 0.0f64);
        for (i, &lambda) in self.lambda.iter().enumerate() {
            let eigenvalue = rule.at(i, lambda, parameter).eigenvalue;
            low = low.min(eigenvalue);
            high = high.max(eigenvalue);
        }
        let condition = high / low;
        (low > 0.0 && condition.is_finite()).then_some(condition)
    }
}

with_fma! {
    fn sums_touching(problem: &Spectral, rule: Rule, parameter: f64, touched: Range<usize>) -> Sums {
        let (whole, partial) = (touched.end / LANES, touched.end % LANES);
        let last = (partial > 0).then(|| problem.blocks[whole].first(partial));
        let sums = carried(rule, problem.blocks[..whole].iter().copied().chain(last), F64x4::splat(parameter));
        problem.finished(sums.map(Lanes::sum_of_pairs), touched.end)
    }

    fn sums_at_four(problem: &Spectral, rule: Rule, parameters: [f64; LANES], touched: Range<usize>) -> SumsAtFour {
        let directions = touched.map(|i| problem.blocks[i / LANES].repeated(i % LANES));
        SumsAtFour(carried(rule, directions, F64x4::new(parameters)))
    }
}

/// The sums over blocks of directions for the parameters `p`.
#[inline(always)]
fn carried(rule: Rule, blocks: impl Iterator<Item = Block>, p: F64x4) -> [F64x4; CARRIED] {
    let mut sums = [F64x4::ZERO; CARRIED];
    for block in blocks {
        let lambda = F64x4::new(block.lambda);
        let (square, noise) = (F64x4::new(block.square), F64x4::new(block.noise));
        let (real, ones) = (F64x4::new(block.real), F64x4::new(block.ones));
        let (f, g, slope, bend) = rule.at_four(lambda, p);
        let shown = lambda * square;
        let slope2 = slope * slope;
        let (shown_g, square_f, square_g) = (shown * g, square * f, square * g);
        sums[0] = shown_g.mul_add(g, sums[0]);
        sums[1] = shown_g.mul_add(slope, sums[1]);
        sums[2] = shown.mul_add(slope2 - g * bend, sums[2]);
        sums[3] = square_f.mul_add(f, sums[3]);
        sums[4] = square_f.mul_add(slope, sums[4]);
        sums[5] = square.mul_add(f.mul_add(bend, slope2), sums[5]);
        sums[6] = f.mul_add(ones, sums[6]);
        sums[7] = slope.mul_add(ones, sums[7]);
        sums[8] = (g * g).mul_add(real, (noise * f).mul_add(f, sums[8]));
        sums[9] = slope.mul_add(noise * f - g * real, sums[9]);
        sums[10] = square_g.mul_add(g, sums[10]);
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::Scheme;

    const LAMBDA: [f64; 6] = [1e-6, 3e-5, 2e-3, 0.1, 0.7, 2.0];
    const A: [f64; 6] = [30.0, -4.0, 0.5, 1.5, -2.0, 0.3];

    fn rules() -> [Rule; 3] {
        [
            Rule::Ridge,
            Rule::Spectral { scheme: Scheme::FirstOrder, count: 5 },
            Rule::Spectral { scheme: Scheme::Exact, count: 3 },
        ]
    }

    /// The laid-out sums against their definitions, direction by direction.
    #[test]
    fn sums_agree_with_their_definitions() {
        let variance = 1e-5;
        let problem = Spectral::new(&LAMBDA, &A, Some(variance), 0.25, 9, 1);
        for rule in rules() {
            for parameter in [1e-6, 4e-4, 0.3, 7.0] {
                let sums = problem.sums(rule, parameter);
                let (mut rss, mut norm, mut trace, mut mse, mut bias) = (0.25, 0.0, 1.0, 0.0, 0.0);
                for i in 0..6 {
                    let (f, a, noise) = (rule.at(i, LAMBDA[i], parameter).factor, A[i], variance / LAMBDA[i]);
                    rss += LAMBDA[i] * (1.0 - f).powi(2) * a * a;
                    norm += (f * a).powi(2);
                    trace += f;
                    mse += (1.0 - f).powi(2) * (a * a - noise).max(0.0) + noise * f * f;
                    bias += ((1.0 - f) * a).powi(2);
                }
                for (got, want) in [
                    (sums.rss[0], rss),
                    (sums.norm[0], norm),
                    (sums.trace[0], trace),
                    (sums.mse[0], mse),
                    (sums.bias, bias),
                ] {
                    assert!((got - want).abs() <= 1e-12 * want.abs().max(1e-3), "{rule:?} {parameter}: {got} {want}");
                }
            }
        }
    }

    /// Derivatives by ln λ* against central differences.
    #[test]
    fn derivatives_by_the_logarithm() {
        let problem = Spectral::new(&LAMBDA, &A, Some(1e-5), 0.25, 9, 0);
        let h: f64 = 1e-4;
        for rule in rules() {
            for parameter in [4e-4f64, 0.3] {
                let at = |x: f64| problem.sums(rule, parameter * x.exp());
                let (low, here, high) = (at(-h), at(0.0), at(h));
                let close = |low: f64, high: f64, slope: f64| {
                    assert!(((high - low) / (2.0 * h) - slope).abs() <= 1e-6 * slope.abs().max(1.0), "{rule:?}");
                };
                close(low.rss[0], high.rss[0], here.rss[1]);
                close(low.rss[1], high.rss[1], here.rss[2]);
                close(low.norm[0], high.norm[0], here.norm[1]);
                close(low.norm[1], high.norm[1], here.norm[2]);
                close(low.trace[0], high.trace[0], here.trace[1]);
                close(low.mse[0], high.mse[0], here.mse[1]);
            }
        }
    }

    #[test]
    fn an_eigenvalue_above_lambda_star_is_left_alone() {
        for scheme in [Scheme::FirstOrder, Scheme::Exact] {
            let f = Rule::Spectral { scheme, count: 3 }.at(1, 2.0, 1.0);
            assert_eq!((f.factor, f.eigenvalue), (1.0, 2.0));
        }
    }
}
