//! The spectrum of a scaled measurement matrix, and every sum over it that the criteria and bounds
//! are made of, by their definitions.

use super::big::Big;
use super::matrix::{Rows, column, dot, eigen, gram, times};

/// Scaling of the columns before the eigen analysis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Columns {
    UnitLength,
    AsTheyAre,
    /// Centred, divided by their standard deviation; the given column is the constant.
    Standardized(usize),
}

/// The spectrum in the oracle's numbers.
pub struct Spectrum {
    /// Ascending.
    pub eigenvalues: Vec<Big>,
    /// Unit vectors in the scaled columns.
    pub vectors: Vec<Vec<Big>>,
    /// Components of the least-squares estimate along the vectors.
    pub components: Vec<Big>,
    /// Lengths by which the columns were divided (1 for a constant left alone).
    pub scales: Vec<Big>,
    /// The scaled matrix, rows multiplied by √weight.
    pub scaled: Rows,
    /// Least-squares residual sum of squares.
    pub rss: Big,
    columns: Columns,
    centres: Vec<Big>,
    height: Big,
    total_weight: Big,
}

impl Spectrum {
    /// Nodes of weight 0 must have been left out already.
    pub fn new(x: &Rows, y: &[Big], weight: Option<&[f64]>, columns: Columns) -> Self {
        let roots: Vec<Big> = match weight {
            Some(weight) => weight.iter().map(|w| Big::from(*w).sqrt()).collect(),
            None => vec![Big::one(); y.len()],
        };
        let total_weight = dot(&roots, &roots);
        let mean = |values: &[Big]| {
            let sum = values.iter().zip(&roots).fold(Big::zero(), |s, (v, r)| &s + &(&(v * r) * r));
            &sum / &total_weight
        };
        let n = x[0].len();
        let penalised: Vec<usize> = (0..n).filter(|j| columns != Columns::Standardized(*j)).collect();
        let centred = matches!(columns, Columns::Standardized(_));
        let (mut scaled_columns, mut scales, mut centres) = (Vec::new(), Vec::new(), Vec::new());
        for j in &penalised {
            let values = column(x, *j);
            let centre = if centred { mean(&values) } else { Big::zero() };
            let weighted: Vec<Big> = values.iter().zip(&roots).map(|(v, r)| &(v - &centre) * r).collect();
            let length = dot(&weighted, &weighted).sqrt();
            let scale = match columns {
                Columns::UnitLength => length,
                Columns::AsTheyAre => Big::one(),
                Columns::Standardized(_) => &length / &total_weight.sqrt(),
            };
            scaled_columns.push(weighted.iter().map(|v| v / &scale).collect::<Vec<Big>>());
            scales.push(scale);
            centres.push(centre);
        }
        let height = if centred { mean(y) } else { Big::zero() };
        let y: Vec<Big> = y.iter().zip(&roots).map(|(y, r)| &(y - &height) * r).collect();
        let scaled: Rows =
            (0..y.len()).map(|k| scaled_columns.iter().map(|column| column[k].clone()).collect()).collect();
        let (eigenvalues, vectors) = eigen(&gram(&scaled));
        let moments: Vec<Big> = scaled_columns.iter().map(|column| dot(column, &y)).collect();
        let components: Vec<Big> = eigenvalues.iter().zip(&vectors).map(|(l, v)| &dot(v, &moments) / l).collect();
        let estimate = combine(&vectors, &components);
        let residuals: Vec<Big> = times(&scaled, &estimate).iter().zip(&y).map(|(f, y)| y - f).collect();
        let rss = dot(&residuals, &residuals);
        Spectrum { eigenvalues, vectors, components, scales, scaled, rss, columns, centres, height, total_weight }
    }

    /// The filtered estimate Σ fᵢ aᵢ Vᵢ in the scaled columns.
    pub fn filtered(&self, factors: &[f64]) -> Vec<Big> {
        let parts: Vec<Big> = self.components.iter().zip(factors).map(|(a, f)| a * &Big::from(*f)).collect();
        combine(&self.vectors, &parts)
    }

