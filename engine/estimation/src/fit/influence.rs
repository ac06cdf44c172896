//! Leverages, studentised and deletion residuals, Cook's distance and DFFITS of every node.
//!
//! In Q's coordinates node i is the row qᵢ, `√Ω X A = Q b`; the estimate of a row q is `ρ(q)ᵀb`
//! ([`crate::regularized::LinearMap`]). So the matrix `H = X(XᵀX + K)⁻¹Xᵀ` has the entries
//! `qᵢᵀρ(qⱼ)`, whatever the regularisation, and no inverse is formed. With the penalty K held,
//! leaving node i out moves the fitted heights by `H eᵢ rᵢ/(1 − hᵢ)`, and `‖H eᵢ‖ = ‖ρ(qᵢ)‖`.
//!
//! References: Belsley, Kuh and Welsch (1980), chapter 2; Cook and Weisberg (1982); for penalised
//! estimates Eubank and Gunst (Journal of the Royal Statistical Society B 48, 1986).

use super::conclude::Solved;
use crate::{
    data::Sample,
    problem::{Evidence, Rows},
    regularized::{Applied, Form, LinearMap},
    result::{Influence, Warning},
};
use flankfit_numerics::{cancel::Asking, dot};

/// Products `nodes × coefficients²` at most: some seconds.
const MOST_PRODUCTS: usize = 1_000_000_000;
/// Nodes at most: 25 MB of answer.
const MOST_NODES: usize = 200_000;
/// 1 − h below this is 0 to rounding: the other nodes do not determine the fit there.
const UNDETERMINED: f64 = 1e-10;
/// A node whose share of the residual sum of squares is above 1 less this leaves an exact fit of
/// the others, but for rounding.
const EXACT_WITHOUT: f64 = 1e-12;

/// Nodes of so many coefficients at most.
fn most(coefficients: usize) -> usize {
    (MOST_PRODUCTS / (coefficients * coefficients).max(1)).min(MOST_NODES)
}

/// Coordinates and residuals of one node in Q's coordinates.
struct Share {
    /// 1 less the leverage in plain least squares.
    left_plain: f64,
    /// hᵢ and 1 − hᵢ.
    leverage: f64,
    left: f64,
    /// ‖ρ(qᵢ)‖².
    reach: f64,
}

impl Solved<'_> {
    /// Influence of each node; `None` if it was not requested or does not exist.
    pub(super) fn influence(&self, applied: &Applied, warnings: &mut Vec<Warning>) -> Option<Influence> {
        if !self.spec.include.influence {
            return None;
        }
        let Evidence::Posted { sample, .. } = self.linear.evidence else { return None };
        if self.robust.is_some() {
            warnings.push(Warning::NoInfluenceOfRobust);
            return None;
        }
        if !self.spectrum.full_rank() {
            warnings.push(Warning::NoInfluence);
            return None;
        }
        let (nodes, most) = (sample.count(), most(self.linear.design.size()));
        if nodes > most {
            warnings.push(Warning::InfluenceOfMany { nodes, most });
            return None;
        }
        let residuals = applied.residuals.values.as_deref()?;
        let plain = match applied.map.is_identity() {
            true => residuals.to_vec(),
            false => self.linear.of_working(&self.least_squares.working, true).values.unwrap_or_default(),
        };
        let shares = self.shares(&applied.map, sample);
        let figures = Figures {
            sample,
            shares: &shares,
            residuals,
            plain: &plain,
            sigma: self.sigma,
            rss: self.least_squares_rss,
            freedom: self.degrees_of_freedom,
        };
        let found = figures.influence();
        let silent = figures.silent();
        if !silent.is_empty() {
            let posted = silent.iter().take(10).map(|&k| sample.posted(k)).collect();
            let (nodes, count) = (posted, silent.len());
            warnings.push(match self.least_squares_rss == 0.0 {
                true => Warning::AllExact { nodes, count },
                false => Warning::NoNoiseWithout { nodes, count },
            });
        }
        let lost: Vec<usize> = (0..shares.len()).filter(|&k| !shares[k].determined()).collect();
        if !lost.is_empty() {
            let posted = lost.iter().take(10).map(|&k| sample.posted(k)).collect();
            warnings.push(Warning::FullLeverage { nodes: posted, count: lost.len() });
        }
        Some(found)
    }

    fn shares(&self, map: &LinearMap, sample: &Sample) -> Vec<Share> {
        let rows = Rows::new(self.linear.design, sample, &self.linear.factor.r);
        let n = self.linear.design.size();
        let plain_map = map.is_identity();
        (0..sample.count())
            .asking(4 * n * n)
            .map(|k| {
                let (q, left_plain) = rows.at(k);
                let plain = dot(&q, &q);
                if plain_map {
                    return Share { left_plain, leverage: plain, left: left_plain, reach: plain };
                }
                let form = Form::new(q, &self.spectrum);
                let row = map.row(&form, &self.spectrum);
                // both parts are positive: nothing cancels where a leverage is near 1
                let left = left_plain + map.removed_of(&form, &self.spectrum);
                Share { left_plain, leverage: dot(&form.q, &row), left, reach: dot(&row, &row) }
            })
            .collect()
    }
}

