//! Figures of an estimate that is filtered along oblique directions: `Â_λ = Z diag(f) Z⁻¹ Â` in the
//! scaled columns, with `fᵢ = 1/(1 + λδᵢ)` where the nodes see the direction and 0 where they do
//! not.
//!
//! Along zᵢ the least-squares coefficient aᵢ has variance σ². The squared error in the scaled
//! columns is no sum over directions, since they are not at right angles:
//!
//! `predicted_mse = ‖Z (1−f)ã‖² + σ² Σ fᵢ² ‖zᵢ‖²`, `ãᵢ = sign(aᵢ) √max(aᵢ² − σ², 0)`,
//!
//! which is the sum of the orthogonal case where Z is orthogonal. The bias of the expectation is `M
//! A`, `M = Z diag(1−f) Z⁻¹`, so `r ‖M‖₂` bounds it sharply; M is not symmetric and ‖M‖₂ may exceed
//! 1.

use std::{cell::RefCell, rc::Rc};

use nalgebra::{DMatrix, DVector};

use super::{
    extreme::{Blocks, largest, largest_of_blocks},
    pair::product,
    parity::{Blockwise, Parity},
    removal::Removal,
};
use flankfit_numerics::{Dd, Real, jacobi, matvec, svd_dd, symmetric};

/// The directions in the scaled columns.
pub(super) struct Oblique {
    form: Form,
    /// δᵢ.
    pub delta: Vec<f64>,
    /// Directions before this one are not seen by the nodes.
    pub silent: usize,
    /// Z⁻¹ Â.
    pub a: Vec<f64>,
    /// ãᵢ.
    real: Vec<f64>,
    /// ‖zᵢ‖².
    lengths: Vec<f64>,
    variance: Option<f64>,
}

/// Z, whose column i is zᵢ.
#[derive(Clone)]
enum Form {
    Exact(Rc<Exact>),
    Double(Rc<Double>),
}

/// To twice the digits of double.
struct Exact {
    z: DMatrix<Dd>,
    inverse: DMatrix<Dd>,
    plain: DMatrix<f64>,
    /// Z⁻ᵀ, for largest eigenvalues.
    dual: DMatrix<f64>,
}

/// In double precision and in blocks.
pub(super) struct Double {
    pub parity: Rc<Parity>,
    pub blocks: Vec<Block>,
    /// λ with the eigenvalues of `X̃ᵀX̃ + λP` found last.
    found: RefCell<Option<(f64, Vec<f64>)>>,
}

/// Directions of one block.
pub(super) struct Block {
    /// Indices of these directions.
    pub members: Vec<usize>,
    /// Their zᵢ in the combinations of the block.
    pub z: DMatrix<f64>,
    /// Z⁻ᵀ.
    pub dual: DMatrix<f64>,
}

impl Double {
    pub(super) fn new(parity: Parity, blocks: Vec<Block>) -> Self {
        Double { parity: Rc::new(parity), blocks, found: RefCell::default() }
    }

    fn of<'a>(&'a self, matrix: impl Fn(&'a Block) -> &'a DMatrix<f64>) -> Blocks<'a> {
        self.blocks.iter().map(|block| (&block.members[..], matrix(block))).collect()
    }
}

/// `M diag(d) Mᵀ`, d being the weights of the columns `members`.
fn gram(matrix: &DMatrix<f64>, members: &[usize], weight: impl Fn(usize) -> f64) -> DMatrix<f64> {
    let mut weighted = matrix.clone();
    weighted.column_iter_mut().zip(members).for_each(|(mut column, &i)| column *= weight(i));
    matvec::product(&weighted, &matrix.transpose())
}

/// Up to this size of a block reduction to tridiagonal form finds both ends of its spectrum sooner
/// than Lanczos' iteration.
const DIRECT: usize = 160;
/// Ratio of the ends of a spectrum below which the lower one has lost digits.
const SMALL: f64 = 1e-5;
/// Relative error that eigenvalues in double precision may have.
const EIGENVALUE: f64 = 1e-10;

/// Terms of the variances: the directions, or `Σ (fᵢ zⱼᵢ)²` for each scaled column j.
pub(super) enum Spread<'a> {
    Directions(&'a DMatrix<f64>),
    Squares(Vec<f64>),
}

