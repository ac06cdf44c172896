//! The regularised estimate as a linear map of what the heights have in Q's coordinates.
//!
//! A linear form of the coefficients (one of them, a height of the surface, a slope) is a vector q:
//! least squares estimates it by `qᵀb`, `b = Qᵀ√Ωz`, with variance `σ²‖q‖²`. A regularised estimate
//! is `ρ(q)ᵀb` with another vector ρ(q), so its variance is `σ²‖ρ(q)‖²`.

use nalgebra::{DMatrix, DVector};

use super::removal::Removal;
use crate::{
    factor::multiply_upper_vector,
    problem::LinearProblem,
    spectrum::{ScaledColumns, Spectrum},
};
use flankfit_numerics::{Dd, dot};

/// Map from least squares to the regularised estimate.
pub(crate) enum LinearMap {
    /// Filters along the eigenvectors of the scaled columns: 1 − fᵢ.
    Eigenvectors { removed: Vec<f64> },
    /// Filters along other directions.
    Oblique {
        /// Column i is direction i in Q's coordinates, of length 1.
        images: DMatrix<f64>,
        /// 1 − fᵢ.
        removed: Vec<f64>,
        /// `M`: the bias of the scaled coefficients is `M A`.
        removal: Removal,
        /// The estimate in the working basis.
        working: Vec<Dd>,
    },
    /// Filters along directions that are not orthogonal in Q's coordinates.
    Directions {
        /// Column i is what direction i does to the heights.
        images: DMatrix<f64>,
        /// Column i is the form that gives the coefficient along direction i.
        forms: DMatrix<f64>,
        /// 1 − fᵢ.
        removed: Vec<f64>,
        /// `M`: the bias of the scaled coefficients is `M A`.
        removal: Removal,
        /// The estimate in the working basis.
        working: Vec<Dd>,
    },
    /// A uniform shrinkage to a target.
    Toward {
        /// Remaining share of the distance to the target.
        factor: f64,
        /// The direction that is not shrunk, in Q's coordinates, of length 1.
        kept: Option<Vec<f64>>,
        bias: TargetBias,
        /// The estimate in the working basis.
        working: Vec<Dd>,
    },
    /// Least squares among the functions that meet constraints, the active ones held.
    Constrained {
        /// Orthonormal columns that span the active forms, in Q's coordinates.
        held: DMatrix<f64>,
        /// Greatest distance of the expectation from the truth there.
        reach: f64,
        /// The estimate in the working basis.
        working: Vec<Dd>,
    },
    /// The posterior of nodes and prior.
    Posterior {
        /// C, `σ²CᵀC` being the covariance in Q's coordinates.
        root: DMatrix<f64>,
        /// 1 less what of the heights arrives in the estimate.
        removal: DMatrix<f64>,
        /// A form q has a bias of at most the length of this times q, plus the offset's.
        reach: DMatrix<f64>,
        /// Bias in addition to that of a single prior.
        offset: DVector<f64>,
        /// The estimate in the working basis.
        working: Vec<Dd>,
    },
}

/// Quantities that bound the bias of an estimate that is shrunk to a target.
pub(crate) struct TargetBias {
    /// `Vᵢᵀ T̃`.
    pub target: Vec<f64>,
    /// `Vᵢᵀ κ̃` and hᵢ, where the target is the grand mean.
    pub mean: Option<(Vec<f64>, Vec<f64>)>,
}

fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|x| x * x).sum::<f64>().sqrt()
}

impl TargetBias {
    /// Sharp bound on the bias of the form with `along` on the eigenvectors, for ‖A‖ ≤ `r`, where
    /// `removed` of the distance to the target is taken away.
    pub(crate) fn of(&self, removed: f64, r: f64, along: &[f64]) -> f64 {
        let dot = |x: &[f64]| along.iter().zip(x).map(|(p, x)| p * x).sum::<f64>();
        match &self.mean {
            // reached by the A of length r that lies opposite to T
            None => removed * (r * norm(along.iter().copied()) + dot(&self.target).abs()),
            Some((kappa, h)) => {
                let share = dot(kappa);
                removed * r * norm(along.iter().zip(h).map(|(x, h)| x - share * h))
            }
        }
    }
}

/// A linear form of the coefficients.
pub(crate) struct Form {
    /// In Q's coordinates.
    pub q: Vec<f64>,
    /// `qᵀX̃Vᵢ`: what each eigenvector of the scaled columns contributes.
    pub along: Vec<f64>,
}

impl Form {
    pub(crate) fn new(q: Vec<f64>, spectrum: &Spectrum) -> Self {
        let along = spectrum.image.column_iter().map(|image| dot(image.as_slice(), &q)).collect();
        Form { q, along }
    }
}

impl LinearMap {
    /// True if the estimate is plain least squares.
    pub(crate) fn is_identity(&self) -> bool {
        match self {
            LinearMap::Eigenvectors { removed } => removed.iter().all(|g| *g == 0.0),
            LinearMap::Constrained { held, .. } => held.ncols() == 0,
            _ => false,
        }
    }

