//! The point of a polyhedron nearest to a given point, half-space by half-space: the dual
//! active-set method of Goldfarb and Idnani (Mathematical Programming 27, 1983), for which a
//! Hessian of 1 leaves little more than the orthogonal factor of the active normals.
//!
//! After each half-space the point is the nearest one to the start that lies in those still active,
//! so the distance only grows: a half-space that is needed again comes back in, and no set of
//! active ones returns.

use super::{cancel, dot};

/// A normal whose part orthogonal to the active ones is shorter than this is a sum of them.
const DEPENDENT: f64 = 1e-10;

/// No point lies in all half-spaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Empty;

/// The nearest point so far.
#[derive(Clone, Debug)]
pub struct NearestPoint {
    at: Vec<f64>,
    active: Vec<HalfSpace>,
    /// Orthonormal columns that span the active normals.
    q: Vec<Vec<f64>>,
    /// Upper triangle by columns: normals are `Q R`.
    r: Vec<Vec<f64>>,
}

/// An active half-space `normal · x ≥ bound`.
#[derive(Clone, Debug)]
pub struct HalfSpace {
    /// Its normal.
    pub normal: Vec<f64>,
    /// Offset of the half-space: the least value of `normal · x`.
    pub bound: f64,
    /// Whatever the caller knows it by.
    pub tag: usize,
    /// Its multiplier, not below 0: the point is the start plus Σ multiplier · normal.
    pub multiplier: f64,
}

impl NearestPoint {
    /// Makes a point that nothing limits yet.
    ///
    /// ```
    /// use flankfit_numerics::polyhedron::NearestPoint;
    ///
    /// // The quadrant x ≥ 1, y ≥ 0, seen from (−2, −3) and by way of x + y ≥ 4.
    /// let mut nearest = NearestPoint::new(vec![-2.0, -3.0]);
    /// nearest.enter(vec![1.0, 0.0], 1.0, 0).expect("there are such points");
    /// assert_eq!(nearest.at(), [1.0, -3.0]);
    /// nearest.enter(vec![0.0, 1.0], 0.0, 1).expect("there are such points");
    /// assert_eq!(nearest.at(), [1.0, 0.0]);
    /// nearest.enter(vec![1.0, 1.0], 4.0, 2).expect("there are such points");
    /// assert!((nearest.at()[0] - 2.5).abs() < 1e-12 && (nearest.at()[1] - 1.5).abs() < 1e-12);
    /// // Of the three only the last still limits it.
    /// let active: Vec<usize> = nearest.active().iter().map(|one| one.tag).collect();
    /// assert_eq!(active, [2]);
    /// // No such point has x ≤ 0.
    /// assert!(nearest.enter(vec![-1.0, 0.0], 0.0, 3).is_ok());
    /// assert!(nearest.enter(vec![1.0, 0.0], 1.0, 0).is_err());
    /// ```
    pub fn new(start: Vec<f64>) -> Self {
        NearestPoint { at: start, active: Vec::new(), q: Vec::new(), r: Vec::new() }
    }

    /// The nearest point.
    pub fn at(&self) -> &[f64] {
        &self.at
    }

    /// Half-spaces on whose borders the point lies.
    pub fn active(&self) -> &[HalfSpace] {
        &self.active
    }

    /// Moves into `normal · x ≥ bound`, within the half-spaces that are active.
    pub fn enter(&mut self, normal: Vec<f64>, bound: f64, tag: usize) -> Result<(), Empty> {
        let length = dot(&normal, &normal).sqrt();
        let mut multiplier = 0.0;
        loop {
            cancel::checkpoint();
            let missing = bound - dot(&normal, &self.at);
            if !(missing > 0.0) {
                // a step along dependent normals may have ended where the half-space begins
                return Ok(());
            }
            let (along, beyond) = self.split(&normal);
            let square = dot(&beyond, &beyond);
            let dependent = square.sqrt() <= DEPENDENT * length;
            let mut shares = along.clone();
            self.solve(&mut shares);
            let leaving = self.first_to_leave(&shares);
            let whole = missing / square;
            let step = match leaving {
                Some((_, step)) if dependent || step < whole => step,
                _ if dependent => return Err(Empty),
                _ => whole,
            };
            for (one, share) in self.active.iter_mut().zip(&shares) {
                one.multiplier = (one.multiplier - step * share).max(0.0);
            }
            multiplier += step;
            if !dependent {
                self.at.iter_mut().zip(&beyond).for_each(|(x, z)| *x += step * z);
            }
            match leaving {
                Some((index, own)) if dependent || own < whole => self.leave(index),
                _ => {
                    let size = square.sqrt();
                    self.q.push(beyond.iter().map(|z| z / size).collect());
                    self.r.push(along.iter().copied().chain([size]).collect());
                    self.active.push(HalfSpace { normal, bound, tag, multiplier });
                    return Ok(());
                }
            }
        }
    }

    /// Components of the normal in the span of the active normals, and the remainder orthogonal to
    /// it.
    fn split(&self, normal: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut beyond = normal.to_vec();
        let mut along = vec![0.0; self.q.len()];
        // twice is enough
        for _ in 0..2 {
            for (share, q) in along.iter_mut().zip(&self.q) {
                let part = dot(q, &beyond);
                beyond.iter_mut().zip(q).for_each(|(z, q)| *z -= part * q);
                *share += part;
            }
        }
        (along, beyond)
    }

