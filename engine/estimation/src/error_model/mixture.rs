//! Averages over the parameters of a process that are not known.
//!
//! At any parameters generalised least squares has Student's distribution with m − n degrees of
//! freedom. Over a grid of parameters, each weighted with its restricted likelihood and a prior,
//! the estimates are mixtures of such distributions: their mean is the estimate, their quantiles
//! the interval. With t at the likeliest ρ alone intervals would be too short, the more the nearer
//! ρ is to 1.
//!
//! The grids are even in coordinates in which the likelihood is about as wide everywhere: θ with
//! ρ = sin θ for autoregressions (of second order the partial correlations ρ₁, ρ₂ with
//! φ₁ = ρ₁(1 − ρ₂), φ₂ = ρ₂), ln length and the white share for Matérn's process. Where few points
//! carry all the weight, the grid is laid closer about them.

use nalgebra::DMatrix;

use super::{
    process::Process,
    restricted::{Generalised, PlainRows},
};
use flankfit_numerics::{cancel::Asking, distribution::Student, length, root::root, triangular};

/// Kind of process that is searched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Family {
    Ar1,
    /// First order along u and v.
    Product,
    Ar2,
    /// Lengths between these.
    Matern {
        shortest: f64,
        longest: f64,
    },
}

/// Points of the grid along one and two parameters.
const POINTS: usize = 160;
const POINTS_OF_TWO: [usize; 2] = [40, 20];
/// Points whose likelihood is this much less than the greatest carry nothing.
const NEGLIGIBLE: f64 = 30.0;
/// So many points along an axis must carry weight.
const ENOUGH: usize = 12;
const FINER: usize = 4;

/// Smallest and greatest correlations of neighbours.
const LEAST: f64 = -0.6;
const MOST: f64 = 0.998;

impl Family {
    /// The correlation of neighbours, where it is what the grid is laid over.
    fn neighbours(&self, [a, _]: [f64; 2]) -> Option<f64> {
        match self {
            Family::Ar1 | Family::Product | Family::Ar2 => Some(libm::sin(a)),
            Family::Matern { .. } => None,
        }
    }

    pub(crate) fn points(&self) -> usize {
        match self {
            Family::Ar1 => POINTS,
            Family::Product | Family::Ar2 | Family::Matern { .. } => POINTS_OF_TWO[0] * POINTS_OF_TWO[1],
        }
    }

    fn shape(&self) -> [usize; 2] {
        match self {
            Family::Ar1 => [POINTS, 1],
            Family::Product | Family::Ar2 | Family::Matern { .. } => POINTS_OF_TWO,
        }
    }

    fn range(&self) -> [[f64; 2]; 2] {
        let angle = |low: f64, high: f64| [libm::asin(low), libm::asin(high)];
        match *self {
            Family::Ar1 => [angle(LEAST, MOST), [0.0; 2]],
            Family::Product => [angle(LEAST, MOST); 2],
            Family::Ar2 => [angle(LEAST, MOST), angle(-0.9, 0.9)],
            Family::Matern { shortest, longest } => [[libm::log(shortest), libm::log(longest)], [0.0, 0.9]],
        }
    }

    fn at(&self, [a, b]: [f64; 2]) -> Process {
        match self {
            Family::Ar1 => Process::Ar1(libm::sin(a)),
            Family::Product => Process::Product([libm::sin(a), libm::sin(b)]),
            Family::Ar2 => {
                let (first, second) = (libm::sin(a), libm::sin(b));
                Process::Ar2([first * (1.0 - second), second])
            }
            Family::Matern { .. } => Process::Matern { length: libm::exp(a), nugget: b },
        }
    }
}

impl Process {
    /// Its parameters, one after another.
    pub(crate) fn parameters(&self) -> Vec<f64> {
        match *self {
            Process::Ar1(rho) => vec![rho],
            Process::Product(pair) | Process::Ar2(pair) => pair.to_vec(),
            Process::Matern { length, nugget } => vec![length, nugget],
        }
    }

    fn with(&self, values: &[f64]) -> Self {
        match self {
            Process::Ar1(_) => Process::Ar1(values[0]),
            Process::Product(_) => Process::Product([values[0], values[1]]),
            Process::Ar2(_) => Process::Ar2([values[0], values[1]]),
            Process::Matern { .. } => Process::Matern { length: values[0], nugget: values[1] },
        }
    }
}

/// Estimates over the grid, with weights that add up to 1.
pub(crate) struct Mixture {
    parts: Vec<(f64, Generalised)>,
    /// The process with the mean of each parameter, and their standard deviations.
    pub process: Process,
    pub std_errors: [f64; 2],
    /// The mean step from least squares.
    pub step: Vec<f64>,
    /// The likeliest correlation of neighbours, where it is an end of what is searched.
    pub at_end: Option<f64>,
    /// The greatest restricted likelihood.
    pub log_likelihood: f64,
    student: Student,
}

