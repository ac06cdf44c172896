//! Rows of numbers as a caller gives them: end to end, since a list of lists takes ten times the
//! memory where rows are short. They may differ in length until somebody has looked.

use std::ops::Index;

/// Rows of numbers.
///
/// ```
/// use flankfit_numerics::Rows;
///
/// let rows: Rows = [vec![1.0, 2.0], vec![3.0]].iter().collect();
/// assert_eq!((rows.count(), &rows[1]), (2, &[3.0][..]));
/// assert_eq!(rows, Rows::new(vec![1.0, 2.0, 3.0], vec![2, 1]));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rows {
    values: Vec<f64>,
    /// End of each row, as an index into the entries.
    ends: Vec<usize>,
}

impl Rows {
    /// Rows from numbers row by row, and the length of each row: together all of them.
    pub fn new(values: Vec<f64>, mut lengths: Vec<usize>) -> Self {
        let mut end = 0;
        for length in &mut lengths {
            end += *length;
            *length = end;
        }
        assert_eq!(end, values.len(), "the rows hold all numbers");
        Rows { values, ends: lengths }
    }

    /// Number of rows.
    pub fn count(&self) -> usize {
        self.ends.len()
    }

    /// The rows.
    pub fn iter(&self) -> impl Iterator<Item = &[f64]> {
        (0..self.count()).map(|row| &self[row])
    }

    /// All numbers, row by row.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The same, taken out.
    pub fn into_values(self) -> Vec<f64> {
        self.values
    }
}

impl Index<usize> for Rows {
    type Output = [f64];

    fn index(&self, row: usize) -> &[f64] {
        let begin = row.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.values[begin..self.ends[row]]
    }
}

impl<R: AsRef<[f64]>> FromIterator<R> for Rows {
    fn from_iter<I: IntoIterator<Item = R>>(rows: I) -> Self {
        let mut all = Rows::default();
        for row in rows {
            all.values.extend_from_slice(row.as_ref());
            all.ends.push(all.values.len());
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_any_length_are_stored_end_to_end() {
        let rows = Rows::new(vec![1.0, 2.0, 3.0], vec![0, 2, 0, 1]);
        assert_eq!(rows.iter().map(<[f64]>::len).collect::<Vec<_>>(), [0, 2, 0, 1]);
        assert_eq!((&rows[1], &rows[3]), (&[1.0, 2.0][..], &[3.0][..]));
        assert_eq!(Rows::default().iter().count(), 0);
    }
}