impl Oblique {
    /// Directions `z` with their inverse, and the least-squares coefficients along them.
    pub(super) fn new(
        z: DMatrix<Dd>,
        inverse: DMatrix<Dd>,
        delta: Vec<f64>,
        silent: usize,
        a: Vec<f64>,
        variance: Option<f64>,
    ) -> Self {
        let plain = z.map(|x| x.to_f64());
        let lengths = plain.column_iter().map(|column| column.norm_squared()).collect();
        let dual = inverse.transpose().map(|x| x.to_f64());
        let form = Form::Exact(Rc::new(Exact { z, inverse, plain, dual }));
        Oblique { form, delta, silent, real: Vec::new(), a: Vec::new(), lengths, variance: None }.with(a, variance)
    }

    /// The same in double precision; the nodes see every direction.
    pub(super) fn of_blocks(double: Double, delta: Vec<f64>, a: Vec<f64>, variance: Option<f64>) -> Self {
        let mut lengths = vec![0.0; delta.len()];
        for block in &double.blocks {
            block.members.iter().zip(block.z.column_iter()).for_each(|(&i, z)| lengths[i] = z.norm_squared());
        }
        let form = Form::Double(Rc::new(double));
        Oblique { form, delta, silent: 0, real: Vec::new(), a: Vec::new(), lengths, variance: None }.with(a, variance)
    }

    /// The same directions with other least-squares coefficients and another σ².
    pub(super) fn with(&self, a: Vec<f64>, variance: Option<f64>) -> Self {
        let noise = variance.unwrap_or(0.0);
        let real = |(i, &a): (usize, &f64)| match i < self.silent {
            true => 0.0,
            false => (a * a - noise).max(0.0).sqrt().copysign(a),
        };
        Oblique {
            form: self.form.clone(),
            delta: self.delta.clone(),
            silent: self.silent,
            real: a.iter().enumerate().map(real).collect(),
            a,
            lengths: self.lengths.clone(),
            variance,
        }
    }

    /// True if no σ is known.
    pub(super) fn is_noiseless(&self) -> bool {
        self.variance.is_none()
    }

    fn size(&self) -> usize {
        self.delta.len()
    }

    /// fᵢ.
    pub(super) fn factor(&self, i: usize, lambda: f64) -> f64 {
        if i < self.silent { 0.0 } else { 1.0 / (1.0 + lambda * self.delta[i]) }
    }

    /// 1 − fᵢ, without cancellation.
    pub(super) fn removed(&self, i: usize, lambda: f64) -> f64 {
        let pull = lambda * self.delta[i];
        match i < self.silent {
            true => 1.0,
            false if pull.is_finite() => pull / (1.0 + pull),
            false => 1.0,
        }
    }

    fn each(&self, f: impl Fn(usize) -> f64) -> DVector<f64> {
        DVector::from_fn(self.size(), |i, _| f(i))
    }

    /// `Z x` in the scaled columns or in orthonormal combinations of them: lengths and scalar
    /// products are the same.
    pub(super) fn along(&self, x: &DVector<f64>) -> DVector<f64> {
        match &self.form {
            Form::Exact(exact) => &exact.plain * x,
            Form::Double(double) => {
                let mut out = DVector::zeros(x.len());
                let mut from = 0;
                for block in &double.blocks {
                    let inner: Vec<f64> = block.members.iter().map(|&i| x[i]).collect();
                    matvec::times(&block.z, &inner, &mut out.as_mut_slice()[from..from + inner.len()]);
                    from += inner.len();
                }
                out
            }
        }
    }

