//! Stationary processes along a line, as state-space models of unit variance, and whitening by the
//! Kalman filter.
//!
//! A filter takes from each height what those before it on the line let expect, and divides by the
//! standard deviation of the rest: the innovations are white. Gaps are longer steps of prediction.
//! With `V` the correlations of the heights this is multiplication with L⁻¹, `V = LLᵀ`, in O(m).

use super::lines::Lines;
use crate::spec::{Correlation, Matern};
use flankfit_numerics::{Real, cancel::Asking};

/// A process with its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Process {
    /// Autoregression of first order: ρ.
    Ar1(f64),
    /// First order along u and v of a grid: their ρ.
    Product([f64; 2]),
    /// Second order: φ₁, φ₂.
    Ar2([f64; 2]),
    /// Matérn's process with smoothness 3/2, correlation `(1 + λd) exp(−λd)` with λ = √3/length,
    /// and a share of the variance that is white.
    Matern { length: f64, nugget: f64 },
}

/// A symmetric 2 × 2 matrix: 11, 12, 22.
type Symmetric = [f64; 3];
type Matrix = [[f64; 2]; 2];

/// Effect of the filter at one node.
#[derive(Clone, Copy, Debug)]
struct Gain {
    /// From the state at the node before.
    transition: Matrix,
    /// Gain from the innovation to the state.
    gain: [f64; 2],
    /// Standard deviation of the innovation.
    deviation: f64,
}

impl Process {
    /// Returns the process in the form of a spec.
    pub(crate) fn correlation(&self) -> Correlation {
        match *self {
            Process::Ar1(rho) | Process::Product([rho, _]) => Correlation::Ar1 { rho: Some(rho) },
            Process::Ar2(phi) => Correlation::Ar2 { phi: Some(phi) },
            Process::Matern { length, nugget } => Correlation::Matern { parameters: Some(Matern { length, nugget }) },
        }
    }

    /// The correlation of neighbours along v, where they are correlated along both axes.
    pub(crate) fn along_v(&self) -> Option<f64> {
        match *self {
            Process::Product([_, rho]) => Some(rho),
            _ => None,
        }
    }

    /// Covariance of the state.
    fn stationary(&self) -> Symmetric {
        match *self {
            Process::Ar1(_) | Process::Product(_) => [1.0, 0.0, 0.0],
            Process::Ar2([a, b]) => [1.0, a / (1.0 - b), 1.0],
            // the second of the state is the derivative over λ, so that no length leaves doubles
            Process::Matern { nugget, .. } => [1.0 - nugget, 0.0, 1.0 - nugget],
        }
    }

    /// Returns the transition of the state over a step; 0 over an infinite one.
    fn transition(&self, step: f64) -> Matrix {
        if step == f64::INFINITY {
            return [[0.0; 2]; 2];
        }
        match *self {
            Process::Ar1(rho) | Process::Product([_, rho]) => [[libm::pow(rho, step), 0.0], [0.0, 0.0]],
            Process::Ar2([a, b]) => power([[a, b], [1.0, 0.0]], step as u64),
            Process::Matern { length, .. } => {
                let x = 3f64.sqrt() * (step / length);
                let fading = libm::exp(-x);
                if fading == 0.0 {
                    return [[0.0; 2]; 2];
                }
                [[fading * (1.0 + x), fading * x], [-fading * x, fading * (1.0 - x)]]
            }
        }
    }

    fn nugget(&self) -> f64 {
        match *self {
            Process::Matern { nugget, .. } => nugget,
            _ => 0.0,
        }
    }
}

fn times(a: Matrix, b: Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
}

fn power(mut base: Matrix, mut exponent: u64) -> Matrix {
    let mut result = [[1.0, 0.0], [0.0, 1.0]];
    while exponent > 0 {
        if exponent & 1 == 1 {
            result = times(result, base);
        }
        base = times(base, base);
        exponent >>= 1;
    }
    result
}

/// `F P Fᵀ`.
fn carried(f: Matrix, p: Symmetric) -> Symmetric {
    let row = |i: usize| [f[i][0] * p[0] + f[i][1] * p[1], f[i][0] * p[1] + f[i][1] * p[2]];
    let (first, second) = (row(0), row(1));
    let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    [dot(first, f[0]), dot(first, f[1]), dot(second, f[1])]
}

/// The filter of a process over the nodes of lines.
pub(crate) struct Whitening {
    gains: Vec<Gain>,
    /// Filter along u, applied after that along v where errors are correlated along both, and for
    /// each node in its order the place in that along v.
    across: Option<(Box<Whitening>, Vec<usize>)>,
    /// `½ ln det V`.
    pub half_log_determinant: f64,
}

