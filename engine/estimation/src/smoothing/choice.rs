//! The weight λ of a roughness penalty, `min ‖√Ω(Y − f)‖² + λ P(f)`, where each λ costs a
//! factorisation of a banded matrix.
//!
//! Criteria are those of Tikhonov's estimate in other fits, by the same names:
//! * `gcv`: minimise `RSS / (1 − edf/m)²`, edf being the trace of the matrix that makes fitted
//!   values of heights;
//! * `discrepancy`: `RSS = m σ²`, with a given σ;
//! * `l_curve`: greatest curvature of `(log √RSS, log √P)`;
//! * `min_mse`: minimise `RSS + 2 σ² edf`, which estimates the squared error of the fitted values
//!   but for a constant (Mallows), with a given σ;
//! * or as many effective degrees of freedom as requested.
//!
//! Several coordinates with one λ have their RSS and P added up.

use rayon::prelude::*;

use crate::{
    selection::{Place, selector::ParameterProblem},
    spec::{Criterion, Parameter},
};
use flankfit_numerics::{cancel, check::Faults, minimize, root, words::Shown};

/// Results of one λ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// `Σ w r²`, over all coordinates.
    pub rss: f64,
    /// P.
    pub roughness: f64,
    /// dP/dλ ≤ 0.
    pub roughness_slope: f64,
    /// Trace of the smoother, of one coordinate.
    pub effective: f64,
}

/// Choice of λ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Smoothing {
    /// λ itself, or a criterion for it.
    Parameter(Parameter),
    /// Effective degrees of freedom of one coordinate.
    EffectiveDegrees(f64),
}

/// Quantities of the problem that the criteria need.
#[derive(Clone, Copy, Debug)]
pub struct Problem {
    /// m.
    pub count: usize,
    /// Coordinates that share λ.
    pub coordinates: usize,
    /// σ² of a height of weight 1.
    pub variance: Option<f64>,
    /// ln λ is searched here.
    pub range: [f64; 2],
}

/// λ and how it was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChosenLambda {
    /// λ.
    pub lambda: f64,
    /// The criterion that chose it; `None` for a given λ or given degrees of freedom.
    pub criterion: Option<Criterion>,
    /// False if the requested value is not reached within the range of λ, or if the criterion still
    /// falls at its end; the result is then that end.
    pub reached: bool,
}

/// Equations that could not be solved for any λ.
pub(crate) fn unsolved() -> Faults {
    Faults::one("parameter", "the equations could not be solved for any λ in the searched range")
}

/// Grid cells over the range of ln λ: none longer than this, and so many at most.
const CELL: f64 = 2.4;
const MOST_CELLS: f64 = 64.0;
/// Accuracy of ln λ for minima (where a criterion is flat) and for roots.
const FLAT: f64 = 1e-6;
const SHARP: f64 = 1e-12;

/// Finds λ; errors are placed at `noise_sigma`, `parameter` and `degrees_of_freedom`. `at(λ)` is
/// `None` where the equations cannot be solved in double precision.
pub fn find(
    asked: Smoothing,
    problem: &Problem,
    at: impl Fn(f64) -> Option<Figures> + Sync,
) -> Result<ChosenLambda, Faults> {
    let penalised = Penalised { problem, at };
    match asked {
        Smoothing::Parameter(parameter) => penalised.answer(parameter),
        Smoothing::EffectiveDegrees(degrees) => penalised.with_degrees(degrees),
    }
}

/// A penalty whose λ is sought.
struct Penalised<'a, F> {
    problem: &'a Problem,
    at: F,
}

