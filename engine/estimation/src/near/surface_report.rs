//! The answer to a fit of a big surface.

use crate::{
    banded::{
        system::{Penalty, Solved, System},
        weight::{Trace, effective},
    },
    error::FitError,
    result::{Arithmetic, Warning},
    spec::Criterion,
};
use flankfit_geometry::{
    BSplineBasis,
    space::{Dimension, Vector},
    surface::BSplineSurface,
};
use flankfit_numerics::{cancel, check::Faults};

/// Operations up to which standard errors of a penalised surface are computed (n solves).
const MOST_OPERATIONS: f64 = 2e10;

/// Parts of the response that are included only on request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SurfaceInclude {
    /// Standard errors of the control values.
    pub standard_errors: bool,
    /// Residuals of the counted nodes.
    pub residuals: bool,
}

/// A surface near points.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceFit {
    /// A graph z(u, v), or a surface in space.
    pub surface: BSplineSurface,
    /// z, or x, y and z.
    pub coordinates: Vec<Coordinate>,
    /// Nodes counted.
    pub count: usize,
    /// m − edf where it is positive.
    pub degrees_of_freedom: f64,
    /// n without a penalty, else the trace of the smoother.
    pub effective_degrees_of_freedom: f64,
    /// Condition of the matrix solved (the Fisher information matrix plus penalty) on a unit
    /// diagonal; `None` where Lanczos did not settle.
    pub condition: Option<f64>,
    /// Nodes in every cell, those along v running fastest.
    pub nodes_per_span: Vec<usize>,
    /// Cells without a node.
    pub empty_spans: usize,
    /// λ and how it was found; `None` without a penalty.
    pub regularization: Option<Weight>,
    /// Precision in which the matrix was factored.
    pub arithmetic: Arithmetic,
    /// Corrections made by residuals.
    pub corrections: usize,
    /// Norm of the last correction over that of the coefficients.
    pub last_correction: f64,
    /// Warnings about this fit.
    pub warnings: Vec<Warning>,
}

/// One coordinate of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Coordinate {
    /// `Σ w r²`.
    pub rss: f64,
    /// Root mean square residual √(RSS/Σw).
    pub rms: f64,
    /// Largest absolute residual.
    pub max_abs: f64,
    /// √(RSS/(m − edf)).
    pub sigma: Option<f64>,
    /// Standard errors of the control values, v running fastest, on request.
    pub standard_errors: Option<Vec<f64>>,
    /// One per counted node (those of weight 0 are left out), in the order posted, if requested.
    pub residuals: Option<Vec<f64>>,
}

/// The weight of the penalty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weight {
    /// λ.
    pub lambda: f64,
    /// `None` for a given λ.
    pub criterion: Option<Criterion>,
    /// True if the criterion is met within the search range and no longer falls at its end.
    pub reached: bool,
    /// Method by which the trace of the smoother was computed.
    pub trace: Trace,
}

/// The fit that is reported on.
pub(super) struct Problem<'a> {
    pub system: &'a System,
    /// In the caller's order.
    pub bases: &'a [BSplineBasis; 2],
    /// True if u and v changed places inside.
    pub swapped: bool,
    pub include: SurfaceInclude,
}

impl Problem<'_> {
    /// The caller's (i, j) of a coefficient inside.
    fn place(&self, index: usize) -> (usize, usize) {
        let [u, v] = self.bases;
        if self.swapped { (index % u.size(), index / u.size()) } else { (index / v.size(), index % v.size()) }
    }

    /// Numbers by coefficient, in the caller's order.
    fn in_order<T: Copy + Default>(&self, values: impl Iterator<Item = T>) -> Vec<T> {
        let mut out = vec![T::default(); self.system.size()];
        for (index, value) in values.enumerate() {
            let (i, j) = self.place(index);
            out[i * self.bases[1].size() + j] = value;
        }
        out
    }

    fn nodes_per_span(&self) -> Vec<usize> {
        let inside = self.system.cells.nodes_per_cell();
        if !self.swapped {
            return inside;
        }
        let [rows, columns] = self.system.cells.spans;
        (0..columns).flat_map(|j| (0..rows).map(move |i| (i, j))).map(|(i, j)| inside[i * columns + j]).collect()
    }

    /// Names the coefficients that nodes (and penalty) leave open, with the spans that they live
    /// on.
    pub(super) fn undetermined(&self, which: &[usize], penalised: bool) -> Faults {
        let [u, v] = self.bases;
        let nodes = self.nodes_per_span();
        let (breaks_u, breaks_v) = (u.distinct_knots(), v.distinct_knots());
        let across = breaks_v.len() - 1;
        let mut faults = Faults::default();
        for &index in which {
            let (i, j) = self.place(index);
            let support = |basis: &BSplineBasis, i: usize| (basis.knots()[i], basis.knots()[i + basis.degree() + 1]);
            let ((a, b), (c, d)) = (support(u, i), support(v, j));
            let within = |breaks: &[f64], low: f64, high: f64| -> Vec<usize> {
                (0..breaks.len() - 1).filter(|&s| breaks[s] >= low && breaks[s + 1] <= high).collect()
            };
            let (rows, columns) = (within(&breaks_u, a, b), within(&breaks_v, c, d));
            let in_row = |r: &usize| columns.iter().map(|s| nodes[r * across + s]).sum::<usize>();
            let count: usize = rows.iter().map(in_row).sum();
            let mend = match penalised {
                true => "the penalty does not determine it either; use a lower order or fewer spans",
                false => "use fewer spans there, measure more nodes, or use `tikhonov`",
            };
            faults.push(
                "model",
                format_args!(
                    "the coefficient of B{i}(u)*B{j}(v), which is non-zero for u from {a} to {b} and v from {c} to \
                     {d}, is not determined by the {count} nodes there: {mend}"
                ),
            );
        }
        faults
    }
}