impl Whitening {
    /// `None` where heights determine each other to rounding, so that V cannot be inverted.
    pub(crate) fn new(process: &Process, lines: &Lines) -> Option<Self> {
        let (stationary, nugget) = (process.stationary(), process.nugget());
        let mut p = stationary;
        let (mut sum, mut last) = (0.0, (f64::NAN, [[0.0; 2]; 2]));
        let mut gains = Vec::with_capacity(lines.steps.len());
        for &step in lines.steps.iter().asking(60) {
            if step != last.0 {
                last = (step, process.transition(step));
            }
            let f = last.1;
            // the noise of a step is what keeps the process stationary
            let (kept, whole) = (carried(f, stationary), carried(f, p));
            let ahead: Symmetric = std::array::from_fn(|i| whole[i] + (stationary[i] - kept[i]));
            let variance = ahead[0] + nugget;
            if !(variance > LEAST) {
                return None;
            }
            let gain = [ahead[0] / variance, ahead[1] / variance];
            p = [ahead[0] - gain[0] * ahead[0], ahead[1] - gain[0] * ahead[1], ahead[2] - gain[1] * ahead[1]];
            sum += 0.5 * libm::log(variance);
            gains.push(Gain { transition: f, gain, deviation: variance.sqrt() });
        }
        let across = match (process, &lines.across) {
            (&Process::Product([rho, _]), Some(across)) => {
                let mut place = vec![0; lines.nodes.len()];
                lines.nodes.iter().enumerate().for_each(|(i, &k)| place[k] = i);
                let order = across.nodes.iter().map(|&k| place[k]).collect();
                let filter = Whitening::new(&Process::Ar1(rho), across)?;
                sum += filter.half_log_determinant;
                Some((Box::new(filter), order))
            }
            _ => None,
        };
        Some(Whitening { gains, across, half_log_determinant: sum })
    }

    /// Makes rows of `width` numbers, in the order of the lines, white.
    pub(crate) fn whiten<T: Real>(&self, rows: &mut [T], width: usize) {
        let mut state = vec![[T::of(0.0); 2]; width];
        for (gain, row) in self.gains.iter().zip(rows.chunks_exact_mut(width)).asking(20 * width) {
            for (state, y) in state.iter_mut().zip(row) {
                *state = gain.ahead(*state);
                let innovation = *y - state[0];
                *y = if gain.deviation == 1.0 { innovation } else { innovation / T::of(gain.deviation) };
                for (x, k) in state.iter_mut().zip(gain.gain) {
                    *x += innovation.mul_f64(k);
                }
            }
        }
        self.across(rows, width, |filter, rows| filter.whiten(rows, width));
    }

    /// Lets `change` change the rows in the order along u.
    fn across<T: Real>(&self, rows: &mut [T], width: usize, change: impl Fn(&Whitening, &mut [T])) {
        let Some((filter, order)) = &self.across else { return };
        let mut along: Vec<T> = order.iter().flat_map(|&k| &rows[k * width..][..width]).copied().collect();
        change(filter, &mut along);
        for (row, &k) in along.chunks_exact(width).zip(order) {
            rows[k * width..][..width].copy_from_slice(row);
        }
    }

    /// The heights, in the order of the lines, that are made white to `innovations`.
    pub(crate) fn colour(&self, innovations: &mut [f64]) {
        self.across(innovations, 1, |filter, rows| filter.colour(rows));
        let mut state = [0.0; 2];
        for (gain, y) in self.gains.iter().zip(innovations) {
            state = gain.ahead(state);
            let innovation = *y * gain.deviation;
            *y = innovation + state[0];
            for (x, k) in state.iter_mut().zip(gain.gain) {
                *x += innovation * k;
            }
        }
    }
}

/// The least share of a height's variance that those before it may leave.
const LEAST: f64 = 1e-12;