impl<F: Fn(f64) -> Option<Figures> + Sync> ParameterProblem for Penalised<'_, F> {
    type Answer = ChosenLambda;
    type Refusal = Faults;

    fn fixed(&self, lambda: f64) -> Result<ChosenLambda, Faults> {
        if lambda >= 0.0 && lambda.is_finite() {
            Ok(ChosenLambda { lambda, criterion: None, reached: true })
        } else {
            Err(Faults::one("parameter", format_args!("{} is not a finite number ≥ 0", Shown(lambda))))
        }
    }

    fn choose(&self, criterion: Criterion) -> Result<ChosenLambda, Faults> {
        let Penalised { problem, at } = self;
        let found =
            |(x, reached): (f64, bool)| Ok(ChosenLambda { lambda: x.exp(), criterion: Some(criterion), reached });
        let no_sigma = || {
            let name = criterion.name();
            let message = format_args!("`{name}` needs `noise_sigma`, the standard deviation of a height of weight 1");
            Faults::one("noise_sigma", message)
        };
        let variance = problem.variance.ok_or_else(no_sigma);
        let coordinates = problem.coordinates as f64;
        match criterion {
            Criterion::Gcv => found(minimum(&self.grid()?, at, |_, f| problem.gcv(f))),
            Criterion::MinMse => {
                let variance = variance?;
                let score = |_: f64, f: &Figures| f.rss + 2.0 * variance * coordinates * f.effective;
                found(minimum(&self.grid()?, at, score))
            }
            Criterion::Discrepancy => {
                let aim = problem.count as f64 * coordinates * variance?;
                found(root(&self.grid()?, at, |f| (f.rss / aim).ln()))
            }
            Criterion::LCurve => {
                let bend = |x: f64, f: &Figures| -curvature(x.exp(), f);
                found(minimum(&self.grid()?, at, bend))
            }
            // an unsolvable problem comes first, as for the other criteria
            other => {
                self.grid()?;
                let name = other.name();
                let message = format_args!(
                    "`{name}` is not for a penalty on so many coefficients: gcv, discrepancy, l_curve and min_mse are"
                );
                Err(Faults::one("parameter.criterion", message))
            }
        }
    }
}

impl<F: Fn(f64) -> Option<Figures> + Sync> Penalised<'_, F> {
    fn grid(&self) -> Result<Grid, Faults> {
        Some(grid(self.problem.range, &self.at)).filter(|grid| !grid.is_empty()).ok_or_else(unsolved)
    }

    /// λ by the effective degrees of freedom of one coordinate.
    fn with_degrees(&self, asked: f64) -> Result<ChosenLambda, Faults> {
        let grid = self.grid()?;
        let (most, least) = (grid[0].1.effective, grid[grid.len() - 1].1.effective);
        if !(asked > least && asked < most) {
            let [asked, least, most] = [asked, least, most].map(Shown);
            let message = format_args!("{asked} effective degrees of freedom are not within {least} to {most}");
            return Err(Faults::one("degrees_of_freedom", message));
        }
        let (x, reached) = root(&grid, &self.at, |f| (asked / f.effective).ln());
        Ok(ChosenLambda { lambda: x.exp(), criterion: None, reached })
    }
}

impl Problem {
    fn gcv(&self, f: &Figures) -> f64 {
        let left = 1.0 - f.effective / self.count as f64;
        if left > 0.0 { f.rss / (left * left) } else { f64::INFINITY }
    }
}

/// Curvature of `(½ ln RSS, ½ ln P)` along ln λ, positive at a corner, from `dRSS/dλ = −λ dP/dλ`.
fn curvature(lambda: f64, f: &Figures) -> f64 {
    let q = lambda * f.roughness / f.rss;
    let slope = (0.5 * f.roughness_slope / f.roughness).abs();
    let relative = 1.0 / lambda + f.roughness_slope / f.roughness + lambda * f.roughness_slope / f.rss;
    let value = q * relative / (slope * (1.0 + q * q).powf(1.5));
    if value.is_finite() { value } else { f64::NEG_INFINITY }
}

type Grid = Vec<(f64, Figures)>;