    /// The same in the caller's columns. (A centred fit assumes that the constant column is 1.)
    pub fn coefficients(&self, factors: &[f64]) -> Vec<Big> {
        let mut own: Vec<Big> = self.filtered(factors).iter().zip(&self.scales).map(|(b, s)| b / s).collect();
        if let Columns::Standardized(constant) = self.columns {
            own.insert(constant, &self.height - &dot(&own, &self.centres));
        }
        own
    }

    /// The part of it that double precision can carry.
    pub fn sums(&self) -> Sums {
        let doubles = |values: &[Big]| values.iter().map(Big::to_f64).collect::<Vec<f64>>();
        Sums {
            lambda: doubles(&self.eigenvalues),
            a: doubles(&self.components),
            rss: self.rss.to_f64(),
            m: self.scaled.len(),
            total_weight: self.total_weight.to_f64(),
            unpenalised: usize::from(matches!(self.columns, Columns::Standardized(_))),
        }
    }
}

fn combine(vectors: &[Vec<Big>], parts: &[Big]) -> Vec<Big> {
    (0..vectors[0].len())
        .map(|j| vectors.iter().zip(parts).fold(Big::zero(), |sum, (v, a)| &sum + &(&v[j] * a)))
        .collect()
}

/// Filter of the spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// cᵢ = (λ* − λᵢ)/(2λᵢ) for the first L.
    FirstOrder(usize),
    /// cᵢ = √(λ*/λᵢ) − 1 for the first L.
    Exact(usize),
    Ridge,
}

/// Spectral sums in doubles.
#[derive(Clone, Debug)]
pub struct Sums {
    pub lambda: Vec<f64>,
    pub a: Vec<f64>,
    pub rss: f64,
    pub m: usize,
    pub total_weight: f64,
    /// Directions that no filter touches and that are not listed (the constant of a standardised
    /// fit).
    pub unpenalised: usize,
}

impl Sums {
    pub fn n(&self) -> usize {
        self.lambda.len()
    }

    /// σ̂ of the least-squares residuals.
    pub fn sigma(&self) -> f64 {
        (self.rss / (self.m - self.n() - self.unpenalised) as f64).sqrt()
    }

    /// cᵢ of the regularisation matrix (for ridge, what makes 1/(1+cᵢ) the filter factor).
    pub fn c(&self, filter: Filter, t: f64) -> Vec<f64> {
        let each = |(i, l): (usize, &f64)| match filter {
            Filter::FirstOrder(count) if i < count && *l < t => (t - l) / (2.0 * l),
            Filter::Exact(count) if i < count && *l < t => (t / l).sqrt() - 1.0,
            Filter::Ridge => t / l,
            _ => 0.0,
        };
        self.lambda.iter().enumerate().map(each).collect()
    }

    pub fn factors(&self, filter: Filter, t: f64) -> Vec<f64> {
        self.c(filter, t).iter().map(|c| 1.0 / (1.0 + c)).collect()
    }

    /// Eigenvalues of (X+B)ᵀ(X+B).
    pub fn regularized(&self, filter: Filter, t: f64) -> Vec<f64> {
        self.lambda.iter().zip(self.c(filter, t)).map(|(l, c)| l * (1.0 + c) * (1.0 + c)).collect()
    }

    pub fn condition(&self, filter: Filter, t: f64) -> f64 {
        let mu = self.regularized(filter, t);
        let (low, high) = mu.iter().fold((f64::INFINITY, 0.0f64), |(low, high), m| (low.min(*m), high.max(*m)));
        high / low
    }

    /// (aᵢ, λᵢ, fᵢ, 1 − fᵢ).
    fn directions(&self, filter: Filter, t: f64) -> impl Iterator<Item = (f64, f64, f64, f64)> {
        let c = self.c(filter, t);
        let rows: Vec<_> = (self.a.iter().zip(&self.lambda).zip(c))
            .map(|((a, l), c)| (*a, *l, 1.0 / (1.0 + c), c / (1.0 + c)))
            .collect();
        rows.into_iter()
    }

