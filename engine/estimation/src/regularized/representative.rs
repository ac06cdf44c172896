//! B made from a representative piece (section 6.3).
//!
//! With V and c of the piece, S its scales and X of the present nodes, the regularised matrix is
//! `X̄ = X (1 + S⁻¹ V diag(c) Vᵀ S)`, and so the estimate (Eq. 29) is `(1 + S⁻¹ V diag(c) Vᵀ S)⁻¹ Â
//! = Â − S⁻¹ V diag(1 − f) Vᵀ S Â` with f = 1/(1 + c): a filter along the directions of the piece.
//! If these are the nodes' own it is the spectral one of the piece's λ*; otherwise part of the
//! error along the smallest eigenvalues remains (`alignment`).

use nalgebra::DMatrix;

use super::{
    context::{Applied, Context},
    linear_map::{Form, LinearMap},
    removal::Removal,
    report::{check_b, regularized_spectrum, report, unregularized},
};
use crate::{
    design::Design,
    diagnostics::perturbation,
    error::{FitError, Unconverged},
    estimate::Estimate,
    factor::multiply_upper_vector,
    problem::{Evidence, matrix_b},
    result::{RegularizationKind, RegularizationReport, RepresentativeReport, Warning},
    selection::Rule,
    spec::{ChosenBy, Domain, FitSpec, Knots, Model, Piece, PolynomialBasis, Representative, Scaling},
    spectrum::caller_columns,
};
use flankfit_numerics::{
    Dd,
    check::Faults,
    jacobi, length, triangular,
    words::{Shown, entries},
};

/// Greatest deviation of posted directions from orthonormal ones.
const ORTHONORMAL: f64 = 1e-8;
/// Directions that lie closer are alike: nine tenths of the variance along the worst go.
const ALIKE: f64 = 0.95;

/// A piece of an iteration where there is no job.
fn no_job() -> Faults {
    let message = "only a fit in a job has iterations: give `piece`";
    Faults::one("regularization.iteration", message)
}

/// A number that has to be above 0.
fn not_above_0(value: f64) -> String {
    format!("{} is not greater than 0", Shown(value))
}

/// Refuses a piece that is not of the model, or none.
pub(super) fn check(asked: &Representative, design: &Design, spec: &FitSpec) -> Result<(), Faults> {
    let Some(piece) = &asked.piece else {
        return Err(no_job());
    };
    let mut faults = Faults::default();
    if spec.scaling == Scaling::Standardized {
        faults.push(
            "scaling",
            "a representative piece needs columns that are not standardised, since its matrix B is added to them",
        );
    }
    if piece.model != spec.model {
        // its domain, scales and directions are that model's too
        faults.push("regularization.piece.model", "the piece has another model, so its directions do not apply");
        return Err(faults);
    }
    if is_mapped(&spec.model) && !same(piece.domain, design.domain) {
        faults.push(
            "regularization.piece.domain",
            "the piece has another domain and so other functions: give the domain of the piece",
        );
    }
    let n = design.size();
    let mut count = |path: &str, given: usize, wanted: usize| {
        if given != wanted {
            faults.push(path, format_args!("{}; there are {wanted}", entries(given)));
        }
        given == wanted
    };
    let mut whole = count("regularization.piece.scale", piece.scale.len(), n);
    whole &= count("regularization.piece.directions", piece.directions.len(), piece.eigenvalues.len());
    for (i, direction) in piece.directions.iter().enumerate() {
        whole &= count(&format!("regularization.piece.directions[{i}]"), direction.len(), n);
    }
    if piece.eigenvalues.is_empty() || piece.eigenvalues.len() > n {
        faults
            .push("regularization.piece.eigenvalues", format_args!("from 1 to {n} eigenvalues, as many as are raised"));
    }
    for (i, lambda) in piece.eigenvalues.iter().enumerate().filter(|(_, l)| !(**l > 0.0 && l.is_finite())) {
        faults.push(format_args!("regularization.piece.eigenvalues[{i}]"), not_above_0(*lambda));
    }
    for (j, scale) in piece.scale.iter().enumerate().filter(|(_, s)| !(**s > 0.0 && s.is_finite())) {
        faults.push(format_args!("regularization.piece.scale[{j}]"), not_above_0(*scale));
    }
    if !(piece.lambda_star > 0.0 && piece.lambda_star.is_finite()) {
        faults.push("regularization.piece.lambda_star", not_above_0(piece.lambda_star));
    }
    if whole {
        for (i, a) in piece.directions.iter().enumerate() {
            let product = |b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let off = |j: usize| (product(&piece.directions[j]) - f64::from(u8::from(i == j))).abs();
            if !(0..=i).all(|j| off(j) <= ORTHONORMAL) {
                faults.push(
                    format_args!("regularization.piece.directions[{i}]"),
                    "directions are orthonormal; this one is not",
                );
            }
        }
    }
    faults.into_result(())
}

