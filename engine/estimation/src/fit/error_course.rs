//! Direction and parameters of correlated errors.

use std::cell::LazyCell;

use super::{
    error_checks::{family, given},
    error_models::{MOST_PRODUCTS, Plain, too_large},
};
use crate::{
    data::Nodes,
    error::FitError,
    error_model::{
        lines::{Lines, Measure, few_neighbours, short_lines},
        mixture::{Family, Mixture},
        process::Process,
        restricted::PlainRows,
    },
    spec::{Along, Correlation, Errors},
};
use flankfit_numerics::check::Faults;

/// Pairs of neighbours that an estimate of their correlation takes at least, and nodes with two
/// others before them on their line that a second parameter does.
const LEAST_PAIRS: usize = 3;
/// Gain of the logarithm of the likelihood from which on a second correlation counts: half the
/// quantile 0.99 of χ² with one degree of freedom.
const SIGNIFICANT: f64 = 3.317;

/// Error for residuals that determine no correlation.
pub(super) fn undetermined() -> Faults {
    let message = "the residuals determine no correlation: give its parameters, or take the errors as independent";
    Faults::one("errors", message)
}

/// A process along lines.
pub(super) struct Course {
    pub along: Along,
    pub lines: Lines,
    pub process: Process,
    /// The estimates over its parameters, if they are not given.
    pub mixture: Option<Mixture>,
}

impl Plain<'_> {
    /// Returns lines and process in the given direction; of a grid without one, in that in which
    /// the residuals are likelier, and in both where that is significantly likelier.
    pub(super) fn course(&self, errors: &Errors, residuals: &[f64]) -> Result<Course, FitError> {
        let orthonormal = LazyCell::new(|| self.orthonormal());
        let rows = |lines: &Lines| PlainRows::new(&orthonormal, residuals, lines.clone());
        let along = |along| self.course_along(errors, along, rows);
        if !matches!(self.nodes, Nodes::Grid(_)) || errors.along != Along::Order {
            return along(errors.along);
        }
        let likelihood = |course: &Course| match &course.mixture {
            Some(mixture) => mixture.log_likelihood,
            None => {
                let found = rows(&course.lines).at(&course.process, self.spec.noise_sigma);
                found.map_or(f64::NEG_INFINITY, |found| found.log_likelihood)
            }
        };
        let one = match (along(Along::U), along(Along::V)) {
            (Ok(u), Ok(v)) if likelihood(&u) >= likelihood(&v) => u,
            (_, Ok(one)) | (Ok(one), Err(_)) => one,
            (Err(refused), Err(_)) => return Err(refused),
        };
        let is_product = matches!(errors.correlation, Correlation::Ar1 { .. }) && self.is_full();
        let both = is_product.then(|| along(Along::Both)).and_then(Result::ok);
        Ok(both.filter(|both| likelihood(both) > likelihood(&one) + SIGNIFICANT).unwrap_or(one))
    }

    fn is_full(&self) -> bool {
        self.sample.count() == self.nodes.posted()
    }

    fn course_along(
        &self,
        errors: &Errors,
        along: Along,
        rows: impl Fn(&Lines) -> PlainRows,
    ) -> Result<Course, FitError> {
        let measure = match errors.correlation {
            Correlation::Matern { .. } => Measure::Distance,
            Correlation::Ar1 { .. } | Correlation::Ar2 { .. } => Measure::Steps,
        };
        let lines = match along {
            Along::Both if !self.is_full() => {
                return Err(Faults::one(
                    "errors.along",
                    "errors along both axes need every node of the grid: use one axis",
                )
                .into());
            }
            Along::Both => Lines::both(self.nodes, self.sample),
            _ => Lines::new(self.nodes, self.sample, along, errors.lines.as_deref(), measure),
        };
        let Some(family) = family(&errors.correlation, &lines) else {
            let process = given(errors.correlation, along).ok_or_else(undetermined)?;
            return Ok(Course { along, lines, process, mixture: None });
        };
        for lines in [Some(&lines), lines.across.as_deref()].into_iter().flatten() {
            self.check_neighbours(&errors.correlation, lines)?;
        }
        let mixture = self.searched(&family, &rows(&lines))?;
        Ok(Course { along, lines, process: mixture.process, mixture: Some(mixture) })
    }

    /// Refuses lines that cannot determine the parameters: one parameter needs pairs of neighbours,
    /// a second one nodes at greater distances, or neighbours at other distances.
    fn check_neighbours(&self, correlation: &Correlation, lines: &Lines) -> Result<(), Faults> {
        let lines_are_named = matches!(self.nodes, Nodes::Scattered(_) | Nodes::Matrix(_));
        let field = if lines_are_named { "errors.line" } else { "errors.along" };
        let (pairs, thirds) = (lines.pairs(), lines.thirds());
        let alike = match correlation {
            Correlation::Ar1 { .. } => false,
            Correlation::Ar2 { .. } => true,
            Correlation::Matern { .. } => lines.is_even(),
        };
        if pairs < LEAST_PAIRS {
            return Err(Faults::one(field, few_neighbours(pairs, LEAST_PAIRS)));
        }
        if alike && thirds < LEAST_PAIRS {
            return Err(Faults::one(field, short_lines(thirds, LEAST_PAIRS)));
        }
        Ok(())
    }

    fn searched(&self, family: &Family, rows: &PlainRows) -> Result<Mixture, FitError> {
        let (m, n) = (self.sample.count(), self.design.size());
        if rows.work().saturating_mul(family.points()) > MOST_PRODUCTS {
            return Err(Faults::one("errors", too_large(m, n)).into());
        }
        Mixture::new(rows, family, self.spec.noise_sigma).ok_or_else(|| undetermined().into())
    }
}
