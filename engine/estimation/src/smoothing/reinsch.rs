//! The equations of the cubic smoothing spline (Reinsch 1967; Green and Silverman 1994, chapter 2),
//! in O(m).
//!
//! With steps h, second derivatives γ at the inner abscissae, the tridiagonal R of `γᵀRγ = ∫g″²`
//! and the second divided differences Q: `(R + λ QᵀΩ⁻¹Q) γ = Qᵀy` and `g = y − λ Ω⁻¹Qγ`. The
//! condition of that matrix rises with the fourth power of m, so everything is done in
//! double-double: 10⁵ abscissae leave more than ten digits whatever λ is.
//!
//! The smoother's trace is `2 + trace(R Z)` with Z the inverse, of which only the band is needed;
//! nothing cancels in it.

use super::choice::Figures;
use flankfit_numerics::{Dd, cancel::Asking};

/// Strictly ascending abscissae with weights, three at least.
pub(super) struct Equations {
    /// 1/w.
    spread: Vec<Dd>,
    /// Q: the three entries of each column.
    q: Vec<[Dd; 3]>,
    /// R and K = QᵀΩ⁻¹Q: diagonal, first and second off-diagonal.
    r: Vec<[Dd; 2]>,
    k: Vec<[Dd; 3]>,
    pub steps: Vec<Dd>,
}

/// `L D Lᵀ` of aR + bK with (a, b) = (1, λ), or (1/λ, 1) where λ > 1: so neither it nor what it
/// solves for leaves the range of doubles however large λ is.
struct Factor {
    a: Dd,
    b: Dd,
    d: Vec<Dd>,
    /// L once and twice below the diagonal, by columns.
    l: Vec<[Dd; 2]>,
}

/// The spline of one λ.
pub(super) struct Solution {
    /// Values at the abscissae, and second derivatives there (0 at the ends), by coordinate.
    pub values: Vec<Vec<Dd>>,
    pub bends: Vec<Vec<Dd>>,
    /// `Σ w r²` of each coordinate.
    pub rss: Vec<f64>,
    /// Diagonal of the matrix that makes values of heights.
    pub leverage: Vec<f64>,
    pub effective: f64,
    pub roughness: f64,
}

impl Equations {
    pub(super) fn new(x: &[f64], weight: &[f64]) -> Self {
        let steps: Vec<Dd> = x.windows(2).asking(10).map(|pair| Dd::diff(pair[1], pair[0])).collect();
        let spread: Vec<Dd> = weight.iter().asking(20).map(|&w| Dd::ONE / Dd::from(w)).collect();
        let inner = x.len() - 2;
        let over: Vec<Dd> = steps.iter().asking(20).map(|&h| Dd::ONE / h).collect();
        let q: Vec<[Dd; 3]> = (0..inner).asking(20).map(|j| [over[j], -(over[j] + over[j + 1]), over[j + 1]]).collect();
        let (three, six) = (Dd::from(3.0), Dd::from(6.0));
        let r = (0..inner).asking(50).map(|j| [(steps[j] + steps[j + 1]) / three, steps[j + 1] / six]).collect();
        let k = (0..inner)
            .asking(200)
            .map(|j| {
                // columns j and j + d share rows j + d to j + 2
                let shared = |d: usize| {
                    let Some(other) = q.get(j + d) else { return Dd::ZERO };
                    (d..3).fold(Dd::ZERO, |sum, i| sum + q[j][i] * other[i - d] * spread[j + i])
                };
                [shared(0), shared(1), shared(2)]
            })
            .collect();
        Equations { spread, q, r, k, steps }
    }

    /// ln λ from where the spline as good as interpolates to where it is a straight line.
    pub(super) fn range(&self) -> [f64; 2] {
        let ratio = self.r.iter().zip(&self.k).map(|(r, k)| (r[0] / k[0]).to_f64()).fold(f64::INFINITY, f64::min);
        let length = self.steps.iter().fold(Dd::ZERO, |sum, &h| sum + h).to_f64();
        let weight: f64 = self.spread.iter().map(|&s| 1.0 / s.to_f64()).sum();
        // the least eigenvalue of a free beam under a load spread evenly: 500.56 / (weight ·
        // length³)
        let (low, high) = ((1e-4 * ratio).ln(), (weight * length * length * length).ln());
        [low, high.max(low + 1.0)]
    }

    fn factor(&self, lambda: f64) -> Factor {
        let n = self.r.len();
        let lambda = Dd::from(lambda);
        let (a, b) = if lambda.hi > 1.0 { (lambda.recip(), Dd::ONE) } else { (Dd::ONE, lambda) };
        let (mut d, mut l): (Vec<Dd>, Vec<[Dd; 2]>) = (Vec::with_capacity(n), vec![[Dd::ZERO; 2]; n]);
        for i in (0..n).asking(100) {
            let mut pivot = self.r[i][0] * a + self.k[i][0] * b;
            if i >= 2 {
                pivot -= l[i - 2][1] * l[i - 2][1] * d[i - 2];
            }
            if i >= 1 {
                pivot -= l[i - 1][0] * l[i - 1][0] * d[i - 1];
            }
            let over = Dd::ONE / pivot;
            let mut beside = self.r[i][1] * a + self.k[i][1] * b;
            if i >= 1 {
                beside -= l[i - 1][0] * l[i - 1][1] * d[i - 1];
            }
            l[i] = [beside * over, self.k[i][2] * b * over];
            d.push(pivot);
        }
        Factor { a, b, d, l }
    }