/// True if the functions of a model depend on its domain.
fn is_mapped(model: &Model) -> bool {
    match model {
        Model::Polynomial { basis, .. } => *basis != PolynomialBasis::Monomial,
        Model::BSpline { knots, .. } => matches!(knots, Knots::Spans(_) | Knots::SpansEach(..)),
        Model::Linear => false,
    }
}

fn same(a: Option<Domain>, b: Option<Domain>) -> bool {
    let (a, b) = (a.unwrap_or_default(), b.unwrap_or_default());
    a.u == b.u && a.v == b.v
}

/// Error for a piece without singular values: a number whose squares exceed the range of double, if
/// it has one.
fn exceeds_double(piece: &Piece) -> FitError {
    let far = |x: f64| !(1e-150..=1e150).contains(&x);
    let place = |list: &[f64]| list.iter().position(|&x| far(x));
    let path = if far(piece.lambda_star) {
        Some("lambda_star".to_owned())
    } else {
        let scale = place(&piece.scale).map(|j| format!("scale[{j}]"));
        scale.or_else(|| place(&piece.eigenvalues).map(|i| format!("eigenvalues[{i}]")))
    };
    match path {
        Some(path) => Faults::one(
            format_args!("regularization.piece.{path}"),
            "results computed from it exceed the range of double precision: send the data that a fit returned",
        )
        .into(),
        None => FitError::NotConverged(Unconverged::SingularValues),
    }
}

/// Regularises by the matrix B of the piece.
pub(super) fn apply(
    context: &Context,
    asked: &Representative,
    warnings: &mut Vec<Warning>,
) -> Result<Applied, FitError> {
    let Context { spec, linear, columns, spectrum, least_squares, .. } = *context;
    let Some(piece) = &asked.piece else {
        return Err(no_job().into());
    };
    if !spectrum.full_rank() {
        return Err(Faults::one(
            "regularization",
            "the nodes do not determine every coefficient, with or without a piece: use fewer terms",
        )
        .into());
    }
    let n = linear.design.size();
    let filter = Filter::new(context, piece);
    let (coefficients, working) = filter.estimate(context);
    let filtered: Vec<_> = spectrum.lambda.iter().map(|&lambda| Rule::None.at(0, lambda, 0.0)).collect();
    let plain = Estimate::new(columns, spectrum, &filtered, least_squares);
    let removal = filter.removal(columns.scale.iter().map(|s| s.to_f64()).collect());
    let not_converged = || exceeds_double(piece);
    let largest = jacobi::svd(removal.clone()).ok_or_else(not_converged)?.sigma.last().copied().unwrap_or(0.0);
    let alignment = filter.alignment(context).ok_or_else(not_converged)?;
    if alignment < ALIKE {
        warnings.push(Warning::PieceMisaligned { alignment });
    }
    let (eigenvalues, matrix_norm_squared) = filter.spectrum(context).ok_or_else(not_converged)?;
    let after = regularized_spectrum(eigenvalues);
    let map = LinearMap::Directions {
        images: filter.images.map(|x| x.to_f64()),
        forms: filter.forms.map(|x| x.to_f64()),
        removed: filter.removed.clone(),
        removal: Removal::Whole(removal),
        working: working.clone(),
    };
    let inverse = triangular::inverse_upper(&caller_columns(linear.factor)).map(|x| x.to_f64());
    let forms: Vec<Form> = (0..n).map(|j| Form::new(inverse.row(j).iter().copied().collect(), spectrum)).collect();
    let moved: Vec<f64> = coefficients.iter().zip(&least_squares.coefficients).map(|(a, b)| a - b).collect();
    let r = context.norm_limit(context.norm_of(&coefficients), warnings);
    let residuals = linear.of_working(&working, spec.include.residuals);
    let matrix_b = filter.matrix_b(context, warnings)?;
    filter.warn_of_missing(context, warnings);
    let factors = filter.removed.iter().map(|removed| 1.0 - removed);
    Ok(Applied {
        rss: residuals.rss,
        residuals,
        after: Some(perturbation::Estimate {
            condition: after.condition,
            largest: after.eigenvalues.iter().copied().fold(0.0, f64::max),
            norm: context.norm_of(&coefficients),
        }),
        regularization: RegularizationReport {
            scheme: Some(piece.scheme),
            count: Some(piece.eigenvalues.len()),
            lambda_star: Some(piece.lambda_star),
            criterion: Some(ChosenBy::Fixed),
            filter_factors: factors.chain(std::iter::repeat(1.0)).take(n).collect(),
            matrix_norm_squared: Some(matrix_norm_squared),
            representative: Some(RepresentativeReport { of: asked.of.clone(), alignment }),
            choices: unregularized(context).choices,
            ..report(RegularizationKind::Representative)
        },
        spectrum: after,
        bias: context.bias(context.norm_of(&moved), r * largest, r),
        bounds: forms.iter().map(|form| map.bias(form, columns, r)).collect(),
        curve: None,
        trace: None,
        matrix_b,
        matrix_b_factors: None,
        estimate: Estimate {
            spread: forms.iter().map(|form| length(&map.row(form, spectrum))).collect(),
            coefficients,
            ..plain
        },
        map,
        prior: None,
        constraints: None,
        representative: None,
    })
}