    /// Returns the terms of the variances.
    pub(super) fn spread(&self, lambda: f64) -> Spread<'_> {
        let double = match &self.form {
            Form::Exact(exact) => return Spread::Directions(&exact.plain),
            Form::Double(double) => double,
        };
        let mut squares = vec![0.0; self.size()];
        for (at, block) in double.parity.blocks().zip(&double.blocks) {
            let mut own = vec![0.0; block.z.nrows()];
            for (&i, z) in block.members.iter().zip(block.z.column_iter()) {
                let factor = self.factor(i, lambda);
                own.iter_mut().zip(z.iter()).for_each(|(sum, z)| *sum += (factor * z).powi(2));
            }
            double.parity.scatter_squares(at, &own, &mut squares);
        }
        Spread::Squares(squares)
    }

    /// `‖Â − Â_λ‖`.
    pub(super) fn bias(&self, lambda: f64) -> f64 {
        self.along(&self.each(|i| self.removed(i, lambda) * self.a[i])).norm()
    }

    /// `‖Â_λ‖`.
    pub(super) fn norm(&self, lambda: f64) -> f64 {
        self.along(&self.each(|i| self.factor(i, lambda) * self.a[i])).norm()
    }

    /// `‖Y − XÂ_λ‖² − RSS`.
    pub(super) fn risen(&self, lambda: f64) -> f64 {
        (self.silent..self.size()).map(|i| (self.removed(i, lambda) * self.a[i]).powi(2)).sum()
    }

    /// The predicted mean squared error and its derivative by ln λ; `None` without σ.
    pub(super) fn mse(&self, lambda: f64) -> Option<(f64, f64)> {
        let variance = self.variance?;
        let moved = self.along(&self.each(|i| self.removed(i, lambda) * self.real[i]));
        let slope = self.along(&self.each(|i| self.factor(i, lambda) * self.removed(i, lambda) * self.real[i]));
        let (mut noise, mut falling) = (0.0, 0.0);
        for i in self.silent..self.size() {
            let (f, g) = (self.factor(i, lambda), self.removed(i, lambda));
            noise += f * f * self.lengths[i];
            falling += f * f * g * self.lengths[i];
        }
        Some((moved.norm_squared() + variance * noise, 2.0 * (moved.dot(&slope) - variance * falling)))
    }

    /// `X̃ᵀX̃ + λP` in the directions: 1 + λδ, or λδ where the nodes see nothing.
    fn lifted(&self, i: usize, lambda: f64) -> f64 {
        lambda * self.delta[i] + if i < self.silent { 0.0 } else { 1.0 }
    }

    /// True if every `1 + λδ` is a number that can be worked with.
    pub(super) fn within_range(&self, lambda: f64) -> bool {
        (0..self.size()).all(|i| (1e-280..1e280).contains(&self.lifted(i, lambda)))
    }

    /// Eigenvalues of `X̃ᵀX̃ + λP`, ascending; `None` if the iteration does not end, or where
    /// double precision has not the digits.
    pub(super) fn eigenvalues(&self, lambda: f64) -> Option<Vec<f64>> {
        /// Relative error that double precision may leave.
        const TOLERANCE: f64 = 1e-12;
        let inverse = match &self.form {
            Form::Exact(exact) => &exact.inverse,
            Form::Double(double) => return self.known_eigenvalues(double, lambda),
        };
        let roots: Vec<Dd> = (0..self.size()).map(|i| Dd::from(self.lifted(i, lambda)).sqrt()).collect();
        let rows = DMatrix::from_fn(self.size(), self.size(), |i, j| roots[i] * inverse[(i, j)]);
        let plain = jacobi::svd(rows.map(|x| x.to_f64()))?;
        let (low, high) = (plain.sigma.first().copied()?, plain.sigma.last().copied()?);
        if low > 0.0 && high / low * f64::EPSILON * self.size() as f64 <= TOLERANCE {
            return Some(plain.sigma.iter().map(|s| s * s).collect());
        }
        Some(svd_dd(&rows)?.sigma.iter().map(|&s| (s * s).to_f64()).collect())
    }

    /// Finds the eigenvalues at `lambda` beforehand, where the condition there follows from them.
    pub(super) fn prepare(&self, lambda: f64) {
        if let Form::Double(double) = &self.form {
            let found = self.known_eigenvalues(double, lambda).map(|found| (lambda, found));
            *double.found.borrow_mut() = found;
        }
    }

    fn known_eigenvalues(&self, double: &Double, lambda: f64) -> Option<Vec<f64>> {
        match &*double.found.borrow() {
            Some((at, found)) if *at == lambda => Some(found.clone()),
            _ => self.eigenvalues_of_blocks(double, lambda),
        }
    }

    /// The large ones from the matrix, the small ones from its inverse, so that the error of none
    /// is more than a few roundings of the mean of both ends.
    fn eigenvalues_of_blocks(&self, double: &Double, lambda: f64) -> Option<Vec<f64>> {
        /// Ratio up to which the small ones have their digits from the matrix itself.
        const MILD: f64 = 1e4;
        let mut all = Vec::with_capacity(self.size());
        for Block { members, z, dual } in &double.blocks {
            let mut values = symmetric::eigenvalues(gram(dual, members, |i| self.lifted(i, lambda)))?;
            let (low, high) = (values.first().copied()?, values.last().copied()?);
            if !(low * MILD > high) {
                let inverse = symmetric::eigenvalues(gram(z, members, |i| 1.0 / self.lifted(i, lambda)))?;
                let least = 1.0 / inverse.last().copied()?;
                let middle = (least * high).sqrt();
                if !(8.0 * f64::EPSILON * (high / least).sqrt() <= EIGENVALUE) {
                    return None;
                }
                for (value, inverse) in values.iter_mut().zip(inverse.iter().rev()) {
                    if *value < middle {
                        *value = 1.0 / inverse;
                    }
                }
            }
            all.append(&mut values);
        }
        all.sort_by(f64::total_cmp);
        Some(all)
    }

    /// Condition of `X̃ᵀX̃ + λP`.
    pub(super) fn condition(&self, lambda: f64) -> Option<f64> {
        if let Form::Double(double) = &self.form
            && double.blocks.iter().all(|block| block.members.len() <= DIRECT)
        {
            return self.condition_of_blocks(double, lambda).filter(|c| c.is_finite() && *c > 0.0);
        }
        self.condition_with_slope(lambda).map(|(condition, _)| condition)
    }

    /// From both ends of the spectrum of every block; the lower end from the inverse where the
    /// matrix itself would not leave it its digits.
    fn condition_of_blocks(&self, double: &Double, lambda: f64) -> Option<f64> {
        if let Some((_, found)) = double.found.borrow().as_ref().filter(|(at, _)| *at == lambda) {
            return Some(found.last()? / found.first()?);
        }
        let (mut low, mut high) = (f64::INFINITY, 0.0f64);
        for Block { members, dual, .. } in &double.blocks {
            let [least, most] = symmetric::extremes(gram(dual, members, |i| self.lifted(i, lambda)))?;
            (low, high) = (low.min(least), high.max(most));
        }
        if !(low > high * SMALL) {
            let mut most = 0.0f64;
            for Block { members, z, .. } in &double.blocks {
                most = most.max(symmetric::extremes(gram(z, members, |i| 1.0 / self.lifted(i, lambda)))?[1]);
            }
            low = 1.0 / most;
        }
        Some(high / low)
    }

    /// Condition of `X̃ᵀX̃ + λP` and the derivative of its logarithm by ln λ. Its largest
    /// eigenvalue is a convex function of λ and its smallest a concave one, so this slope changes
    /// its sign at most once.
    pub(super) fn condition_with_slope(&self, lambda: f64) -> Option<(f64, f64)> {
        let lifted = self.each(|i| self.lifted(i, lambda));
        let [(high, x), (low, y)] = match &self.form {
            Form::Exact(exact) => [largest(&exact.dual, &lifted), largest(&exact.plain, &lifted.map(|g| 1.0 / g))],
            Form::Double(double) => {
                let of = |blocks: Blocks, d: &DVector<f64>| {
                    let (value, image) = largest_of_blocks(&blocks, d.as_slice());
                    (value, DVector::from_vec(image))
                };
                let inverse = lifted.map(|g| 1.0 / g);
                [of(double.of(|block| &block.dual), &lifted), of(double.of(|block| &block.z), &inverse)]
            }
        };
        let share = |i: usize| lambda * self.delta[i];
        // derivatives of the two Rayleigh quotients
        let rising: f64 = (0..x.len()).map(|i| share(i) * x[i] * x[i]).sum::<f64>() / high;
        let lifting: f64 = (0..y.len()).map(|i| share(i) / (lifted[i] * lifted[i]) * y[i] * y[i]).sum::<f64>() / low;
        let condition = high * low;
        (condition.is_finite() && condition > 0.0).then_some((condition, rising - lifting))
    }

    /// `M = Z diag(1−f) Z⁻¹`; formed in double-double where Z may be long though M is not.
    pub(super) fn removal(&self, lambda: f64) -> Removal {
        match &self.form {
            Form::Exact(exact) => {
                let mut turned = exact.inverse.clone();
                for (i, mut row) in turned.row_iter_mut().enumerate() {
                    let removed = self.removed(i, lambda);
                    row.iter_mut().for_each(|x| *x = x.mul_f64(removed));
                }
                Removal::Whole(product(&exact.z, &turned).map(|x| x.to_f64()))
            }
            Form::Double(double) => {
                let blocks = double.blocks.iter().map(|Block { members, z, dual }| {
                    let mut weighted = z.clone();
                    weighted
                        .column_iter_mut()
                        .zip(members)
                        .for_each(|(mut column, &i)| column *= self.removed(i, lambda));
                    matvec::product(&weighted, &dual.transpose())
                });
                Removal::Blocks(Blockwise { parity: Rc::clone(&double.parity), blocks: blocks.collect() })
            }
        }
    }
}