impl Mixture {
    /// Over the grid of `family`; σ where it is known. `None` where no point of the grid has a
    /// likelihood.
    pub(crate) fn new(rows: &PlainRows, family: &Family, sigma: Option<f64>) -> Option<Self> {
        let (mut range, shape) = (family.range(), family.shape());
        let mut found: Vec<([usize; 2], Process, Generalised)> = Vec::new();
        let mut at_end = None;
        for round in 0..=FINER {
            found.clear();
            let mut greatest = f64::NEG_INFINITY;
            for i in (0..shape[0]).asking(100 * rows.work()) {
                for j in 0..shape[1] {
                    let place = |axis: usize, k: usize| {
                        let [low, high] = range[axis];
                        low + (high - low) * k as f64 / (shape[axis].max(2) - 1) as f64
                    };
                    let process = family.at([place(0, i), place(1, j)]);
                    let Some(here) = rows.at(&process, sigma) else { continue };
                    if here.log_likelihood > greatest - NEGLIGIBLE {
                        greatest = greatest.max(here.log_likelihood);
                        found.push(([i, j], process, here));
                    }
                }
            }
            found.retain(|(_, _, here)| here.log_likelihood > greatest - NEGLIGIBLE);
            let likeliest = found.iter().find(|(_, _, here)| here.log_likelihood == greatest).map(|(at, ..)| at[0]);
            let ends = [(0, range[0][0]), (shape[0] - 1, range[0][1])];
            let searched = family.range()[0];
            let end = ends.into_iter().find(|(at, place)| likeliest == Some(*at) && searched.contains(place));
            at_end = end.and_then(|(_, place)| family.neighbours([place, 0.0]));
            let before = range;
            for axis in 0..2 {
                let low = found.iter().map(|(at, ..)| at[axis]).min()?;
                let high = found.iter().map(|(at, ..)| at[axis]).max()?;
                if shape[axis] > 1 && high - low + 1 < ENOUGH.min(shape[axis] / 2) {
                    let [from, to] = range[axis];
                    let step = (to - from) / (shape[axis] - 1) as f64;
                    let (low, high) = (low as f64 - 1.0, high as f64 + 1.0);
                    range[axis] = [(from + low * step).max(from), (from + high * step).min(to)];
                }
            }
            if range == before || round == FINER {
                break;
            }
        }
        Some(Mixture { at_end, ..Self::of(found, rows.freedom, sigma) })
    }

    fn of(found: Vec<([usize; 2], Process, Generalised)>, freedom: f64, sigma: Option<f64>) -> Self {
        let greatest = found.iter().map(|(.., here)| here.log_likelihood).fold(f64::NEG_INFINITY, f64::max);
        let weights: Vec<f64> = found.iter().map(|(.., here)| libm::exp(here.log_likelihood - greatest)).collect();
        let whole: f64 = weights.iter().sum();
        let (mut values, mut squares) = ([0.0; 2], [0.0; 2]);
        let mut step = vec![0.0; found[0].2.step.len()];
        for ((_, process, here), weight) in found.iter().zip(&weights) {
            let share = weight / whole;
            step.iter_mut().zip(&here.step).for_each(|(to, x)| *to += share * x);
            values.iter_mut().zip(process.parameters()).for_each(|(to, x)| *to += share * x);
        }
        for ((_, process, _), weight) in found.iter().zip(&weights) {
            for (k, x) in process.parameters().into_iter().enumerate() {
                squares[k] += weight / whole * (x - values[k]).powi(2);
            }
        }
        let process = found[0].1.with(&values);
        let std_errors = squares.map(f64::sqrt);
        let parts = found.into_iter().zip(&weights).map(|((.., here), weight)| (weight / whole, here)).collect();
        let student = if sigma.is_some() { Student::NORMAL } else { Student::new(freedom) };
        Mixture { parts, process, std_errors, step, at_end: None, log_likelihood: greatest, student }
    }

    /// A square root G of the covariance, `C = GGᵀ`: within the parts and between them.
    pub(crate) fn root(&self) -> Option<DMatrix<f64>> {
        let n = self.step.len();
        let mut covariance = DMatrix::<f64>::zeros(n, n);
        for (weight, part) in self.parts.iter().asking(n * n * n) {
            let inverse = triangular::inverse_upper(&part.r);
            covariance.gemm(weight * part.sigma * part.sigma, &inverse, &inverse.transpose(), 1.0);
            let off = nalgebra::DVector::from_fn(n, |i, _| part.step[i] - self.step[i]);
            covariance.ger(*weight, &off, &off, 1.0);
        }
        lower_root(&covariance)
    }

    /// The interval that a form misses with probability `miss`, as much on either side: about its
    /// `value` at the mean step, `form` being in the coordinates of the orthonormal rows. `own` is
    /// the standard deviation of a further error.
    pub(crate) fn interval(&self, form: &[f64], value: f64, own: f64, miss: f64) -> [f64; 2] {
        let parts: Vec<(f64, f64, f64)> = self
            .parts
            .iter()
            .map(|(weight, part)| {
                let off: f64 = form.iter().zip(part.step.iter().zip(&self.step)).map(|(p, (x, m))| p * (x - m)).sum();
                let mut row = form.to_vec();
                triangular::solve_upper_transposed(&part.r, &mut row);
                (*weight, off, part.sigma * length(&row).hypot(own))
            })
            .collect();
        let beyond =
            |x: f64| parts.iter().map(|(w, at, scale)| w * self.student.upper_tail((x - at) / scale)).sum::<f64>();
        let quantile = self.student.upper_quantile(0.5 * miss);
        let ends = [-1.0, 1.0].map(|side: f64| {
            // every part has its own quantile between these
            let own = parts.iter().map(|(_, at, scale)| at + side * quantile * scale);
            let (low, high) = own.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            let tail = if side > 0.0 { 0.5 * miss } else { 1.0 - 0.5 * miss };
            let over = |x: f64| beyond(x) - tail;
            root([(low, over(low)), (high, over(high))], |x| 1e-12 * (x.abs() + (high - low)), over)
                .unwrap_or(0.5 * (low + high))
        });
        ends.map(|end| value + end)
    }
}

/// L with `LLᵀ` the matrix; `None` where it is singular to rounding.
pub(crate) fn lower_root(covariance: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    Some(triangular::cholesky(covariance)?.transpose())
}