/// The directions of the piece as the nodes see them.
struct Filter<'a> {
    piece: &'a Piece,
    /// 1 − fᵢ.
    removed: Vec<f64>,
    /// Column i is `X S⁻¹ Vᵢ` in Q's coordinates.
    images: DMatrix<Dd>,
    /// Column i is `Vᵢᵀ S A` as a form in Q's coordinates.
    forms: DMatrix<Dd>,
}

impl<'a> Filter<'a> {
    fn new(context: &Context, piece: &'a Piece) -> Self {
        let n = context.linear.design.size();
        let columns = caller_columns(context.linear.factor);
        let count = piece.directions.len();
        let (mut images, mut forms) =
            (DMatrix::from_element(n, count, Dd::ZERO), DMatrix::from_element(n, count, Dd::ZERO));
        for (i, direction) in piece.directions.iter().enumerate() {
            let mut image: Vec<Dd> = direction.iter().zip(&piece.scale).map(|(v, s)| Dd::from(*v) / *s).collect();
            multiply_upper_vector(&columns, &mut image);
            images.column_mut(i).copy_from_slice(&image);
            let mut form: Vec<Dd> = direction.iter().zip(&piece.scale).map(|(v, s)| Dd::product(*v, *s)).collect();
            triangular::solve_upper_transposed(&columns, &mut form);
            forms.column_mut(i).copy_from_slice(&form);
        }
        let removed = (0..count).map(|i| piece.coefficient(i)).map(|c| c / (1.0 + c)).collect();
        Filter { piece, removed, images, forms }
    }

    /// The coefficients of the caller, and those of the working basis.
    fn estimate(&self, context: &Context) -> (Vec<f64>, Vec<Dd>) {
        let factor = context.linear.factor;
        let mut caller = context.least_squares.working.clone();
        triangular::solve_upper(&factor.change, &mut caller);
        for ((direction, removed), form) in
            self.piece.directions.iter().zip(&self.removed).zip(self.forms.column_iter())
        {
            // from the heights: the coefficients that cancel in it are not formed
            let along = form.iter().zip(&factor.qty).fold(Dd::ZERO, |sum, (&q, &b)| sum + q * b) * *removed;
            for ((to, v), s) in caller.iter_mut().zip(direction).zip(&self.piece.scale) {
                *to -= along * *v / *s;
            }
        }
        let mut working = caller.clone();
        multiply_upper_vector(&factor.change, &mut working);
        (caller.iter().map(|x| x.to_f64()).collect(), working)
    }

