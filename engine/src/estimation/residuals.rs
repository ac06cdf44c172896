//! Residuals `Y − X Â_B` with the caller's X, formed in the well-conditioned working basis.

use nalgebra::DMatrix;

use super::{
    accumulate::{Precision, Wanted, residual_pass},
    design::Design,
    evidence::Evidence,
    factor::{Factor, multiply_upper_vector},
    nodes::{Grid, Nodes},
    sample::Sample,
    seen::Seen,
};
use crate::numerics::{
    Dd,
    cancel::{self, Asking},
    triangular,
    wide::LANES,
};

/// A residual this small against the heights has lost digits in double precision.
const SMALL: f64 = 1e-7;

/// Weighted sums over the heights.
pub struct Heights {
    /// Σ w.
    pub weight: f64,
    /// Σ w (z − z̄)².
    pub about_mean: f64,
    /// Σ w z².
    pub about_zero: f64,
    /// max √w |z|.
    pub largest: f64,
    /// max |z|.
    pub largest_plain: f64,
}

/// Heights summed before a compensated total is touched.
const BLOCK: usize = 1024;

impl Heights {
    pub fn new(sample: &Sample) -> Self {
        let mut weight = Dd::ZERO;
        let (mut sum, mut squares, mut largest, mut largest_plain) = (Dd::ZERO, Dd::ZERO, 0.0f64, 0.0f64);
        over_blocks(sample, |z, w| {
            let mut lanes = [[0.0; LANES]; 5];
            for (z, w) in z.chunks(LANES).zip(w.chunks(LANES)) {
                for (k, (z, w)) in z.iter().zip(w).enumerate() {
                    lanes[0][k] += w;
                    lanes[1][k] += w * z;
                    lanes[2][k] += w * z * z;
                    lanes[3][k] = lanes[3][k].max(w * z * z);
                    lanes[4][k] = lanes[4][k].max(z.abs());
                }
            }
            weight += Dd::from(total(lanes[0]));
            sum += Dd::from(total(lanes[1]));
            squares += Dd::from(total(lanes[2]));
            largest = lanes[3].into_iter().fold(largest, f64::max);
            largest_plain = lanes[4].into_iter().fold(largest_plain, f64::max);
        });
        let mean = (sum / weight).to_f64();
        let mut about_mean = Dd::ZERO;
        over_blocks(sample, |z, w| {
            let mut lanes = [0.0; LANES];
            for (z, w) in z.chunks(LANES).zip(w.chunks(LANES)) {
                for (k, (z, w)) in z.iter().zip(w).enumerate() {
                    lanes[k] += w * (z - mean) * (z - mean);
                }
            }
            about_mean += Dd::from(total(lanes));
        });
        Heights {
            weight: weight.to_f64(),
            about_mean: about_mean.to_f64(),
            about_zero: squares.to_f64(),
            largest: largest.sqrt(),
            largest_plain,
        }
    }
}

fn total(lanes: [f64; LANES]) -> f64 {
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3])
}

/// Hands heights and weights on block by block, in order.
fn over_blocks(sample: &Sample, mut work: impl FnMut(&[f64], &[f64])) {
    let ones = [1.0; BLOCK];
    if let Some(heights) = sample.all_heights().filter(|_| !sample.weighted()) {
        heights.chunks(BLOCK).for_each(|block| work(block, &ones[..block.len()]));
        return;
    }
    let (mut z, mut w) = ([0.0; BLOCK], [1.0; BLOCK]);
    for start in (0..sample.count()).step_by(BLOCK).asking(10 * BLOCK) {
        let here = (sample.count() - start).min(BLOCK);
        for i in 0..here {
            (z[i], w[i]) = (sample.z(start + i), sample.w(start + i));
        }
        work(&z[..here], &w[..here]);
    }
}

/// Residuals of one coefficient vector.
pub struct Residuals {
    pub rss: f64,
    /// `None` where the nodes are gone.
    pub max_abs: Option<f64>,
    /// When asked for and the nodes are there.
    pub values: Option<Vec<f64>>,
}

/// Where coefficients stand in Q's coordinates and in the working basis.
pub struct Place<'a> {
    pub design: &'a Design,
    pub factor: &'a Factor,
    /// Σ w z².
    pub heights: f64,
    pub evidence: Evidence<'a>,
}

