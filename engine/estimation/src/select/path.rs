//! The terms that the elastic net keeps, as λ falls.
//!
//! Polynomials are penalised as mixtures of Chebyshev polynomials on the box of the nodes, whatever
//! the caller's basis: what is kept, with all powers that divide it, then spans the same functions
//! in every basis. λ is cross-validated with estimates of the elastic net made anew without each
//! block; all other figures are those of least squares of the terms.

use nalgebra::{DMatrix, DVector};

use super::{
    elastic_net::{STEPS, Standardized, Sums},
    problem::Problem,
    terms::Hierarchy,
};
use crate::{
    result::Candidate,
    selection::{Block, Blockwise, moved_by},
};
use flankfit_numerics::cancel::Asking;

/// The models on the way, by columns.
pub(super) fn path(problem: &Problem, hierarchy: &Hierarchy, alpha: f64) -> Vec<(Vec<usize>, Candidate)> {
    let r = &problem.r;
    let size = r.ncols();
    let gram = r.tr_mul(r);
    let sums = Sums { cross: r.tr_mul(&problem.b), gram, weight: problem.weight };
    let whole = Standardized::new(&sums, problem.constant);
    let lambdas = whole.lambdas(alpha);
    let errors = problem.blocks.as_ref().map(|blocks| left_out(problem, blocks, &lambdas, alpha));
    let mut estimate = whole.start();
    let mut found: Vec<(Vec<usize>, Candidate)> = Vec::new();
    for k in (0..STEPS).asking(50 * size * size) {
        whole.descend(lambdas[k], alpha, &mut estimate);
        let columns = hierarchy.closed(&whole.kept(&estimate));
        if columns.is_empty() {
            continue;
        }
        let error = errors.as_ref().map(|errors| errors[k]).filter(|error| error.is_finite());
        match found.iter_mut().find(|(known, _)| *known == columns) {
            Some((_, known)) => {
                if let (Some(here), Some(there)) = (error, known.blocked_cv)
                    && here < there
                {
                    (known.lambda, known.blocked_cv) = (Some(lambdas[k]), error);
                }
            }
            None => {
                let figures = problem.figures(&problem.triangle.subspace(&columns));
                found.push((columns, Candidate { lambda: Some(lambdas[k]), blocked_cv: error, ..figures }));
            }
        }
    }
    found
}

/// `Σ w r²` of the nodes left out, for each λ.
fn left_out(problem: &Problem, blocks: &Blockwise, lambdas: &[f64], alpha: f64) -> Vec<f64> {
    let (r, b, n) = (&problem.r, &problem.b, problem.b.len());
    let of = |block: &Block| {
        let (cross, _) = moved_by(block, b);
        Sums { gram: r.tr_mul(&(&block.inner * r)), cross: r.tr_mul(&cross), weight: block.weight }
    };
    let each: Vec<Sums> = blocks.blocks.iter().map(of).collect();
    let mut errors = vec![0.0; lambdas.len()];
    for (at, block) in blocks.blocks.iter().enumerate() {
        let mut others = Sums { gram: DMatrix::zeros(n, n), cross: DVector::zeros(n), weight: 0.0 };
        for (_, sums) in each.iter().enumerate().filter(|(k, _)| *k != at) {
            others.gram += &sums.gram;
            others.cross += &sums.cross;
            others.weight += sums.weight;
        }
        let without = Standardized::new(&others, problem.constant);
        let mut estimate = without.start();
        for (&lambda, error) in lambdas.iter().zip(&mut errors).asking(50 * n * n) {
            without.descend(lambda, alpha, &mut estimate);
            let missed = b - r * without.coefficients(&estimate);
            *error += moved_by(block, &missed).1;
        }
    }
    errors
}
