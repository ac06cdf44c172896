//! Estimable sums: what near dependencies leave known.
//!
//! Terms that share in a near dependency form a group, as do those of dependencies that share a
//! term. With the columns of the group last, `X = Q [R₁ R₁₂; 0 R₂]`: R₂ is the part of the group's
//! columns orthogonal to all others, `R₂ᵀR₂` the information on its coefficients whatever the
//! others are. With `R₂ = U diag(μ) Vᵀ` on columns of unit length the sums `VₖᵀA` are independent,
//! have the standard errors σ/μₖ, and the value `Uₖᵀ(Qᵀy)₂/μₖ`, in which the large coefficients
//! that cancel in the sum never appear. Well determined are those with `μ_max/μₖ` up to 30
//! (Belsley's limit).

use nalgebra::{DMatrix, DVector};

use super::{conclude::Solved, forms::Forms};
use crate::{inference::Noise, regularized::Applied, result::EstimableSum, spectrum::caller_columns};
use flankfit_numerics::{Dd, cancel, jacobi, qr_with_rhs, words::Shown};

/// μ_max/μ up to which a sum is well determined.
const WELL: f64 = 30.0;
/// Sums at most.
const MOST: usize = 100;
/// Number of terms that a sentence names.
const NAMED: usize = 6;

impl Solved<'_> {
    /// The well determined sums of every group of nearly dependent terms, where they are included.
    pub(super) fn estimable(&self, applied: &Applied) -> Option<Vec<EstimableSum>> {
        if !self.spec.include.collinearity || self.frame.collinearity.near_dependencies.is_empty() {
            return None;
        }
        // the weights of a robust estimate are not the inverse variances of the heights
        let weighted = self.robust.is_some_and(|robust| robust.estimate.weights.is_some());
        let noise = self.noise(self.spec.level).filter(|_| !weighted);
        let forms = self.errors.filter(|_| self.spectrum.full_rank()).map(|_| self.forms_at(applied, self.spec.level));
        let mut sums = Vec::new();
        for group in self.groups() {
            cancel::checkpoint();
            if sums.len() < MOST {
                sums.extend(self.of_group(&group, noise.as_ref(), forms.as_ref()));
            }
        }
        sums.truncate(MOST);
        Some(sums)
    }

    /// Terms of near dependencies, joined where these share one.
    fn groups(&self) -> Vec<Vec<usize>> {
        let labels = &self.linear.design.labels;
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for near in &self.frame.collinearity.near_dependencies {
            let mut joined: Vec<usize> =
                near.terms.iter().filter_map(|term| labels.iter().position(|label| label == term)).collect();
            groups.retain(|group| {
                let shares = group.iter().any(|term| joined.contains(term));
                if shares {
                    joined.extend(group);
                }
                !shares
            });
            joined.sort_unstable();
            joined.dedup();
            groups.push(joined);
        }
        groups.retain(|group| group.len() > 1);
        groups
    }

    fn of_group(&self, group: &[usize], noise: Option<&Noise>, forms: Option<&Forms>) -> Vec<EstimableSum> {
        let (factor, n) = (self.linear.factor, self.linear.design.size());
        let caller = caller_columns(factor);
        let length: Vec<f64> =
            caller.column_iter().map(|c| c.iter().map(|x| x.to_f64().powi(2)).sum::<f64>().sqrt()).collect();
        let order: Vec<usize> = (0..n).filter(|j| !group.contains(j)).chain(group.iter().copied()).collect();
        let unit = DMatrix::from_fn(caller.nrows(), n, |i, k| caller[(i, order[k])] / Dd::from(length[order[k]]));
        let right = DVector::from_iterator(factor.qty.len(), factor.qty.iter().copied());
        let turned = qr_with_rhs(unit, right);
        let (size, from) = (group.len(), n - group.len());
        let last = DMatrix::from_fn(size, size, |i, j| turned.r[(from + i, from + j)].to_f64());
        let Some(svd) = jacobi::svd(last) else { return Vec::new() };
        let best = svd.sigma.iter().copied().fold(0.0, f64::max);
        let heights: Vec<f64> = turned.qty.iter().skip(from).map(|x| x.to_f64()).collect();
        let plain = &self.least_squares.coefficients;
        let mut found: Vec<EstimableSum> = (0..size)
            .filter(|&k| svd.sigma[k] * WELL >= best && best > 0.0)
            .map(|k| {
                let v: Vec<f64> = svd.v.column(k).iter().copied().collect();
                let lead = (0..size).fold(0, |lead, j| if v[j].abs() > v[lead].abs() { j } else { lead });
                let one = v[lead] * length[group[lead]];
                // the columns of `us` are Uₖμₖ
                let along: f64 = heights.iter().zip(svd.us.column(k).iter()).map(|(h, u)| h * u).sum();
                let value = along / (svd.sigma[k] * svd.sigma[k]) / one;
                let unit_error = 1.0 / (svd.sigma[k] * one).abs();
                let terms: Vec<String> = group.iter().map(|&j| self.linear.design.labels[j].clone()).collect();
                let weights: Vec<f64> = group.iter().zip(&v).map(|(&j, v)| v * length[j] / one).collect();
                let (std_error, interval) = match forms {
                    None if self.errors.is_some() => (None, None),
                    None => {
                        let half = noise.map(|noise| noise.quantile() * noise.sigma * unit_error);
                        (noise.map(|noise| noise.sigma * unit_error), half.map(|half| [value - half, value + half]))
                    }
                    Some(forms) => {
                        let mut row = vec![Dd::ZERO; n];
                        group.iter().zip(&weights).for_each(|(&j, &w)| row[j] = Dd::from(w));
                        let sum = forms.of_sum(&caller, row);
                        (sum.least_squares_error, forms.interval(&sum, 0.0))
                    }
                };
                let half = interval.map(|[low, high]| 0.5 * (high - low));
                let size = group.iter().zip(&weights).map(|(&j, w)| (w * plain[j]).abs()).fold(0.0, f64::max);
                let digits = digits_of_weights(size, half.unwrap_or(1e-6 * value.abs()));
                EstimableSum {
                    sentence: sentence(&terms, &weights, digits, value, half.map(|half| (half, self.spec.level))),
                    terms,
                    weights,
                    value,
                    std_error,
                    interval,
                    condition_index: best / svd.sigma[k],
                }
            })
            .collect();
        found.sort_by(|a, b| a.condition_index.total_cmp(&b.condition_index));
        found
    }
}