    /// Removed part of the coefficients as a matrix, in columns divided by `scale`.
    fn removal(&self, scale: Vec<f64>) -> DMatrix<f64> {
        let piece = self.piece;
        let ratio: Vec<f64> = scale.iter().zip(&piece.scale).map(|(own, of_piece)| own / of_piece).collect();
        let n = scale.len();
        DMatrix::from_fn(n, n, |j, k| {
            let share = |(v, removed): (&Vec<f64>, &f64)| removed * v[j] * v[k];
            ratio[j] / ratio[k] * piece.directions.iter().zip(&self.removed).map(share).sum::<f64>()
        })
    }

    /// Cosine of the largest angle between what is removed and the nodes' own directions with the
    /// smallest eigenvalues.
    fn alignment(&self, context: &Context) -> Option<f64> {
        let (own, count) = (&context.spectrum.v, self.piece.directions.len());
        let mut basis: Vec<Vec<f64>> = Vec::new();
        for direction in &self.piece.directions {
            let scales = context.columns.scale.iter().zip(&self.piece.scale);
            let mut v: Vec<f64> = direction.iter().zip(scales).map(|(v, (own, s))| v * own.to_f64() / s).collect();
            for _ in 0..2 {
                for q in &basis {
                    let along: f64 = q.iter().zip(&v).map(|(q, v)| q * v).sum();
                    v.iter_mut().zip(q).for_each(|(v, q)| *v -= along * q);
                }
            }
            let length = v.iter().map(|v| v * v).sum::<f64>().sqrt();
            basis.push(v.iter().map(|v| v / length).collect());
        }
        let cosine = |i: usize, k: usize| own.column(i).iter().zip(&basis[k]).map(|(v, q)| v * q).sum::<f64>();
        let found = jacobi::svd(DMatrix::from_fn(count, count, cosine))?;
        Some(found.sigma.first().copied().unwrap_or(0.0).min(1.0))
    }

    /// Eigenvalues of X̄ᵀX̄ and ‖B‖², in the scaled columns.
    fn spectrum(&self, context: &Context) -> Option<(Vec<f64>, f64)> {
        let columns = context.columns;
        let mut matrix = columns.matrix.clone();
        let mut norm = 0.0;
        for k in 0..matrix.ncols() {
            let mut added = vec![Dd::ZERO; matrix.nrows()];
            for (i, direction) in self.piece.directions.iter().enumerate() {
                // c Vᵀ S, in the scaled columns of now
                let share =
                    Dd::product(self.piece.coefficient(i) * direction[k], self.piece.scale[k]) / columns.scale[k];
                added.iter_mut().zip(self.images.column(i).iter()).for_each(|(to, &x)| *to += x * share);
            }
            norm += added.iter().map(|x| x.to_f64().powi(2)).sum::<f64>();
            matrix.column_mut(k).iter_mut().zip(added).for_each(|(to, x)| *to += x);
        }
        let found = jacobi::svd(matrix.map(|x| x.to_f64()))?;
        Some((found.sigma.iter().map(|s| s * s).collect(), norm))
    }

    /// Rows of B, where they were included.
    fn matrix_b(&self, context: &Context, warnings: &mut Vec<Warning>) -> Result<Option<Vec<Vec<f64>>>, FitError> {
        let linear = context.linear;
        if !context.spec.include.matrix_b {
            return Ok(None);
        }
        let Evidence::Posted { sample, .. } = linear.evidence else {
            warnings.push(Warning::MatrixBNeedsNodes);
            return Ok(None);
        };
        let (rows, columns) = (sample.count(), linear.design.size());
        check_b(rows, columns)?;
        let images = self.images.map(|x| x.to_f64());
        let directions = &self.piece.directions;
        let v = DMatrix::from_fn(columns, directions.len(), |j, i| directions[i][j]);
        let c: Vec<f64> = (0..directions.len()).map(|i| self.piece.coefficient(i)).collect();
        Ok(Some(matrix_b(linear.design, sample, linear.factor, &images, &v, &c, &self.piece.scale)))
    }

    fn warn_of_missing(&self, context: &Context, warnings: &mut Vec<Warning>) {
        let include = context.spec.include;
        if include.lambda_curve {
            warnings.push(Warning::NoLambdaOf { regularization: "representative" });
        }
        if include.representative {
            warnings.push(Warning::NoPieceToGive);
        }
        context.warn_of_trace(warnings);
    }
}