/// Reports on the solution.
pub(super) fn report(
    problem: &Problem,
    solved: Solved,
    penalty: Option<Penalty>,
    weight: Option<Weight>,
) -> Result<SurfaceFit, FitError> {
    let system = problem.system;
    let cells = &system.cells;
    let mut warnings = Vec::new();
    let count = cells.count();
    let total: f64 = cells.weight.as_ref().map_or(count as f64, |w| w.iter().sum());
    let effective = if penalty.is_some() { effective(system, &solved) } else { system.size() as f64 };
    let freedom = count as f64 - effective;
    let has_freedom = freedom > 1e-9 * count as f64;
    if !has_freedom {
        warnings.push(Warning::NoDegreesOfFreedom);
    }
    if solved.factor.condition.is_none() {
        warnings.push(Warning::ConditionUnknown);
    }
    if let Some(Weight { reached: false, .. }) = weight {
        warnings.push(Warning::LambdaAtLimit { parameter: "λ" });
    }
    let nodes_per_span = problem.nodes_per_span();
    let empty_spans = nodes_per_span.iter().filter(|&&nodes| nodes == 0).count();
    if empty_spans > 0 {
        warnings.push(Warning::EmptySpans { empty: empty_spans, cells: nodes_per_span.len() });
    }
    let spread = problem.include.standard_errors.then(|| spread(system, &solved, penalty, &mut warnings)).flatten();
    let residuals = problem.include.residuals.then(|| system.residuals(&solved.coefficients).values);
    let dimension = cells.heights.len();
    let coordinates = (0..dimension)
        .map(|d| {
            let rss = solved.residuals.rss[d].to_f64();
            let sigma = has_freedom.then(|| (rss / freedom).sqrt());
            Coordinate {
                rss,
                rms: (rss / total).sqrt(),
                max_abs: solved.residuals.max_abs[d],
                sigma,
                standard_errors: sigma
                    .zip(spread.as_ref())
                    .map(|(sigma, spread)| problem.in_order(spread.iter().map(|s| sigma * s))),
                residuals: residuals.as_ref().map(|values| in_posted_order(&values[d], &cells.posted)),
            }
        })
        .collect();
    let values = |d: usize| problem.in_order(solved.coefficients[d].iter().map(|c| c.to_f64()));
    let columns: Vec<Vec<f64>> = (0..dimension).map(values).collect();
    let controls: Vec<Vector> =
        (0..system.size()).map(|k| Vector::from_fn(|d, _| columns.get(d).map_or(0.0, |column| column[k]))).collect();
    let kind = if dimension == 1 { Dimension::Graph } else { Dimension::Space };
    let surface = BSplineSurface::new(problem.bases.clone(), kind, controls, None).map_err(|_| {
        let message = "these numbers exceed the range of double precision: choose another unit";
        FitError::ExceedsDouble(Faults::one("nodes", message))
    })?;
    Ok(SurfaceFit {
        surface,
        coordinates,
        count,
        degrees_of_freedom: freedom.max(0.0),
        effective_degrees_of_freedom: effective,
        condition: solved.factor.condition,
        nodes_per_span,
        empty_spans,
        regularization: weight,
        arithmetic: if solved.factor.is_plain() { Arithmetic::Double } else { Arithmetic::DoubleDouble },
        corrections: solved.rounds,
        last_correction: solved.last_correction,
        warnings,
    })
}

/// Values in the order of the cells, in the order posted.
fn in_posted_order(values: &[f64], posted: &[u32]) -> Vec<f64> {
    let mut pairs: Vec<(u32, f64)> = posted.iter().copied().zip(values.iter().copied()).collect();
    pairs.sort_unstable_by(cancel::comparing(|a: &(u32, f64), b: &(u32, f64)| a.0.cmp(&b.0)));
    pairs.into_iter().map(|pair| pair.1).collect()
}

/// √(variance/σ²) of each coefficient: of `H⁻¹F H⁻¹`, H = F + λP.
fn spread(system: &System, solved: &Solved, penalty: Option<Penalty>, warnings: &mut Vec<Warning>) -> Option<Vec<f64>> {
    let n = system.size();
    let Some(Penalty { .. }) = penalty else {
        let inverse = solved.factor.inverse_band();
        return Some((0..n).map(|j| inverse.get(j, j).max(0.0).sqrt()).collect());
    };
    let fisher = &system.normal.fisher;
    if 6.0 * (n as f64).powi(2) * fisher.width() as f64 > MOST_OPERATIONS {
        warnings.push(Warning::NoStandardErrors { coefficients: n });
        return None;
    }
    let mut unit = vec![0.0; n];
    Some(
        (0..n)
            .map(|j| {
                unit.fill(0.0);
                unit[j] = 1.0;
                solved.factor.solve(&mut unit);
                fisher.form(&unit, &unit).max(0.0).sqrt()
            })
            .collect(),
    )
}
