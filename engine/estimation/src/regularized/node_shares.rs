//! The nodes in the coordinates of the directions that a penalty acts on, for criteria that look at
//! every node.

use nalgebra::{DMatrix, DVector};

use super::context::Context;
use crate::{
    data::Partition,
    problem::{Evidence, Rows},
    selection::{Blockwise, LeftOut, Nodewise},
    spec::{Criterion, FitSpec, Folds, Regularization},
};
use flankfit_numerics::{cancel::Asking, check::Faults};

/// Nodes times directions at most: some 16 MB, and seconds of a search.
const MOST_ENTRIES: usize = 2_000_000;
/// Blocks times cubed coefficients at most: a few seconds of a search.
const MOST_CUBES: usize = 200_000_000;
/// Nodes times squared coefficients at most, to find them.
const MOST_PRODUCTS: usize = 1_000_000_000;

/// Path of the criterion in `spec`.
pub(crate) fn criterion_path(spec: &FitSpec) -> &'static str {
    match spec.regularization {
        Regularization::Spectral { .. } => "regularization.lambda_star.criterion",
        _ => "regularization.parameter.criterion",
    }
}

/// A criterion that looks at every node, of a stream.
pub(crate) fn nodes_not_kept(criterion: Criterion) -> String {
    format!("`{}` needs every node, and a stream keeps only sums: use another criterion", criterion.name())
}

/// Refuses a criterion that looks at every node where there are none, too many, or columns that
/// depend on each other.
pub(super) fn check(context: &Context) -> Result<(), Faults> {
    let asked = context.spec.regularization.criterion();
    let Some(criterion) = asked.filter(|criterion| criterion.is_nodewise()) else { return Ok(()) };
    let refused = |message| Err(Faults::one(criterion_path(context.spec), message));
    let (nodes, n) = (context.count(), context.linear.design.size());
    if matches!(context.linear.evidence, Evidence::Summed(_)) {
        return refused(nodes_not_kept(criterion));
    }
    if !context.spectrum.full_rank() {
        return refused(format!(
            "{} leaves out one node at a time, which needs linearly independent columns",
            criterion.name()
        ));
    }
    let most = match criterion {
        Criterion::BlockedCv => MOST_PRODUCTS / (n * n).max(1),
        _ => (MOST_ENTRIES / n.max(1)).min(MOST_PRODUCTS / (n * n).max(1)),
    };
    if nodes > most {
        return refused(format!(
            "{} needs every node: {nodes} are too many, with so many coefficients at most {most}; use gcv, which is \
             close to it",
            criterion.name()
        ));
    }
    if criterion == Criterion::BlockedCv {
        let folds = partition(context)?.map_or(0, |partition| partition.count);
        let most = MOST_CUBES / (n * n * n).max(1);
        if folds > most {
            let message = format_args!("{folds} blocks take too long for {n} coefficients: at most {most}");
            return Err(Faults::one("folds.count", message));
        }
    }
    Ok(())
}

/// The blocks of nodes; `None` where the nodes are gone.
fn partition(context: &Context) -> Result<Option<Partition>, Faults> {
    let Evidence::Posted { sample, nodes } = context.linear.evidence else { return Ok(None) };
    let by_default = Folds::default();
    Partition::new(nodes, sample, context.spec.folds.as_ref().unwrap_or(&by_default)).map(Some)
}

/// Coordinates of the nodes along `images`, orthonormal in Q's coordinates; `heights` are those of
/// Qᵀ√Ωz. `None` if the nodes are not kept.
pub(super) fn left_out(context: &Context, images: &DMatrix<f64>, heights: Vec<f64>) -> Option<LeftOut> {
    match context.spec.cross_validates() {
        true => in_blocks(context, images, heights),
        false => one_by_one(context, images, heights).map(LeftOut::OneByOne),
    }
}

fn in_blocks(context: &Context, images: &DMatrix<f64>, heights: Vec<f64>) -> Option<LeftOut> {
    let Evidence::Posted { sample, .. } = context.linear.evidence else { return None };
    let partition = partition(context).ok()??;
    let residuals = context.linear.of_working(&context.least_squares.working, true).values?;
    let rows = Rows::new(context.linear.design, sample, &context.linear.factor.r);
    let basis = completed(images);
    let n = basis.nrows();
    let mut blocks = Blockwise::empty(partition.count, n);
    for k in (0..sample.count()).asking(4 * n * n) {
        let (q, _) = rows.at(k);
        let row = basis.tr_mul(&DVector::from_vec(q));
        let weight = sample.w(k);
        blocks.add(partition.block[k], row.as_slice(), weight.sqrt() * residuals[k], weight);
    }
    Some(LeftOut::InBlocks(blocks, heights))
}

/// `images` first, then what makes them an orthonormal basis of the whole space.
fn completed(images: &DMatrix<f64>) -> DMatrix<f64> {
    let (n, known) = images.shape();
    let mut basis = images.clone().resize_horizontally(n, 0.0);
    for at in known..n {
        // the unit vector that the others reach least, made orthogonal to them twice
        let reached = |i: usize| basis.row(i).columns(0, at).norm_squared();
        let least = (0..n).min_by(|&i, &j| reached(i).total_cmp(&reached(j))).unwrap_or(0);
        let mut next = DVector::from_fn(n, |i, _| f64::from(u8::from(i == least)));
        for _ in 0..2 {
            let others = basis.columns(0, at);
            next -= others * others.tr_mul(&next);
        }
        basis.set_column(at, &next.normalize());
    }
    basis
}

fn one_by_one(context: &Context, images: &DMatrix<f64>, heights: Vec<f64>) -> Option<Nodewise> {
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
