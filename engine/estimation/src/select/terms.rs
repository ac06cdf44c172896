//! Sets of terms that may be used together.

/// The products of powers of a polynomial, or columns that know no order.
pub(super) struct Hierarchy<'a> {
    terms: &'a [(usize, usize)],
    /// True if a term requires all terms that divide it.
    ordered: bool,
    /// A column that always stays.
    constant: Option<usize>,
}

impl<'a> Hierarchy<'a> {
    pub(super) fn new(terms: &'a [(usize, usize)], ordered: bool, constant: Option<usize>) -> Self {
        Hierarchy { terms, ordered, constant }
    }

    /// True if `columns[at]` can go and the others stay.
    pub(super) fn may_go(&self, columns: &[usize], at: usize) -> bool {
        if Some(columns[at]) == self.constant || columns.len() == 1 {
            return false;
        }
        let (i, j) = self.terms[columns[at]];
        let divides = |k: &usize| {
            let (p, q) = self.terms[*k];
            (p, q) != (i, j) && i <= p && j <= q
        };
        !self.ordered || !columns.iter().any(divides)
    }

    /// Terms of `kept` with all that they require, ascending.
    pub(super) fn closed(&self, kept: &[bool]) -> Vec<usize> {
        let stands = |k: &usize| {
            let (i, j) = self.terms[*k];
            let needed = || self.terms.iter().zip(kept).any(|(&(p, q), kept)| *kept && i <= p && j <= q);
            kept[*k] || Some(*k) == self.constant || (self.ordered && needed())
        };
        (0..kept.len()).filter(stands).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_product_needs_its_divisors() {
        let terms = [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0)];
        let ordered = Hierarchy::new(&terms, true, Some(0));
        let may: Vec<bool> = (0..5).map(|at| ordered.may_go(&[0, 1, 2, 3, 4], at)).collect();
        assert_eq!(may, [false, false, false, true, true]);
        assert_eq!(ordered.closed(&[false, false, false, true, false]), [0, 1, 2, 3]);
        assert_eq!(ordered.closed(&[false; 5]), [0]);
        let free = Hierarchy::new(&terms, false, None);
        assert!((0..5).all(|at| free.may_go(&[0, 1, 2, 3, 4], at)) && !free.may_go(&[3], 0));
        assert_eq!(free.closed(&[false, false, false, true, false]), [3]);
    }
}
