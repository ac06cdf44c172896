//! Quasi-Newton steps towards the least value of a convex piecewise linear function.
//!
//! With thousands of pieces such a function looks smooth, and where the rows are orthonormal its
//! second derivatives are nearly those of a multiple of the identity. So BFGS (Nocedal and Wright
//! 2006, section 6.1) begins with that multiple and takes full steps. It ends where so few kinks
//! lie about the answer that walking over all of them costs next to nothing, or where the pieces
//! are too coarse for further steps.

use nalgebra::{DMatrix, DVector};

use flankfit_numerics::cancel;

/// Steps at most.
const STEPS: usize = 60;
/// The answer is thought to lie within so many times the length of the next step.
const SAFETY: f64 = 3.0;

/// A convex piecewise linear function of n variables.
pub(super) trait Pieces {
    /// Value and derivatives at a place.
    type Evaluated: At;

    /// n.
    fn size(&self) -> usize;
    /// Looks at a place.
    fn at(&self, x: &[f64]) -> Self::Evaluated;
    /// The multiple of the identity that the inverse of the second derivatives is near to.
    fn inverse_curvature(&self, start: &Self::Evaluated) -> f64;
    /// Kinks that may lie within this distance of the place.
    fn kinks_within(&self, place: &Self::Evaluated, distance: f64) -> usize;
}

/// Value and gradient.
pub(super) trait At {
    fn value(&self) -> f64;
    fn gradient(&self) -> &[f64];
}

/// A place near the answer.
pub(super) struct Near {
    pub x: Vec<f64>,
    /// Estimated distance of the solution.
    pub radius: f64,
}

/// Goes from 0 until there are but `few` kinks about the answer.
pub(super) fn approach<P: Pieces>(pieces: &P, few: usize) -> Near {
    approach_from(vec![0.0; pieces.size()], pieces, few)
}

/// The same from another place.
pub(super) fn approach_from<P: Pieces>(start: Vec<f64>, pieces: &P, few: usize) -> Near {
    let n = pieces.size();
    let mut x = DVector::from_vec(start);
    let mut here = pieces.at(x.as_slice());
    let mut inverse = DMatrix::identity(n, n) * pieces.inverse_curvature(&here);
    let mut radius = f64::INFINITY;
    for _ in 0..STEPS {
        cancel::checkpoint();
        let step = -(&inverse * DVector::from_column_slice(here.gradient()));
        radius = SAFETY * step.norm();
        if !(radius > 0.0) || pieces.kinks_within(&here, radius) <= few {
            break;
        }
        let Some((length, next)) = further(pieces, &here, &x, &step) else { break };
        let s = step * length;
        let y = DVector::from_iterator(n, next.gradient().iter().zip(here.gradient()).map(|(to, from)| to - from));
        update(&mut inverse, &s, &y);
        x += s;
        here = next;
    }
    Near { x: x.as_slice().to_vec(), radius }
}

/// The first of ever shorter steps that leads down, or to a lesser gradient.
fn further<P: Pieces>(
    pieces: &P,
    here: &P::Evaluated,
    x: &DVector<f64>,
    step: &DVector<f64>,
) -> Option<(f64, P::Evaluated)> {
    let square = |place: &P::Evaluated| place.gradient().iter().map(|g| g * g).sum::<f64>();
    let mut length = 1.0;
    for _ in 0..6 {
        cancel::checkpoint();
        let next = pieces.at((x + step * length).as_slice());
        if next.value() < here.value() || square(&next) < 0.9 * square(here) {
            return Some((length, next));
        }
        length *= 0.5;
    }
    None
}

/// `H ← (I − ρsyᵀ) H (I − ρysᵀ) + ρssᵀ`, ρ = 1/sᵀy.
fn update(inverse: &mut DMatrix<f64>, s: &DVector<f64>, y: &DVector<f64>) {
    let curvature = s.dot(y);
    if !(curvature > 1e-12 * s.norm() * y.norm()) {
        return;
    }
    let hy = &*inverse * y;
    let factor = (1.0 + y.dot(&hy) / curvature) / curvature;
    inverse.ger(factor, s, s, 1.0);
    inverse.ger(-1.0 / curvature, s, &hy, 1.0);
    inverse.ger(-1.0 / curvature, &hy, s, 1.0);
}