/// Digits that a weight needs for products up to `size` to be right to a tenth of `half`; at least
/// four, at most those of a double.
fn digits_of_weights(size: f64, half: f64) -> i32 {
    let digits = (10.0 * size / half).log10().ceil();
    if digits.is_finite() { (digits as i32 + 1).clamp(4, 17) } else { 4 }
}

/// The sum in words.
fn sentence(terms: &[String], weights: &[f64], digits: i32, value: f64, interval: Option<(f64, f64)>) -> String {
    let half = interval.map(|(half, _)| half);
    let mut text = String::from("cannot be separated, but this sum is determined: ");
    text.insert_str(0, &format!("the coefficients of {} ", listed(terms)));
    for (k, (term, weight)) in terms.iter().zip(weights).take(NAMED).enumerate() {
        let sign = match (k, *weight < 0.0) {
            (0, false) => "",
            (0, true) => "−",
            (_, false) => " + ",
            (_, true) => " − ",
        };
        text.push_str(sign);
        if weight.abs() != 1.0 {
            text.push_str(&format!("{} ", Shown(rounded(weight.abs(), digits))));
        }
        text.push_str(&format!("A[{term}]"));
    }
    if terms.len() > NAMED {
        text.push_str(" + …");
    }
    text.push_str(&format!(" = {}", Shown(rounded(value, digits_of_weights(value.abs(), half.unwrap_or(0.0)).max(6)))));
    if let Some((half, level)) = interval {
        text.push_str(&format!(
            " ± {} with {} % confidence",
            Shown(rounded(half, 2)),
            Shown(rounded(100.0 * level, 6))
        ));
    }
    text
}

fn listed(terms: &[String]) -> String {
    let (named, more) = terms.split_at(terms.len().min(NAMED));
    let more = if more.is_empty() { String::new() } else { format!(" and {} more", more.len()) };
    format!("{}{more}", named.join(", "))
}

/// To so many significant digits.
fn rounded(x: f64, digits: i32) -> f64 {
    if x == 0.0 || !x.is_finite() {
        return x;
    }
    let unit = 10f64.powi(digits - 1 - x.abs().log10().floor() as i32);
    if unit.is_finite() && unit > 0.0 { (x * unit).round() / unit } else { x }
}