impl Gain {
    fn ahead<T: Real>(&self, state: [T; 2]) -> [T; 2] {
        let [first, second] = self.transition;
        let of = |row: [f64; 2]| state[0].mul_f64(row[0]) + state[1].mul_f64(row[1]);
        [of(first), of(second)]
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;

    const START: f64 = f64::INFINITY;

    fn lines(steps: &[f64]) -> Lines {
        Lines { nodes: (0..steps.len()).collect(), steps: steps.to_vec(), across: None }
    }

    /// Correlation at a distance, from the textbook formula.
    fn correlation(process: &Process, d: f64) -> f64 {
        match *process {
            Process::Ar1(rho) | Process::Product([_, rho]) => rho.powi(d as i32),
            Process::Ar2([a, b]) => {
                let mut r = vec![1.0, a / (1.0 - b)];
                while r.len() <= d as usize {
                    r.push(a * r[r.len() - 1] + b * r[r.len() - 2]);
                }
                r[d as usize]
            }
            Process::Matern { length, nugget } => {
                let x = 3f64.sqrt() * d / length;
                if d == 0.0 { 1.0 } else { (1.0 - nugget) * (1.0 + x) * (-x).exp() }
            }
        }
    }

    /// Two lines with gaps against the dense Cholesky factor of their correlations.
    #[test]
    fn innovations_are_those_of_the_cholesky_factor() {
        let steps = [START, 1.0, 3.0, 1.0, START, 2.0, 1.0];
        let mut place = 0.0;
        let places: Vec<f64> = steps
            .iter()
            .map(|s| {
                place = if s.is_finite() { place + s } else { place + 1e6 };
                place
            })
            .collect();
        let rows: Vec<f64> = (0..14).map(|i| f64::from((7 * i + 3) % 11) - 4.0).collect();
        for process in [
            Process::Ar1(0.7),
            Process::Ar1(-0.4),
            Process::Ar2([1.2, -0.5]),
            Process::Matern { length: 2.5, nugget: 0.1 },
            Process::Matern { length: 4.0, nugget: 0.0 },
        ] {
            let v = DMatrix::from_fn(7, 7, |i, j| {
                let d: f64 = (places[i] - places[j]).abs();
                if d > 1e5 { 0.0 } else { correlation(&process, d) }
            });
            let l = v.cholesky().unwrap().l();
            let expected = l.solve_lower_triangular(&DMatrix::from_row_slice(7, 2, &rows)).unwrap();
            let whitening = Whitening::new(&process, &lines(&steps)).unwrap();
            let mut found = rows.clone();
            whitening.whiten(&mut found, 2);
            for (k, found) in found.iter().enumerate() {
                assert!((found - expected[(k / 2, k % 2)]).abs() < 1e-9, "{process:?} {k}");
            }
            let log: f64 = l.diagonal().iter().map(|x| x.ln()).sum();
            assert!((whitening.half_log_determinant - log).abs() < 1e-10);
            let mut back: Vec<f64> = found.chunks(2).map(|row| row[1]).collect();
            whitening.colour(&mut back);
            assert!(back.iter().zip(rows.chunks(2)).all(|(a, row)| (a - row[1]).abs() < 1e-12), "{process:?}");
        }
    }

    /// A grid of 3 × 4 against the Kronecker product of the correlations.
    #[test]
    fn both_axes_are_a_kronecker_product() {
        let nodes =
            crate::Nodes::grid(vec![0.0, 1.0, 2.0], vec![0.0, 1.0, 2.0, 3.0], vec![0.0; 12], None, None).unwrap();
        let both = Lines::both(&nodes, &crate::data::Sample::new(&nodes));
        let whitening = Whitening::new(&Process::Product([0.5, -0.3]), &both).unwrap();
        let ar = |n: usize, rho: f64| DMatrix::from_fn(n, n, |i, j| rho.powi(i.abs_diff(j) as i32));
        let v = ar(3, 0.5).kronecker(&ar(4, -0.3));
        let mut inverse_root: Vec<f64> = DMatrix::<f64>::identity(12, 12).as_slice().to_vec();
        whitening.whiten(&mut inverse_root, 12);
        let w = DMatrix::from_row_slice(12, 12, &inverse_root);
        assert!((&w * &v * w.transpose() - DMatrix::identity(12, 12)).amax() < 1e-13);
        assert!((whitening.half_log_determinant - 0.5 * v.determinant().ln()).abs() < 1e-12);
        let mut back: Vec<f64> = w.column(5).iter().copied().collect();
        whitening.colour(&mut back);
        assert!(back.iter().enumerate().all(|(k, x)| (x - f64::from(u8::from(k == 5))).abs() < 1e-13), "{back:?}");
    }

    /// However short a length of correlation is: over steps of so many of them nothing is left.
    #[test]
    fn short_lengths_are_independent() {
        let rows = [0.1, 1.0 / 3.0, -7.7e-5];
        for length in [1e-3, 1e-155, 1e-200, f64::MIN_POSITIVE, 5e-324] {
            let process = Process::Matern { length, nugget: 0.0 };
            let whitening = Whitening::new(&process, &lines(&[START, 1.0, 2.0])).unwrap();
            let mut found = rows;
            whitening.whiten(&mut found, 1);
            assert_eq!((found, whitening.half_log_determinant), (rows, 0.0), "{length:e}");
            // one place twice determines itself all the same
            assert!(Whitening::new(&process, &lines(&[START, 0.0])).is_none(), "{length:e}");
        }
    }

    #[test]
    fn white_errors_change_no_bit() {
        let rows = [0.1, 1.0 / 3.0, -7.7e-5];
        for process in [Process::Ar1(0.0), Process::Ar2([0.0, 0.0])] {
            let whitening = Whitening::new(&process, &lines(&[START, 1.0, 2.0])).unwrap();
            let mut found = rows;
            whitening.whiten(&mut found, 1);
            assert_eq!((found, whitening.half_log_determinant), (rows, 0.0));
        }
    }
}
