//! The nodes in the coordinates of the directions that a penalty acts on, for criteria that look at
//! every node.

use nalgebra::DMatrix;

use super::{context::Context, reason::RegularizationReason};
use crate::{
    estimation::{
        fault::{Faults, Field},
        problem::{Evidence, Rows},
        selection::Nodewise,
        spec::{Criterion, FitSpec, Regularization},
    },
    numerics::cancel::Asking,
};

/// Nodes times directions at most: some 16 MB, and seconds of a search.
const MOST_ENTRIES: usize = 2_000_000;
/// Nodes times squared coefficients at most, to find them.
const MOST_PRODUCTS: usize = 1_000_000_000;

/// Where the criterion of `spec` stands.
pub(crate) fn criterion_field(spec: &FitSpec) -> Field {
    match spec.regularization {
        Regularization::Spectral { .. } => Field::LambdaCriterion,
        _ => Field::Criterion,
    }
}

/// Refuses a criterion that looks at every node where there are none, too many, or columns that
/// depend on each other.
pub(super) fn check(context: &Context) -> Result<(), Faults> {
    if context.spec.regularization.criterion() != Some(Criterion::Press) {
        return Ok(());
    }
    let refused = |reason| Err(Faults::one(criterion_field(context.spec), reason));
    let (nodes, n) = (context.count(), context.linear.design.size());
    if matches!(context.linear.evidence, Evidence::Summed(_)) {
        return refused(RegularizationReason::NodesNotKept(Criterion::Press));
    }
    if !context.spectrum.full_rank() {
        return refused(RegularizationReason::DependentColumns(Criterion::Press));
    }
    let most = (MOST_ENTRIES / n.max(1)).min(MOST_PRODUCTS / (n * n).max(1));
    if nodes > most {
        return refused(RegularizationReason::ManyNodes { criterion: Criterion::Press, nodes, most });
    }
    Ok(())
}

/// What the nodes have along `images`, unit vectors in Q's coordinates; `heights` is what Qᵀ√Ωz has
/// along them. `None` where the nodes are gone.
pub(super) fn along(context: &Context, images: &DMatrix<f64>, heights: Vec<f64>) -> Option<Nodewise> {
    let Evidence::Posted { sample, .. } = context.linear.evidence else { return None };
    let residuals = context.linear.of_working(&context.least_squares.working, true).values?;
    let rows = Rows::new(context.linear.design, sample, &context.linear.factor.r);
    let (n, directions) = (images.nrows(), images.ncols());
    let mut shares = Vec::with_capacity(sample.count() * directions);
    let mut left = Vec::with_capacity(sample.count());
    for k in (0..sample.count()).asking(2 * n * (n + directions)) {
        let (q, rest) = rows.at(k);
        shares.extend(images.column_iter().map(|image| image.iter().zip(&q).map(|(u, q)| u * q).sum::<f64>()));
        left.push(rest);
    }
    let residuals = residuals.iter().enumerate().map(|(k, r)| sample.w(k).sqrt() * r).collect();
    Some(Nodewise { along: shares, heights, residuals, left })
}