fn grid([low, high]: [f64; 2], at: &(impl Fn(f64) -> Option<Figures> + Sync)) -> Grid {
    let cells = ((high - low) / CELL).ceil().clamp(1.0, MOST_CELLS) as usize;
    let places: Vec<f64> = (0..=cells).map(|i| low + (high - low) * (i as f64 / cells as f64)).collect();
    let handle = cancel::current();
    let figures: Vec<Option<Figures>> =
        places.par_iter().map(|x| cancel::carry(handle.as_ref(), || at(x.exp()))).collect();
    let usable = |f: &Figures| f.rss.is_finite() && f.roughness.is_finite() && f.effective.is_finite();
    places.into_iter().zip(figures).filter_map(|(x, f)| f.filter(usable).map(|f| (x, f))).collect()
}

/// Returns the minimum of `score`: every local minimum of the grid is refined (by golden sections
/// and parabolas), of equal ones the first wins. False if the score still falls, or is level, at an
/// end of the grid.
fn minimum(grid: &Grid, at: &impl Fn(f64) -> Option<Figures>, score: impl Fn(f64, &Figures) -> f64) -> (f64, bool) {
    let scores: Vec<f64> = grid.iter().map(|(x, f)| score(*x, f)).collect();
    let (mut place, mut best) = (grid[0].0, scores[0]);
    let at = |x: f64| {
        cancel::checkpoint();
        at(x.exp()).map_or(f64::INFINITY, |f| score(x, &f))
    };
    for i in 0..grid.len() {
        if scores[i] < best {
            (place, best) = (grid[i].0, scores[i]);
        }
        let dips = i > 0 && i + 1 < grid.len() && scores[i] < scores[i - 1] && scores[i] <= scores[i + 1];
        if dips {
            let (x, value) = minimize::minimum([grid[i - 1].0, grid[i + 1].0], (grid[i].0, scores[i]), FLAT, at);
            if value < best {
                (place, best) = (x, value);
            }
        }
    }
    let ends = [scores[0], scores[scores.len() - 1]];
    (place, Place::of(best, ends) == Place::Inside)
}

