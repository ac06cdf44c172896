//! Multicollinearity (Eqs. 24–26): which columns of X almost depend on each other, in words that
//! can be acted on.
//!
//! On unit-length columns: eigenvectors of small eigenvalues as weights, condition indices
//! `√(λₙ/λᵢ)` and variance decomposition proportions (Belsley, Kuh and Welsch); on centred columns:
//! correlations and variance inflation.

use std::{cmp::Reverse, fmt::Write};

use nalgebra::DMatrix;

use super::{
    design::Design,
    factor::Factor,
    result::{CollinearityReport, ColumnCollinearity, NearDependency, Warning, Written},
    spectrum::Directions,
};
use crate::numerics::{
    Dd,
    cancel::{self, Asking},
    lanes::{self, F64Lanes, Lanes},
    triangular,
};

/// Condition index beyond which a dependency is called near (Belsley's rule).
const NEAR: f64 = 30.0;
/// A weight this large against the largest one takes part in a dependency.
const LARGE: f64 = 0.3;
/// So does a column that owes this share of its coefficient's variance to it, however small its
/// weight (Belsley, Kuh and Welsch): without that column the others would be told apart far better.
const SHARE: f64 = 0.5;
/// Squared weight of a column that takes part in an exact dependency.
const NUMERICALLY_ZERO: f64 = 1e-12;
/// Up to how many coefficients the two n×n matrices are given unasked.
pub const MATRICES_UP_TO: usize = 64;
/// How many near dependencies are told at most.
const MOST_TOLD: usize = 100;

/// The report for `caller` (the caller's columns in Q's coordinates) with the spectrum of its
/// unit-length columns.
pub fn report(
    design: &Design,
    factor: &Factor,
    caller: &DMatrix<Dd>,
    unit: &Directions,
    weight: f64,
    all_matrices: bool,
    warnings: &mut Vec<Warning>,
) -> CollinearityReport {
    let n = design.size();
    let plain = caller.map(|x| x.to_f64());
    let length = lengths(&plain);
    let centred = centred(design, factor, caller, weight);
    let deviation = lengths(&centred.matrix);
    // a column whose spread is lost in rounding is a constant
    let varies = |j: usize| deviation[j] > 1e-13 * length[j];
    let matrices = n <= MATRICES_UP_TO || all_matrices;
    let correlation = matrices.then(|| correlations(&centred.matrix, &deviation, varies));
    let shares = Shares::new(unit);
    let mut infinite = Vec::new();
    let columns = (0..n)
        .map(|j| {
            let vif = if Some(j) == design.constant || !varies(j) {
                None
            } else if shares.undetermined[j] {
                infinite.push(design.labels[j].as_str());
                None
            } else {
                let own = shares.total[j] / (length[j] * length[j]);
                let joint = centred.beyond.as_ref().map_or(0.0, |(along, rest)| along[j] * along[j] / rest);
                Some((deviation[j] * deviation[j] * (own + joint)).max(1.0))
            };
            ColumnCollinearity { term: design.labels[j].clone(), vif }
        })
        .collect();
    if !infinite.is_empty() {
        warnings.push(Warning {
            code: "vif_infinite",
            message: format!(
                "no variance inflation factor for {}: the column depends on others exactly",
                infinite.join(", ")
            ),
        });
    }
    CollinearityReport {
        written: Written::default(),
        columns,
        correlation,
        variance_proportions: matrices.then(|| shares.proportions(unit)),
        near_dependencies: near_dependencies(design, &plain, &length, unit, &shares),
    }
}

/// Pearson correlations of centred columns; a column that does not vary has none with any other
/// (0).
fn correlations(centred: &DMatrix<f64>, deviation: &[f64], varies: impl Fn(usize) -> bool) -> Vec<Vec<f64>> {
    let n = deviation.len();
    let rows = centred.nrows();
    let columns: Vec<&[f64]> = centred.as_slice().chunks_exact(rows).collect();
    let mut out = vec![vec![0.0; n]; n];
    for i in 0..n {
        cancel::every(n * n, i);
        out[i][i] = 1.0;
        for j in 0..i {
            if varies(i) && varies(j) {
                let value = (dot(columns[i], columns[j]) / (deviation[i] * deviation[j])).clamp(-1.0, 1.0);
                (out[i][j], out[j][i]) = (value, value);
            }
        }
    }
    out
}

/// A scalar product, four sums side by side.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a4, a_rest), (b4, b_rest)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    dot4(a4, b4) + rest
}