impl Share {
    fn determined(&self) -> bool {
        self.left > UNDETERMINED
    }
}

/// Everything that the figures are made of.
struct Figures<'a> {
    sample: &'a Sample<'a>,
    shares: &'a [Share],
    /// Residuals of the estimate, and of plain least squares.
    residuals: &'a [f64],
    plain: &'a [f64],
    sigma: Option<f64>,
    /// Residual sum of squares of plain least squares.
    rss: f64,
    freedom: usize,
}

impl Figures<'_> {
    fn influence(&self) -> Influence {
        let each = |f: &dyn Fn(usize, &Share) -> Option<f64>| -> Vec<Option<f64>> {
            (0..self.shares.len())
                .map(|k| Some(&self.shares[k]).filter(|share| share.determined()).and_then(|share| f(k, share)))
                .collect()
        };
        let existing = |x: f64| Some(x).filter(|x| !x.is_nan() && x.is_finite());
        let weighted = |k: usize| self.sample.w(k).sqrt() * self.residuals[k];
        let press_residual = each(&|k, share| existing(self.residuals[k] / share.left));
        let press =
            press_residual.iter().enumerate().map(|(k, r)| r.map(|r| self.sample.w(k) * r * r)).sum::<Option<f64>>();
        let total: f64 = self.shares.iter().map(|share| share.leverage).sum();
        let others = (self.freedom > 1).then_some(());
        Influence {
            // 1 is exceeded by rounding only
            leverage: self.shares.iter().map(|share| share.leverage.min(1.0)).collect(),
            internally_studentized: self
                .sigma
                .map(|sigma| each(&|k, share| existing(weighted(k) / (sigma * share.left.sqrt())))),
            externally_studentized: others
                .map(|()| each(&|k, share| existing(weighted(k) / (self.sigma_without(k)? * share.left.sqrt())))),
            cooks_distance: self.sigma.map(|sigma| {
                each(&|k, share| existing((weighted(k) / (share.left * sigma)).powi(2) * share.reach / total))
            }),
            dffits: others.map(|()| {
                each(&|k, share| {
                    // a node without a say moves nothing
                    let moved = if share.reach > 0.0 { share.leverage / share.reach.sqrt() } else { 0.0 };
                    existing(weighted(k) * moved / (share.left * self.sigma_without(k)?))
                })
            }),
            press_residual,
            press,
            node_indices: self.sample.index().map(|index| index.iter().map(|&k| k as usize).collect()),
        }
    }

    /// The nodes without which nothing is left of the noise, though degrees of freedom are.
    fn silent(&self) -> Vec<usize> {
        let nothing = |k: usize| self.rss == 0.0 || (self.freedom > 1 && self.sigma_without(k).is_none());
        (0..self.shares.len()).filter(|&k| self.freedom > 0 && self.shares[k].determined() && nothing(k)).collect()
    }

    /// σ̂ of plain least squares without node `k`; `None` where the others are fitted exactly.
    fn sigma_without(&self, k: usize) -> Option<f64> {
        let Share { left_plain, .. } = self.shares[k];
        if left_plain <= UNDETERMINED {
            // one node and one coefficient less
            return Some((self.rss / self.freedom as f64).sqrt());
        }
        let own = self.sample.w(k) * self.plain[k] * self.plain[k] / left_plain;
        let others = self.rss - own;
        (others > EXACT_WITHOUT * self.rss).then(|| (others / (self.freedom as f64 - 1.0)).sqrt())
    }
}
