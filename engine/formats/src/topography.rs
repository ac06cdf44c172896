//! A flank's deviations on a grid, as files give them.

use flankfit_gear::Side;
use flankfit_numerics::cancel::Asking;

/// Deviations over diameter and face width.
#[derive(Clone, Debug, PartialEq)]
pub struct Topography {
    /// The tooth, where the file names one.
    pub tooth: Option<String>,
    /// Flank of the tooth.
    pub side: Side,
    /// mm, ascending.
    pub diameter: Vec<f64>,
    /// Places on the face width, mm, ascending.
    pub z: Vec<f64>,
    /// µm with the sign stored, `deviation[i * z.len() + j]` at `diameter[i]` and `z[j]`; NaN where
    /// undefined.
    pub deviation: Vec<f64>,
}

/// Rows and columns in ascending order of their places. `None` where two places are the same.
pub(super) fn ascending(
    rows: &[f64],
    columns: &[f64],
    value: impl Fn(usize, usize) -> f64,
) -> Option<(Vec<f64>, Vec<f64>, Vec<f64>)> {
    let order = |places: &[f64]| {
        let mut order: Vec<usize> = (0..places.len()).collect();
        order.sort_by(|a, b| places[*a].total_cmp(&places[*b]));
        order.windows(2).all(|pair| places[pair[0]] < places[pair[1]]).then_some(order)
    };
    let (by_row, by_column) = (order(rows)?, order(columns)?);
    let mut values = Vec::with_capacity(rows.len() * columns.len());
    for i in by_row.iter().asking(100) {
        values.extend(by_column.iter().map(|j| value(*i, *j)));
    }
    let sorted = |places: &[f64], order: &[usize]| order.iter().map(|i| places[*i]).collect();
    Some((sorted(rows, &by_row), sorted(columns, &by_column), values))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_and_columns_are_sorted_with_their_values() {
        let (rows, columns, values) = ascending(&[2.0, 1.0], &[5.0, 7.0, 6.0], |i, j| (10 * i + j) as f64).unwrap();
        assert_eq!((rows, columns), (vec![1.0, 2.0], vec![5.0, 6.0, 7.0]));
        assert_eq!(values, [10.0, 12.0, 11.0, 0.0, 2.0, 1.0]);
        assert!(ascending(&[1.0, 1.0], &[0.0], |_, _| 0.0).is_none());
    }
}