    /// Solves `R x = b` in place.
    fn solve(&self, b: &mut [f64]) {
        for j in (0..b.len()).rev() {
            b[j] /= self.r[j][j];
            let x = b[j];
            b[..j].iter_mut().zip(&self.r[j]).for_each(|(b, r)| *b -= x * r);
        }
    }

    /// Solves `RᵀR x = b` in place: the normals' products with each other.
    pub fn solve_gram(&self, b: &mut [f64]) {
        for j in 0..b.len() {
            b[j] = (b[j] - dot(&self.r[j][..j], &b[..j])) / self.r[j][j];
        }
        self.solve(b);
    }

    /// Index of the multiplier that reaches 0 first, and the step after which it does.
    fn first_to_leave(&self, shares: &[f64]) -> Option<(usize, f64)> {
        let largest = shares.iter().fold(0.0, |most: f64, share| most.max(share.abs()));
        let falls = |share: f64| share > 1e-12 * largest;
        let steps = self.active.iter().zip(shares).enumerate().filter(|(_, (_, share))| falls(**share));
        steps.map(|(j, (one, share))| (j, one.multiplier / share)).min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Takes a normal out of the factor, by rotations of the rows of R below it.
    fn leave(&mut self, index: usize) {
        self.active.remove(index);
        self.r.remove(index);
        for k in index..self.r.len() {
            let (a, b) = (self.r[k][k], self.r[k][k + 1]);
            let length = a.hypot(b);
            let (c, s) = if length > 0.0 { (a / length, b / length) } else { (1.0, 0.0) };
            for column in &mut self.r[k..] {
                let (x, y) = (column[k], column[k + 1]);
                (column[k], column[k + 1]) = (c * x + s * y, c * y - s * x);
            }
            self.r[k].truncate(k + 1);
            let (head, tail) = self.q.split_at_mut(k + 1);
            for (x, y) in head[k].iter_mut().zip(&mut tail[0]) {
                (*x, *y) = (c * *x + s * *y, c * *y - s * *x);
            }
        }
        self.q.truncate(self.r.len());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The nearest point by trying every set of active half-spaces (up to three of them).
    fn by_trying(start: &[f64; 3], spaces: &[([f64; 3], f64)]) -> Option<[f64; 3]> {
        let count = spaces.len();
        let mut best: Option<(f64, [f64; 3])> = None;
        for set in (0u32..1 << count).filter(|set| set.count_ones() <= 3) {
            let chosen: Vec<_> = (0..count).filter(|i| set >> i & 1 == 1).map(|i| spaces[i]).collect();
            let k = chosen.len();
            let gram = nalgebra::DMatrix::from_fn(k, k, |i, j| dot(&chosen[i].0, &chosen[j].0));
            let missing = nalgebra::DVector::from_fn(k, |i, _| chosen[i].1 - dot(&chosen[i].0, start));
            let Some(multipliers) = (if k == 0 { Some(missing) } else { gram.lu().solve(&missing) }) else { continue };
            let mut at = *start;
            for ((normal, _), u) in chosen.iter().zip(multipliers.iter()) {
                at.iter_mut().zip(normal).for_each(|(x, n)| *x += u * n);
            }
            let inside = spaces.iter().all(|(normal, bound)| dot(normal, &at) >= bound - 1e-9);
            let far = at.iter().zip(start).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
            if inside && best.is_none_or(|(least, _)| far < least) {
                best = Some((far, at));
            }
        }
        best.map(|(_, at)| at)
    }

    proptest! {
        /// Half-spaces around the origin, which lies in all of them: entered until all hold.
        #[test]
        fn it_is_the_nearest_of_all(
            start in prop::array::uniform3(-3.0..3.0f64),
            spaces in prop::collection::vec((prop::array::uniform3(-1.0..1.0f64), -1.0..-0.05f64), 1..7),
        ) {
            let mut nearest = NearestPoint::new(start.to_vec());
            for _ in 0..200 {
                let worst = spaces
                    .iter()
                    .enumerate()
                    .map(|(tag, (normal, bound))| (bound - dot(normal, nearest.at()), tag))
                    .max_by(|a, b| a.0.total_cmp(&b.0))
                    .unwrap();
                if worst.0 <= 1e-12 {
                    break;
                }
                let (normal, bound) = spaces[worst.1];
                prop_assert!(nearest.enter(normal.to_vec(), bound, worst.1).is_ok());
            }
            let expected = by_trying(&start, &spaces).unwrap();
            for (x, e) in nearest.at().iter().zip(expected) {
                prop_assert!((x - e).abs() < 1e-7, "{:?} {expected:?}", nearest.at());
            }
            // the multipliers explain the way
            for (k, start) in start.iter().enumerate() {
                let moved: f64 = nearest.active().iter().map(|one| one.multiplier * one.normal[k]).sum();
                prop_assert!((start + moved - nearest.at()[k]).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn contradictory_constraints_are_detected() {
        let mut nearest = NearestPoint::new(vec![0.0, 0.0]);
        nearest.enter(vec![1.0, 0.0], 1.0, 0).unwrap();
        assert_eq!(nearest.enter(vec![-1.0, 0.0], -0.5, 1), Err(Empty));
    }
}
