//! Least squares under monotonicity and convexity constraints, which hold at every place of a
//! domain.

mod check;
mod field;
mod patch;
mod pieces;
mod solve;

use nalgebra::DMatrix;

use self::{
    field::Field,
    solve::{Problem, Solution},
};
use super::{
    design::Design,
    result::{ActivePlace, ConstraintReport, ConstraintsReport},
    spec::Constraint,
};
use flankfit_numerics::{Dd, check::Faults};

pub(crate) use check::check;

/// The constrained estimate.
pub(crate) struct Constrained {
    /// The coefficients in the working basis.
    pub working: Vec<Dd>,
    /// The derivatives at the active places as forms, in Q's coordinates.
    pub normals: Vec<Vec<f64>>,
    pub report: ConstraintsReport,
}

/// The nearest function that meets checked constraints; `rss` is Σ w r² of least squares.
pub(crate) fn constrained(
    design: &Design,
    r: &DMatrix<Dd>,
    qty: &[Dd],
    rss: f64,
    constraints: &[Constraint],
) -> Result<Constrained, Faults> {
    let fields: Option<Vec<Field>> = constraints.iter().map(|one| Field::new(design, one)).collect();
    let mut problem = Problem { design, r, qty, fields: fields.ok_or_else(check::of_matrix)? };
    problem.scale();
    let solution = problem.solve()?;
    let report = report(&problem, &solution, rss, constraints);
    Ok(Constrained {
        working: problem.working(&solution.point),
        normals: solution.active.into_iter().map(|active| active.normal).collect(),
        report,
    })
}

fn report(problem: &Problem, solution: &Solution, rss: f64, constraints: &[Constraint]) -> ConstraintsReport {
    let of = |(index, (field, constraint)): (usize, (&Field, &Constraint))| ConstraintReport {
        kind: constraint.kind,
        along: field.along,
        domain: field.domain,
        least_value: solution.bounds[index] * field.scale,
        least_squares_least_value: solution.before[index] * field.scale,
        active: solution
            .active
            .iter()
            .filter(|active| active.field == index)
            .map(|active| ActivePlace {
                u: active.place[0],
                v: field.domain.v.map(|_| active.place[1]),
                multiplier: 2.0 * active.multiplier / field.scale,
            })
            .collect(),
    };
    ConstraintsReport {
        constraints: problem.fields.iter().zip(constraints).enumerate().map(of).collect(),
        rss: rss + solution.grown,
        rss_bound: rss + solution.grown_at_least.min(solution.grown),
        stationarity: solution.stationarity,
        rounds: solution.rounds,
    }
}
