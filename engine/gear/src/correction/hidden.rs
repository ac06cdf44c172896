//! Whether nodes show the twist of a flank.
//!
//! A profile and a helix that cross hardly change with the twist, and the two angles reproduce that
//! change wherever they cross. Least squares may then answer a twist of hundreds of micrometres to
//! a deviation of two.

use std::collections::BTreeMap;

use nalgebra::DMatrix;

use super::flank::Flank;

/// Rms of what functions linear in u and v must leave unexplained of u v, as a share of the rms of
/// u times that of v.
const SHOWN: f64 = 0.1;

impl Flank {
    /// Returns whether nodes that have a deviation and a weight above 0 show a twist: whether the
    /// product u v of their coordinates is not nearly a linear function of u and v, with a constant
    /// for each trace that has a zero of its own.
    pub fn shows_twist(&self, deviation: &[f64], weight: Option<&[f64]>) -> bool {
        let weight = |k: usize| weight.map_or(1.0, |weight| weight[k]);
        let counted: Vec<usize> =
            (0..self.places.len()).filter(|&k| !deviation[k].is_nan() && weight(k) > 0.0).collect();
        let weights: f64 = counted.iter().map(|&k| weight(k)).sum();
        // u and v with mean 0 and rms 1, unless they hardly vary over their range
        let scaled = |of: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let mean = counted.iter().map(|&k| weight(k) * of(k)).sum::<f64>() / weights;
            let square = counted.iter().map(|&k| weight(k) * (of(k) - mean).powi(2)).sum::<f64>() / weights;
            let [low, high] = counted.iter().fold([mean; 2], |[low, high], &k| [low.min(of(k)), high.max(of(k))]);
            let scale = square.sqrt().max(0.05 * (high - low)).max(f64::MIN_POSITIVE);
            counted.iter().map(|&k| (of(k) - mean) / scale).collect()
        };
        let u = scaled(&|k| self.places[k].roll_length);
        let v = scaled(&|k| self.places[k].z);
        let trace = |row: usize| self.traces.as_ref().map_or(0, |traces| traces[counted[row]]);
        // less their means over each trace, in place of its constant
        let values = |row: usize| [u[row], v[row], u[row] * v[row]];
        let mut sums: BTreeMap<usize, (f64, [f64; 3])> = BTreeMap::new();
        for row in 0..counted.len() {
            let (whole, sum) = sums.entry(trace(row)).or_default();
            let weight = weight(counted[row]);
            *whole += weight;
            sum.iter_mut().zip(values(row)).for_each(|(sum, value)| *sum += weight * value);
        }
        if counted.len() < sums.len() + 3 {
            return false;
        }
        let entry = |row: usize, column: usize| {
            let (whole, sum) = sums[&trace(row)];
            weight(counted[row]).sqrt() * (values(row)[column] - sum[column] / whole)
        };
        // the last diagonal of R is the length of what the other columns do not explain
        let own = DMatrix::from_fn(counted.len(), 3, entry).qr().r()[(2, 2)].abs();
        own >= SHOWN * weights.sqrt()
    }
}
