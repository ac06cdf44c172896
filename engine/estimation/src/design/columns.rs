//! The posted columns of a linear model.

use super::measurement_matrix::{Basis, Design, too_many};
use crate::{data::Sample, result::TermKey};
use flankfit_numerics::{cancel::Asking, check::Faults};

pub(crate) fn columns(sample: &Sample, n: usize, names: Option<&[String]>) -> Result<Design, Faults> {
    too_many(n, "nodes.x")?;
    let mut largest = vec![0.0f64; n];
    let mut same = vec![true; n];
    let first = sample.matrix_row(0);
    for k in (0..sample.count()).asking(100) {
        for (j, x) in sample.matrix_row(k).iter().enumerate() {
            largest[j] = largest[j].max(x.abs());
            same[j] &= *x == first[j];
        }
    }
    let scale = largest.iter().map(|&x| if x > 0.0 { power_of_two(x) } else { 1.0 }).collect();
    let constants: Vec<usize> = (0..n).filter(|&j| same[j] && first[j] != 0.0).collect();
    Ok(of_columns(scale, &constants, names))
}

/// Posted columns divided by `scale`, of which `constants` do not vary.
pub(crate) fn of_columns(scale: Vec<f64>, constants: &[usize], names: Option<&[String]>) -> Design {
    let n = scale.len();
    Design {
        basis: Basis::Columns { scale },
        terms: (0..n).map(|j| (j, 0)).collect(),
        labels: (0..n).map(|j| names.map_or_else(|| format!("x{j}"), |names| names[j].clone())).collect(),
        keys: (0..n).map(TermKey::Column).collect(),
        constant: if constants.len() == 1 { Some(constants[0]) } else { None },
        constant_in_span: if constants.is_empty() { None } else { Some(true) },
        domain: None,
        rational: None,
    }
}

/// The power of 2 next below `x > 0`.
pub(crate) fn power_of_two(x: f64) -> f64 {
    let truncated = f64::from_bits(x.to_bits() & 0x7ff0_0000_0000_0000);
    if truncated > 0.0 { truncated } else { f64::MIN_POSITIVE }
}
