//! Nets of values: rows along u, v within a row.

use super::point::{self, PointBody};
use crate::api::faults::Faults;
use flankfit_engine::{
    geometry::space::{Dimension, Vector},
    words::counted,
};

/// Values of one kind, in rows of one length.
pub struct Net {
    pub dimension: Dimension,
    pub rows: usize,
    pub columns: usize,
    /// v running fastest.
    pub values: Vec<Vector>,
}

impl Net {
    /// The end of a pointer to the value at `index`.
    pub fn place(columns: usize, index: usize) -> String {
        format!("{}/{}", index / columns.max(1), index % columns.max(1))
    }

    /// Reads rows of values that stand at `at`.
    pub fn read(rows: &[Vec<PointBody>], at: &str, faults: &mut Faults) -> Option<Self> {
        let columns = equal_rows(rows, at, faults)?;
        let flat: Vec<PointBody> = rows.concat();
        let place = |index| format!("{at}/{}", Self::place(columns, index));
        let (dimension, values) = point::read_by(&flat, at, place, faults)?;
        Some(Net { dimension, rows: rows.len(), columns, values })
    }

    /// Rows of values as they are written.
    pub fn written(dimension: Dimension, columns: usize, values: &[Vector]) -> Vec<Vec<PointBody>> {
        values.chunks(columns.max(1)).map(|row| point::written(dimension, row)).collect()
    }
}

/// The length that all rows have.
pub fn equal_rows<T>(rows: &[Vec<T>], at: &str, faults: &mut Faults) -> Option<usize> {
    let columns = rows.first().map_or(0, Vec::len);
    if columns == 0 {
        faults.push(at, "at least one row with at least one value is required");
        return None;
    }
    let before = faults.count();
    for (i, row) in rows.iter().enumerate().filter(|(_, row)| row.len() != columns) {
        faults.push(
            format!("{at}/{i}"),
            format!("{}, where the first row has {columns}", counted(row.len(), "value", "values")),
        );
    }
    (faults.count() == before).then_some(columns)
}