/// Place at which the rising `value` passes 0, and whether it does within the grid.
fn root(grid: &Grid, at: &impl Fn(f64) -> Option<Figures>, value: impl Fn(&Figures) -> f64) -> (f64, bool) {
    let (first, last) = (&grid[0], &grid[grid.len() - 1]);
    if value(&first.1) >= 0.0 {
        return (first.0, value(&first.1) == 0.0);
    }
    let Some(i) = grid.iter().position(|(_, f)| value(f) >= 0.0) else { return (last.0, false) };
    let end = |i: usize| (grid[i].0, value(&grid[i].1));
    let at = |x: f64| {
        cancel::checkpoint();
        at(x.exp()).map_or(f64::NAN, |f| value(&f))
    };
    (root::root([end(i - 1), end(i)], |x| SHARP * x.abs().max(1.0), at).unwrap_or(grid[i].0), true)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One direction with eigenvalue 1 of the penalty next to a null space of 2, RSS of its own 3,
    /// signal a = 2.
    fn one(lambda: f64) -> Option<Figures> {
        let f = 1.0 / (1.0 + lambda);
        Some(Figures {
            rss: 3.0 + 4.0 * (1.0 - f) * (1.0 - f),
            roughness: 4.0 * f * f,
            roughness_slope: -8.0 * f * f * f,
            effective: 2.0 + f,
        })
    }

    fn problem(variance: Option<f64>) -> Problem {
        Problem { count: 10, coordinates: 1, variance, range: [-12.0, 12.0] }
    }

    fn by(criterion: Criterion, variance: Option<f64>) -> Result<ChosenLambda, Faults> {
        find(Smoothing::Parameter(Parameter::Criterion(criterion)), &problem(variance), one)
    }

    #[test]
    fn every_criterion_finds_its_place() {
        // d/df of (3 + 4(1−f)²)/(8 − f)² is 0: −8(1−f)(8−f) + 2(3 + 4(1−f)²) = 0
        let lambda = by(Criterion::Gcv, None).unwrap().lambda;
        let f = 1.0 / (1.0 + lambda);
        assert!((-8.0 * (1.0 - f) * (8.0 - f) + 2.0 * (3.0 + 4.0 * (1.0 - f) * (1.0 - f))).abs() < 1e-4, "{f}");
        // 3 + 4(1−f)² = 10 σ²
        let lambda = by(Criterion::Discrepancy, Some(0.4)).unwrap().lambda;
        assert!((lambda / (1.0 + lambda) - 0.5).abs() < 1e-10);
        assert!(!by(Criterion::Discrepancy, Some(1.0)).unwrap().reached);
        // d/df: −8(1−f) + 2σ² = 0
        let lambda = by(Criterion::MinMse, Some(1.0)).unwrap().lambda;
        assert!((1.0 / (1.0 + lambda) - 0.75).abs() < 1e-5);
        let degrees = find(Smoothing::EffectiveDegrees(2.5), &problem(None), one).unwrap();
        assert!((degrees.lambda - 1.0).abs() < 1e-10);
        assert!(by(Criterion::LCurve, None).is_ok());
    }

    #[test]
    fn a_criterion_that_still_falls_at_an_end_is_not_reached() {
        // 3 + 4(1−f)² + 2σ²f: least at 1 − f = σ²/4, so that σ² ≥ 4 leaves no minimum within the
        // range
        for (variance, reached) in [(1.0, true), (3.9, true), (4.0, false), (9.0, false)] {
            let found = by(Criterion::MinMse, Some(variance)).unwrap();
            assert_eq!(found.reached, reached, "{variance}: {found:?}");
            assert!(reached || found.lambda > 0.9 * 12f64.exp(), "{found:?}");
        }
        // a signal that needs no penalty: GCV falls towards λ = 0
        let bare = |lambda: f64| one(lambda).map(|f| Figures { rss: f.rss - 3.0 + 1e-30, ..f });
        let found = find(Smoothing::Parameter(Parameter::Criterion(Criterion::Gcv)), &problem(None), bare).unwrap();
        assert!(!found.reached && found.lambda < 1e-5, "{found:?}");
    }

    #[test]
    fn the_curvature_is_that_of_the_curve() {
        let point = |x: f64| one(x.exp()).map(|f| (0.5 * f.rss.ln(), 0.5 * f.roughness.ln())).unwrap();
        for x in [-2.0f64, 0.0, 1.0] {
            let h = 1e-3;
            let ((a, b), (c, d), (e, f)) = (point(x - h), point(x), point(x + h));
            let ((dx, dy), (ddx, ddy)) = (
                ((e - a) / (2.0 * h), (f - b) / (2.0 * h)),
                ((e - 2.0 * c + a) / (h * h), (f - 2.0 * d + b) / (h * h)),
            );
            let truth = (dx * ddy - ddx * dy) / (dx * dx + dy * dy).powf(1.5);
            let got = curvature(x.exp(), &one(x.exp()).unwrap());
            assert!((got - truth).abs() < 1e-4 * truth.abs().max(1.0), "{x}: {got} {truth}");
        }
    }

    #[test]
    fn missing_parameters_are_reported() {
        let path = |found: Result<ChosenLambda, Faults>| found.unwrap_err().list()[0].path.clone();
        assert_eq!(path(by(Criterion::Discrepancy, None)), "noise_sigma");
        assert_eq!(path(by(Criterion::Hkb, None)), "parameter.criterion");
        let of = |asked| find(asked, &problem(None), one);
        assert_eq!(path(of(Smoothing::Parameter(Parameter::Fixed(-1.0)))), "parameter");
        assert_eq!(path(of(Smoothing::EffectiveDegrees(7.0))), "degrees_of_freedom");
    }
}