#[inline(always)]
fn dot4(a: &[[f64; 4]], b: &[[f64; 4]]) -> f64 {
    let mut sums = [0.0; 4];
    for (a, b) in a.iter().zip(b) {
        for k in 0..4 {
            sums[k] = a[k].mul_add(b[k], sums[k]);
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

/// Lengths of the columns.
fn lengths(matrix: &DMatrix<f64>) -> Vec<f64> {
    matrix.as_slice().chunks_exact(matrix.nrows()).map(|column| dot(column, column).sqrt()).collect()
}

/// Terms that take part in a direction, the leading one first: those with large weights, and those
/// of which `owes` says so.
fn partners(weights: &[f64], owes: impl Fn(usize) -> bool) -> Vec<usize> {
    let largest = weights.iter().map(|w| w.abs()).fold(0.0, f64::max);
    // moduli stand in the order of their bits
    let mut terms: Vec<(Reverse<u64>, usize)> = weights
        .iter()
        .map(|w| w.abs())
        .enumerate()
        .filter(|(j, w)| *w >= LARGE * largest || owes(*j))
        .map(|(j, w)| (Reverse(w.to_bits()), j))
        .collect();
    terms.sort_unstable();
    terms.into_iter().map(|(_, j)| j).collect()
}

/// Terms that take part in an exact dependency, the leading one first.
pub fn dependent_terms(weights: &[f64]) -> Vec<usize> {
    partners(weights, |j| weights[j] * weights[j] > NUMERICALLY_ZERO)
}

/// Centred columns in Q's coordinates.
struct Centred {
    matrix: DMatrix<f64>,
    /// Where the constant lies outside the span of the columns: its coefficients on them, and what
    /// is left of it.
    beyond: Option<(Vec<f64>, f64)>,
}

fn centred(design: &Design, factor: &Factor, caller: &DMatrix<Dd>, weight: f64) -> Centred {
    let n = caller.ncols();
    let dot = |a: &dyn Fn(usize) -> Dd, b: usize| (0..n).fold(Dd::ZERO, |sum, k| sum + a(k) * caller[(k, b)]);
    if design.constant == Some(0) && (1..n).all(|k| caller[(k, 0)] == Dd::ZERO) {
        // Q's first direction is the constant itself: centring drops the first row
        let mut matrix = caller.map(|x| x.to_f64());
        matrix.row_mut(0).fill(0.0);
        return Centred { matrix, beyond: None };
    }
    let constant: Vec<Dd> = match (design.constant, &factor.ones) {
        (Some(index), _) => (0..n).map(|k| caller[(k, index)]).collect(),
        (None, Some(ones)) => {
            let mut direction: Vec<Dd> = ones.iter().map(|&x| Dd::from(x)).collect();
            if factor.working.is_some() {
                triangular::solve_upper_transposed(&factor.r, &mut direction);
            } else {
                direction.fill(Dd::ZERO);
            }
            direction
        }
        // a full grid of B-splines: their sum is 1 everywhere
        (None, None) => {
            let sum = |k: usize| (0..n).fold(Dd::ZERO, |sum, j| sum + factor.r[(k, j)]);
            (0..n).map(sum).collect()
        }
    };
    let own = constant.iter().fold(Dd::ZERO, |sum, &x| sum + x * x).to_f64();
    let whole = if design.constant.is_some() { own } else { weight };
    let rest = whole - own;
    let outside = design.constant.is_none() && rest > 1e-10 * whole;
    let mut matrix = DMatrix::zeros(n + 1, n);
    for j in (0..n).asking(20 * n) {
        let mean = dot(&|k| constant[k], j) / whole;
        for k in 0..n {
            matrix[(k, j)] = (caller[(k, j)] - mean * constant[k]).to_f64();
        }
        if outside {
            matrix[(n, j)] = mean.to_f64() * rest.sqrt();
        }
    }
    let beyond = outside.then(|| {
        let mut along = constant.clone();
        triangular::solve_upper(&triangular::multiply_upper(&factor.r, &factor.change), &mut along);
        (along.iter().map(|x| x.to_f64()).collect(), rest)
    });
    Centred { matrix, beyond }
}

/// How the variance of each unit-length column's coefficient is shared among the directions.
struct Shares {
    /// `Σᵢ V_ji²/λᵢ` over directions told from 0.
    total: Vec<f64>,
    /// Whether the coefficient takes part in an exact dependency.
    undetermined: Vec<bool>,
    /// `Σᵢ V_ji²` over the directions that are not told from 0.
    lost: Vec<f64>,
}

impl Shares {
    fn new(unit: &Directions) -> Self {
        let n = unit.v.nrows();
        let (mut total, mut lost, mut undetermined) = (vec![0.0; n], vec![0.0; n], vec![false; n]);
        for (i, &lambda) in unit.lambda.iter().enumerate() {
            for j in 0..n {
                let square = unit.v[(j, i)] * unit.v[(j, i)];
                if lambda > 0.0 {
                    total[j] += square / lambda;
                } else {
                    undetermined[j] |= square > NUMERICALLY_ZERO;
                    lost[j] += square;
                }
            }
        }
        Shares { total, undetermined, lost }
    }

    /// Whether term j owes most of its variance to a direction of eigenvalue `lambda` in which it
    /// has the weight `weight`.
    fn owes(&self, j: usize, weight: f64, lambda: f64) -> bool {
        let square = weight * weight;
        match (self.undetermined[j], lambda > 0.0) {
            (true, false) => square >= SHARE * self.lost[j],
            (false, true) => square / lambda >= SHARE * self.total[j],
            _ => false,
        }
    }

    /// Per term, one share for each eigenvalue; an exact dependency takes all of it.
    fn proportions(&self, unit: &Directions) -> Vec<Vec<f64>> {
        let n = unit.v.nrows();
        let inverse: Vec<f64> = unit.lambda.iter().map(|&l| if l > 0.0 { 1.0 / l } else { 0.0 }).collect();
        let exact: Vec<f64> = unit.lambda.iter().map(|&l| if l > 0.0 { 0.0 } else { 1.0 }).collect();
        (0..n)
            .map(|j| {
                let by = if self.undetermined[j] { &exact } else { &inverse };
                let mut row: Vec<f64> = (0..n).map(|i| unit.v[(j, i)] * unit.v[(j, i)] * by[i]).collect();
                let sum: f64 = row.iter().sum();
                if sum > 0.0 {
                    row.iter_mut().for_each(|share| *share /= sum);
                }
                row
            })
            .collect()
    }
}

fn near_dependencies(
    design: &Design,
    plain: &DMatrix<f64>,
    length: &[f64],
    unit: &Directions,
    shares: &Shares,
) -> Vec<NearDependency> {
    let largest = unit.largest();
    let (mut found, mut room) = (Vec::new(), Vec::new());
    let (columns, stride) = unit_columns(plain, length);
    for (i, &lambda) in unit.lambda.iter().enumerate().take(MOST_TOLD) {
        let index = (lambda > 0.0).then(|| (largest / lambda).sqrt());
        if index.is_some_and(|index| index <= NEAR) {
            break;
        }
        let rows = unit.v.nrows();
        let weights = unit.v.as_slice()[i * rows..(i + 1) * rows].to_vec();
        let terms = partners(&weights, |j| shares.owes(j, weights[j], lambda));
        let names: Vec<String> = terms.iter().map(|&j| design.labels[j].clone()).collect();
        let (mut cosine, mut weight_ratio, mut r_squared, mut pair) = (None, None, None, None);
        let between =
            |a: usize, b: usize| (plain.column(a).dot(&plain.column(b)) / (length[a] * length[b])).clamp(-1.0, 1.0);
        if let [a, b] = terms[..] {
            cosine = Some(between(a, b));
            weight_ratio = Some(-weights[a].min_by_modulus(weights[b]));
        } else if let [a, b, _, ..] = terms[..] {
            pair = Some(between(a, b)).filter(|cosine| pair_index(*cosine) > NEAR);
            r_squared = Some(explained(&columns, stride, &terms, &mut room));
        }
        found.push(NearDependency {
            sentence: sentence(&names, cosine, r_squared, index, pair),
            eigenvalue: lambda,
            condition_index: index,
            weights,
            terms: names,
            cosine,
            weight_ratio,
            r_squared,
        });
    }
    found
}

/// The columns divided by their lengths, and how many lanes each has.
fn unit_columns(plain: &DMatrix<f64>, length: &[f64]) -> (Vec<F64Lanes>, usize) {
    let stride = lanes::lanes_for(plain.nrows());
    let mut unit = vec![F64Lanes::ZERO; stride * length.len()];
    let columns = plain.as_slice().chunks_exact(plain.nrows());
    for ((to, from), length) in unit.chunks_exact_mut(stride).zip(columns).zip(length) {
        let inverse = 1.0 / length;
        for (to, from) in to.iter_mut().zip(from.chunks(lanes::WIDTH)) {
            from.iter().enumerate().for_each(|(k, x)| to.set(k, x * inverse));
        }
    }
    (unit, stride)
}

trait Ratio {
    fn min_by_modulus(self, other: f64) -> f64;
}

impl Ratio for f64 {
    /// The ratio of two weights, the smaller over the larger (Eq. 26).
    fn min_by_modulus(self, other: f64) -> f64 {
        if self.abs() <= other.abs() { self / other } else { other / self }
    }
}

/// R² (about 0) of the first of `terms` on the others: modified Gram–Schmidt on the columns, the
/// first one last. `unit` has the columns of unit length, each of `stride` lanes.
fn explained(unit: &[F64Lanes], stride: usize, terms: &[usize], room: &mut Vec<F64Lanes>) -> f64 {
    room.clear();
    for &j in terms[1..].iter().chain(&terms[..1]) {
        room.extend_from_slice(&unit[j * stride..(j + 1) * stride]);
    }
    // columns are taken four at a time: behind the last one stand some of zeros
    room.resize((terms.len() + 3) * stride, F64Lanes::ZERO);
    let mut rest = &mut room[..];
    for _ in (1..terms.len()).asking(terms.len() * terms.len()) {
        let (direction, after) = rest.split_at_mut(stride);
        let square: f64 = lanes::dot(direction, direction);
        if square > 1e-30 {
            after.chunks_exact_mut(4 * stride).for_each(|four| remove(direction, -1.0 / square, four));
        }
        rest = after;
    }
    let last = &rest[..stride];
    1.0 - lanes::dot::<f64>(last, last)
}

/// `x += factor (d·x) d` for four columns x, one behind the other.
#[inline(never)]
fn remove(d: &[F64Lanes], factor: f64, columns: &mut [F64Lanes]) {
    let n = d.len();
    let (a, columns) = columns.split_at_mut(n);
    let (b, columns) = columns.split_at_mut(n);
    let (c, e) = columns.split_at_mut(n);
    let e = &mut e[..n];
    let mut along = [F64Lanes::ZERO; 4];
    for k in 0..n {
        let d = d[k];
        along = [
            along[0].accumulate(d, a[k]),
            along[1].accumulate(d, b[k]),
            along[2].accumulate(d, c[k]),
            along[3].accumulate(d, e[k]),
        ];
    }
    let along = along.map(|sum| sum.total() * factor);
    for k in 0..n {
        let d = d[k];
        a[k] = a[k].add_scaled(along[0], d);
        b[k] = b[k].add_scaled(along[1], d);
        c[k] = c[k].add_scaled(along[2], d);
        e[k] = e[k].add_scaled(along[3], d);
    }
}

/// Condition index of two columns of unit length with this cosine, if there were no others.
fn pair_index(cosine: f64) -> f64 {
    ((1.0 + cosine.abs()) / (1.0 - cosine.abs())).sqrt()
}

/// How many terms a sentence names; `terms` has all of them.
const NAMED: usize = 4;

/// What a person reads. `pair` is the cosine of the two leading terms, where they are nearly
/// parallel without the others.
#[inline(never)]
fn sentence(
    names: &[String],
    cosine: Option<f64>,
    r_squared: Option<f64>,
    index: Option<f64>,
    pair: Option<f64>,
) -> String {
    // as many digits as it takes to see the difference from 1
    let near_one = |x: f64| {
        let digits = (-(1.0 - x.abs()).max(1e-12).log10()).ceil().clamp(3.0, 12.0) as i32;
        let unit = 10f64.powi(digits);
        (x * unit).round() / unit
    };
    let mut text = String::with_capacity(192);
    let ends = match (names, cosine, r_squared) {
        ([a, b], Some(cosine), _) => {
            let parallel = if cosine < 0.0 { "opposite" } else { "parallel" };
            for part in [a, " and ", b, " are nearly ", parallel, " over these nodes (cos = "] {
                text.push_str(part);
            }
            append(&mut text, near_one(cosine));
            text.push_str(", ");
            "): only their mixture is well determined"
        }
        ([a, others @ ..], _, Some(r_squared)) => {
            text.push_str(a);
            let (named, more) = others.split_at(others.len().min(NAMED - 1));
            for (k, name) in named.iter().enumerate() {
                text.push_str(if k == 0 { " is nearly a mixture of " } else { ", " });
                text.push_str(name);
            }
            if !more.is_empty() {
                text.push_str(" and ");
                append(&mut text, more.len());
                text.push_str(" more");
            }
            text.push_str(" over these nodes (R² = ");
            append(&mut text, near_one(r_squared));
            text.push_str(", ");
            "): their coefficients cannot be told apart"
        }
        ([a, ..], _, _) => {
            for part in ["the column ", a, " is nearly 0 over these nodes ("] {
                text.push_str(part);
            }
            ")"
        }
        ([], _, _) => return text,
    };
    append_index(&mut text, index);
    text.push_str(ends);
    if let (Some(cosine), [a, b, ..]) = (pair, names) {
        for part in ["; of them ", a, " and ", b, " alone have cos = "] {
            text.push_str(part);
        }
        append(&mut text, near_one(cosine));
        text.push_str(", ");
        append_index(&mut text, Some(pair_index(cosine)));
    }
    text
}

fn append_index(text: &mut String, index: Option<f64>) {
    text.push_str("condition index ");
    match index.filter(|index| index.is_finite()) {
        None => text.push_str("infinite"),
        // condition indices are read by their order of magnitude
        Some(index) if index < 1e15 => append(text, index.round() as u64),
        Some(index) => append(text, format_args!("{index:.1e}")),
    }
}

fn append(text: &mut String, value: impl std::fmt::Display) {
    // writing to a String does not fail
    let _written = write!(text, "{value}");
}