impl Place<'_> {
    fn grid(&self) -> Option<&Grid> {
        match self.evidence {
            Evidence::Posted { nodes: Nodes::Grid(grid), .. } => Some(grid),
            _ => None,
        }
    }

    /// Residuals of the coefficients whose image `R c` is `b`.
    pub fn of_image(&self, b: &[Dd], keep: bool) -> Residuals {
        if let (Some(separable), Some(grid)) = (&self.factor.separable, self.grid()) {
            let run = |precision| {
                let (rss, max_abs, values) = separable.residuals(grid, b, precision, keep);
                Residuals { rss, max_abs: Some(max_abs), values: keep.then_some(values) }
            };
            return self.sharpened(run);
        }
        if let Evidence::Summed(seen) = self.evidence {
            return self.of_sums(seen, b);
        }
        let mut working = b.to_vec();
        triangular::solve_upper(&self.factor.r, &mut working);
        self.of_working(&working, keep)
    }

    /// Residuals of working coefficients.
    pub fn of_working(&self, working: &[Dd], keep: bool) -> Residuals {
        match self.evidence {
            Evidence::Posted { sample, .. } => self.sharpened(|precision| {
                let wanted = if keep { Wanted::Values } else { Wanted::Sums };
                let pass = residual_pass(self.design, sample, working, precision, wanted);
                let values = keep.then_some(pass.values);
                Residuals { rss: pass.rss.to_f64(), max_abs: Some(pass.max_abs), values }
            }),
            Evidence::Summed(seen) => {
                let mut image = working.to_vec();
                multiply_upper_vector(&self.factor.r, &mut image);
                self.of_sums(seen, &image)
            }
        }
    }

    /// `‖√Ω(z − Wc)‖² = ‖Qᵀ√Ωz − Rc‖² + rss`: all that can be told without the nodes.
    fn of_sums(&self, seen: &Seen, image: &[Dd]) -> Residuals {
        let moved = self.factor.qty.iter().zip(image).fold(Dd::ZERO, |sum, (&b, &x)| sum + (b - x) * (b - x));
        Residuals { rss: (seen.rss + moved).to_f64(), max_abs: None, values: None }
    }

    /// In double precision first, and again in double-double where nothing but rounding would be
    /// left.
    fn sharpened(&self, run: impl Fn(Precision) -> Residuals) -> Residuals {
        let plain = run(Precision::Double);
        if plain.rss > SMALL * SMALL * self.heights { plain } else { run(Precision::DoubleDouble) }
    }
}

/// Rows of B in the caller's columns: `√w W R⁻¹ (Σ cᵢ X̃Vᵢ Vᵢᵀ) S`, whose product with the caller's
/// A is what Eq. 29 adds.
pub fn matrix_b(
    design: &Design,
    sample: &Sample,
    factor: &Factor,
    image: &DMatrix<f64>,
    v: &DMatrix<f64>,
    c: &[f64],
    scale: &[f64],
) -> Vec<Vec<f64>> {
    let n = design.size();
    // middle = R⁻¹ image diag(c) Vᵀ S, so that a row of B is √w (row of W) · middle columns of the
    // middle matrix cancel down to σ₁ in the products: both are formed in double-double
    let mut middle = DMatrix::from_element(n, n, Dd::ZERO);
    for (i, &ci) in c.iter().enumerate().filter(|(_, c)| **c != 0.0) {
        let mut direction: Vec<Dd> = image.column(i).iter().map(|&x| Dd::from(x)).collect();
        triangular::solve_upper(&factor.r, &mut direction);
        cancel::checkpoint();
        for j in (0..n).asking(10 * n) {
            let factor = Dd::product(ci, v[(j, i)]) * scale[j];
            for k in 0..n {
                middle[(k, j)] += direction[k] * factor;
            }
        }
    }
    let mut row = super::accumulate::Row::<Dd>::new(design);
    (0..sample.count())
        .map(|k| {
            cancel::checkpoint();
            row.at(design, sample, k);
            let root = sample.w(k).sqrt();
            (0..n)
                .asking(10 * n)
                .map(|j| {
                    let terms = row.index.iter().zip(&row.values);
                    root * terms.fold(Dd::ZERO, |sum, (&s, &x)| sum + x * middle[(s, j)]).to_f64()
                })
                .collect()
        })
        .collect()
}