    /// `qᵀ(q − ρ(q))`, as a sum of squares where the map is a filter.
    pub(crate) fn removed_of(&self, form: &Form, spectrum: &Spectrum) -> f64 {
        match self {
            LinearMap::Eigenvectors { removed } => {
                let terms = removed.iter().zip(&spectrum.lambda).zip(&form.along);
                terms.filter(|((_, lambda), _)| **lambda > 0.0).map(|((g, lambda), p)| g * p * p / lambda).sum()
            }
            LinearMap::Oblique { images, removed, .. } => {
                images.column_iter().zip(removed).map(|(image, g)| g * dot(image.as_slice(), &form.q).powi(2)).sum()
            }
            LinearMap::Directions { images, forms, removed, .. } => {
                let of = |columns: &DMatrix<f64>, i: usize| dot(columns.column(i).as_slice(), &form.q);
                removed.iter().enumerate().map(|(i, g)| g * of(images, i) * of(forms, i)).sum()
            }
            LinearMap::Constrained { held, .. } => {
                held.column_iter().map(|own| dot(own.as_slice(), &form.q).powi(2)).sum()
            }
            LinearMap::Toward { factor, kept, .. } => {
                let kept = kept.as_ref().map_or(0.0, |kept| dot(kept, &form.q).powi(2));
                (1.0 - factor) * (dot(&form.q, &form.q) - kept)
            }
            LinearMap::Posterior { removal, .. } => {
                let removed = |row: &[f64]| dot(row, &form.q);
                removal.column_iter().zip(&form.q).map(|(column, q)| q * removed(column.as_slice())).sum()
            }
        }
    }

    /// A vector of which σ times the length is the standard error of the form: ρ(q), but for a
    /// posterior, in which not the heights of now alone vary.
    pub(crate) fn spread(&self, form: &Form, spectrum: &Spectrum) -> Vec<f64> {
        match self {
            LinearMap::Posterior { root, .. } => {
                root.row_iter().map(|c| c.iter().zip(&form.q).map(|(c, q)| c * q).sum()).collect()
            }
            _ => self.row(form, spectrum),
        }
    }

    /// ρ(q).
    pub(crate) fn row(&self, form: &Form, spectrum: &Spectrum) -> Vec<f64> {
        let mut row = form.q.clone();
        match self {
            LinearMap::Posterior { removal, .. } => {
                for (to, removed) in row.iter_mut().zip(removal.row_iter()) {
                    *to -= removed.iter().zip(&form.q).map(|(g, q)| g * q).sum::<f64>();
                }
            }
            LinearMap::Eigenvectors { removed } => {
                for (i, (&g, &lambda)) in removed.iter().zip(&spectrum.lambda).enumerate() {
                    if g != 0.0 && lambda > 0.0 {
                        let share = g * form.along[i] / lambda;
                        row.iter_mut().zip(spectrum.image.column(i).iter()).for_each(|(to, x)| *to -= share * x);
                    }
                }
            }
            LinearMap::Oblique { images, removed, .. } => {
                for (image, &g) in images.column_iter().zip(removed) {
                    let share = g * dot(image.as_slice(), &form.q);
                    row.iter_mut().zip(image.iter()).for_each(|(to, x)| *to -= share * x);
                }
            }
            LinearMap::Directions { images, forms, removed, .. } => {
                for (i, &g) in removed.iter().enumerate() {
                    let share = g * dot(images.column(i).as_slice(), &form.q);
                    row.iter_mut().zip(forms.column(i).iter()).for_each(|(to, x)| *to -= share * x);
                }
            }
            LinearMap::Constrained { held, .. } => {
                for own in held.column_iter() {
                    let share = dot(own.as_slice(), &form.q);
                    row.iter_mut().zip(own.iter()).for_each(|(to, x)| *to -= share * x);
                }
            }
            LinearMap::Toward { factor, kept, .. } => {
                row.iter_mut().for_each(|x| *x *= factor);
                if let Some(kept) = kept {
                    let share = (1.0 - factor) * dot(kept, &form.q);
                    row.iter_mut().zip(kept).for_each(|(to, x)| *to += share * x);
                }
            }
        }
        row
    }

    /// Returns the fitted heights in Q's coordinates: the value of a form is `qᵀ` times this.
    pub(crate) fn fitted(&self, linear: &LinearProblem, spectrum: &Spectrum) -> Vec<Dd> {
        match self {
            LinearMap::Eigenvectors { removed } => {
                let mut b = linear.factor.qty.clone();
                for (i, &g) in removed.iter().enumerate().filter(|(_, g)| **g != 0.0) {
                    let moved = g * spectrum.a[i];
                    b.iter_mut().zip(spectrum.image.column(i).iter()).for_each(|(b, x)| *b -= Dd::product(moved, *x));
                }
                b
            }
            LinearMap::Oblique { working, .. }
            | LinearMap::Toward { working, .. }
            | LinearMap::Directions { working, .. }
            | LinearMap::Constrained { working, .. }
            | LinearMap::Posterior { working, .. } => {
                let mut image = working.clone();
                multiply_upper_vector(&linear.factor.r, &mut image);
                image
            }
        }
    }

    /// Sharp bound on the bias of `form` for coefficients of norm at most `r` in the scaled
    /// columns; of a posterior, as far from the mean of the prior as it says on average.
    pub(crate) fn bias(&self, form: &Form, columns: &ScaledColumns, r: f64) -> f64 {
        match self {
            LinearMap::Eigenvectors { removed } => r * norm(form.along.iter().zip(removed).map(|(p, g)| p * g)),
            LinearMap::Oblique { removal, .. } | LinearMap::Directions { removal, .. } => {
                let scaled: DVector<f64> = DVector::from_iterator(
                    columns.matrix.ncols(),
                    columns.matrix.column_iter().map(|x| x.iter().zip(&form.q).map(|(x, q)| x.to_f64() * q).sum()),
                );
                r * removal.transposed_times(scaled).norm()
            }
            LinearMap::Posterior { reach, offset, .. } => {
                let of_row = |row: usize| reach.row(row).iter().zip(&form.q).map(|(x, q)| x * q).sum::<f64>();
                norm((0..reach.nrows()).map(of_row)) + dot(offset.as_slice(), &form.q).abs()
            }
            LinearMap::Constrained { reach, .. } => reach * norm(form.q.iter().copied()),
            LinearMap::Toward { factor, bias, .. } => bias.of((1.0 - factor).abs(), r, &form.along),
        }
    }
}