    /// `Qᵀ y`.
    fn differences(&self, y: &[Dd]) -> Vec<Dd> {
        self.q.iter().zip(y.windows(3)).asking(30).map(|(q, y)| q[0] * y[0] + q[1] * y[1] + q[2] * y[2]).collect()
    }

    /// `x ↦ M x` for M symmetric with the given diagonals.
    fn multiply<const B: usize>(m: &[[Dd; B]], x: &[Dd]) -> Vec<Dd> {
        let mut y: Vec<Dd> = m.iter().zip(x).map(|(m, &x)| m[0] * x).collect();
        for d in 1..B {
            for i in (0..x.len().saturating_sub(d)).asking(20) {
                y[i] += m[i][d] * x[i + d];
                y[i + d] += m[i][d] * x[i];
            }
        }
        y
    }

    /// Results of λ for `heights`, by coordinate; `apart` is added to RSS (the part of repeated
    /// abscissae).
    pub(super) fn figures(&self, heights: &[Vec<Dd>], lambda: f64, apart: f64) -> Figures {
        let factor = self.factor(lambda);
        let (a, b) = (factor.a, factor.b);
        let (mut rss, mut roughness, mut slope) = (apart, 0.0, 0.0);
        for y in heights {
            // γ = a x and λγ = b x
            let mut x = self.differences(y);
            factor.solve(&mut x);
            let (curved, bent) = (Self::multiply(&self.k, &x), Self::multiply(&self.r, &x));
            rss += (dot(&x, &curved) * b * b).to_f64();
            roughness += (dot(&x, &bent) * a * a).to_f64();
            // dγ/dλ = −H⁻¹Kγ
            let mut moved = curved;
            factor.solve(&mut moved);
            slope -= 2.0 * (dot(&bent, &moved) * a * a * a).to_f64();
        }
        let inverse = factor.inverse();
        Figures { rss, roughness, roughness_slope: slope, effective: self.effective(&inverse, a) }
    }

    fn effective(&self, inverse: &[[Dd; 3]], a: Dd) -> f64 {
        let trace = self.r.iter().zip(inverse).fold(Dd::ZERO, |sum, (r, z)| sum + r[0] * z[0] + (r[1] * z[1]) * 2.0);
        2.0 + (trace * a).to_f64()
    }

    /// The spline itself.
    pub(super) fn solve(&self, heights: &[Vec<Dd>], lambda: f64) -> Solution {
        let factor = self.factor(lambda);
        let (a, b) = (factor.a, factor.b);
        let inverse = factor.inverse();
        let m = self.spread.len();
        let mut solution = Solution {
            values: Vec::new(),
            bends: Vec::new(),
            rss: Vec::new(),
            leverage: Vec::with_capacity(m),
            effective: self.effective(&inverse, a),
            roughness: 0.0,
        };
        for y in heights {
            // γ = a x and λγ = b x
            let mut x = self.differences(y);
            factor.solve(&mut x);
            solution.roughness += (dot(&x, &Self::multiply(&self.r, &x)) * a * a).to_f64();
            solution.rss.push((dot(&x, &Self::multiply(&self.k, &x)) * b * b).to_f64());
            let mut values = y.clone();
            for (j, (q, &x)) in self.q.iter().zip(&x).enumerate().asking(100) {
                for i in 0..3 {
                    values[j + i] -= q[i] * x * self.spread[j + i] * b;
                }
            }
            solution.values.push(values);
            let gamma = x.into_iter().map(|x| x * a);
            solution.bends.push(std::iter::once(Dd::ZERO).chain(gamma).chain([Dd::ZERO]).collect());
        }
        for i in (0..m).asking(200) {
            // row i of Q has entries in columns i − 2 to i
            let columns = i.saturating_sub(2)..(i + 1).min(self.q.len());
            let mut sum = Dd::ZERO;
            for j in columns.clone() {
                for k in j..columns.end {
                    let term = self.q[j][i - j] * self.q[k][i - k] * inverse[j][k - j];
                    sum += if j == k { term } else { term * 2.0 };
                }
            }
            solution.leverage.push((Dd::ONE - sum * self.spread[i] * b).to_f64().clamp(0.0, 1.0));
        }
        solution
    }
}

fn dot(x: &[Dd], y: &[Dd]) -> Dd {
    x.iter().zip(y).asking(10).fold(Dd::ZERO, |sum, (&x, &y)| sum + x * y)
}

impl Factor {
    fn solve(&self, b: &mut [Dd]) {
        let n = b.len();
        for i in (0..n).asking(30) {
            let x = b[i];
            for (d, &l) in self.l[i].iter().enumerate() {
                if i + 1 + d < n {
                    b[i + 1 + d] -= l * x;
                }
            }
        }
        for i in (0..n).rev().asking(50) {
            let mut x = b[i] / self.d[i];
            for (d, &l) in self.l[i].iter().enumerate() {
                if i + 1 + d < n {
                    x -= l * b[i + 1 + d];
                }
            }
            b[i] = x;
        }
    }

    /// Diagonal, first and second off-diagonal of the inverse.
    fn inverse(&self) -> Vec<[Dd; 3]> {
        let n = self.d.len();
        let mut z = vec![[Dd::ZERO; 3]; n];
        let none = [Dd::ZERO; 3];
        for i in (0..n).rev().asking(100) {
            let (next, after) = (*z.get(i + 1).unwrap_or(&none), *z.get(i + 2).unwrap_or(&none));
            let [a, b] = self.l[i];
            let once = -(a * next[0]) - b * next[1];
            let twice = -(a * next[1]) - b * after[0];
            z[i] = [Dd::ONE / self.d[i] - a * once - b * twice, once, twice];
        }
        z
    }
}