    pub fn bias_norm(&self, filter: Filter, t: f64) -> f64 {
        self.directions(filter, t).map(|(a, _, _, d)| (d * a).powi(2)).sum::<f64>().sqrt()
    }

    pub fn predicted_mse(&self, filter: Filter, t: f64, sigma: f64) -> f64 {
        let variance = sigma * sigma;
        self.directions(filter, t)
            .map(|(a, l, f, d)| d * d * (a * a - variance / l).max(0.0) + variance * f * f / l)
            .sum()
    }

    pub fn rss_at(&self, filter: Filter, t: f64) -> f64 {
        self.rss + self.directions(filter, t).map(|(a, l, _, d)| l * (d * a).powi(2)).sum::<f64>()
    }

    pub fn gcv(&self, filter: Filter, t: f64) -> f64 {
        let kept = self.directions(filter, t).map(|(_, _, f, _)| f).sum::<f64>() + self.unpenalised as f64;
        self.rss_at(filter, t) / (1.0 - kept / self.m as f64).powi(2)
    }

    /// Curvature of (log ‖residual‖, log ‖estimate‖), differentiated by hand in log t; positive at
    /// a corner.
    pub fn curvature(&self, filter: Filter, t: f64) -> f64 {
        let (mut r, mut r1, mut r2, mut e, mut e1, mut e2) = (self.rss, 0.0, 0.0, 0.0, 0.0, 0.0);
        for (i, (a, l, f, d)) in self.directions(filter, t).enumerate() {
            let (f1, f2) = match filter {
                Filter::FirstOrder(count) if i < count && l < t => {
                    (-2.0 * l * t / (t + l).powi(2), -2.0 * l * t * (l - t) / (t + l).powi(3))
                }
                Filter::Exact(count) if i < count && l < t => (-f / 2.0, f / 4.0),
                Filter::Ridge => (-l * t / (t + l).powi(2), -l * t * (l - t) / (t + l).powi(3)),
                _ => (0.0, 0.0),
            };
            let square = a * a;
            r += l * d * d * square;
            r1 -= 2.0 * l * d * f1 * square;
            r2 += 2.0 * l * (f1 * f1 - d * f2) * square;
            e += f * f * square;
            e1 += 2.0 * f * f1 * square;
            e2 += 2.0 * (f1 * f1 + f * f2) * square;
        }
        // Half the logarithms of the squares.
        let (x1, x2) = (r1 / r / 2.0, (r2 / r - (r1 / r).powi(2)) / 2.0);
        let (y1, y2) = (e1 / e / 2.0, (e2 / e - (e1 / e).powi(2)) / 2.0);
        (x1 * y2 - x2 * y1) / (x1 * x1 + y1 * y1).powf(1.5)
    }
}

/// `count` points from `low` to `high`, equally spaced in their logarithms, both ends included.
pub fn logarithmic(low: f64, high: f64, count: usize) -> Vec<f64> {
    let step = (high / low).ln() / (count - 1) as f64;
    (0..count).map(|i| if i + 1 == count { high } else { low * (i as f64 * step).exp() }).collect()
}

/// The least value of `objective` over [low, high]: a fine grid, then golden sections around its
/// best points.
pub fn brute_force_minimum(low: f64, high: f64, objective: impl Fn(f64) -> f64) -> (f64, f64) {
    let grid = logarithmic(low, high, 4001);
    let values: Vec<f64> = grid.iter().map(|t| objective(*t)).collect();
    let mut best = (low, f64::INFINITY);
    for i in 0..grid.len() {
        let (left, right) = (i.saturating_sub(1), (i + 1).min(grid.len() - 1));
        if values[i] > values[left] || values[i] > values[right] {
            continue;
        }
        let (mut p, mut q) = (grid[left].ln(), grid[right].ln());
        for _ in 0..80 {
            let (one, two) = (p + 0.381_966 * (q - p), p + 0.618_034 * (q - p));
            if objective(one.exp()) <= objective(two.exp()) { q = two } else { p = one }
        }
        for t in [grid[i], (0.5 * (p + q)).exp()] {
            let value = objective(t);
            if value < best.1 {
                best = (t, value);
            }
        }
    }
    best
}
