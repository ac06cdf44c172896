//! The nodes that are compared, about their means where deviations have no datum.

use std::collections::BTreeMap;

use super::comparison::Comparison;

/// Numbers are no better than this, relative to the largest deviation.
const ARITHMETIC: f64 = 1e-12;

/// The nodes that are compared.
pub(super) struct Counted {
    pub before: Vec<f64>,
    /// d' − d.
    pub came: Vec<f64>,
    /// c.
    pub change: Vec<f64>,
    pub weight: Vec<f64>,
    /// C, a row for each node.
    pub contributions: Vec<Vec<f64>>,
    /// 2σ²/w + u², and what rounding leaves.
    pub variance: Vec<f64>,
    /// u²/η².
    pub single: Vec<f64>,
    /// Σ of the leverages.
    pub leverage: f64,
    /// How many means were taken off.
    pub means: usize,
    /// The columns of the scatter of teeth.
    pub scatter: Vec<Vec<f64>>,
}

impl Counted {
    pub(super) fn of(comparison: &Comparison) -> Self {
        let Comparison { before, measured, contributions, noise, .. } = comparison;
        let settings = comparison.settings.len();
        let weight = |k: usize| comparison.weight.as_ref().map_or(1.0, |weight| weight[k]);
        let counted: Vec<usize> =
            (0..before.len()).filter(|&k| !(before[k].is_nan() || measured[k].is_nan()) && weight(k) > 0.0).collect();
        let list = |of: &dyn Fn(usize) -> f64| counted.iter().map(|&k| of(k)).collect::<Vec<f64>>();
        let group = |k: usize| comparison.traces.as_ref().map_or(0, |traces| traces[k]);
        // mean of each trace, or of all nodes
        let mean = |of: &dyn Fn(usize) -> f64| -> BTreeMap<usize, f64> {
            let mut sums: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
            for &k in counted.iter().filter(|_| !comparison.absolute) {
                let [sum, whole] = sums.entry(group(k)).or_default();
                (*sum, *whole) = (*sum + weight(k) * of(k), *whole + weight(k));
            }
            sums.into_iter().map(|(group, [sum, whole])| (group, sum / whole)).collect()
        };
        let about = |means: &BTreeMap<usize, f64>, k: usize| means.get(&group(k)).copied().unwrap_or(0.0);
        let means: Vec<_> = (0..settings).map(|j| mean(&|k| contributions[k * settings + j])).collect();
        let row = |k: usize| -> Vec<f64> {
            let row = &contributions[k * settings..(k + 1) * settings];
            row.iter().zip(&means).map(|(c, means)| c - about(means, k)).collect()
        };
        let (level, moved) = (mean(&|k| before[k]), mean(&|k| measured[k] - before[k]));
        let change = list(&|k| row(k).iter().sum());
        let largest = counted
            .iter()
            .zip(&change)
            .fold(0.0f64, |most, (&k, c)| most.max(before[k].abs()).max(measured[k].abs()).max((before[k] + c).abs()));
        let floor = (ARITHMETIC * largest).max(f64::MIN_POSITIVE.sqrt());
        let eta = comparison.response_uncertainty;
        let single = list(&|k| contributions[k * settings..(k + 1) * settings].iter().map(|c| c * c).sum());
        let variance = counted
            .iter()
            .zip(&single)
            .map(|(&k, u)| 2.0 * noise.sigma * noise.sigma / weight(k) + eta * eta * u + floor * floor)
            .collect();
        Counted {
            before: list(&|k| before[k] - about(&level, k)),
            came: list(&|k| measured[k] - before[k] - about(&moved, k)),
            means: level.len(),
            scatter: comparison
                .scatter
                .columns
                .iter()
                .map(|column| {
                    let means = mean(&|k| column[k]);
                    list(&|k| column[k] - about(&means, k))
                })
                .collect(),
            change,
            weight: list(&weight),
            contributions: counted.iter().map(|&k| row(k)).collect(),
            variance,
            single,
            leverage: comparison.leverage.as_ref().map_or(0.0, |leverage| counted.iter().map(|&k| leverage[k]).sum()),
        }
    }
}
