//! Minima of a function of ln λ: all of them on a grid, each refined by the sign of the slope.

use super::search::Place;
use flankfit_numerics::root::{boundary, root};

/// Grid points for each factor of e.
const DENSITY: f64 = 2.5;
/// Width to which a turning point is found.
const TURN: f64 = 1e-9;
/// Most cells.
const MOST: f64 = 400.0;

/// Returns the minimiser of `at(x)` → (value, slope) over `[low, high]` and its position there; of
/// equal minima the first.
pub(crate) fn least([low, high]: [f64; 2], at: impl Fn(f64) -> (f64, f64)) -> (f64, Place) {
    let cells = ((high - low) * DENSITY).ceil().clamp(1.0, MOST) as usize;
    let grid: Vec<(f64, f64, f64)> = (0..=cells)
        .map(|i| {
            let x = low + (high - low) * (i as f64 / cells as f64);
            let (value, slope) = at(x);
            (x, value, slope)
        })
        .collect();
    let (mut best, mut place) = (f64::INFINITY, low);
    let mut offer = |x: f64, value: f64| {
        // a gain below rounding is no gain: the smaller λ biases less
        if value < best - 1e-15 * best.abs() || (best == f64::INFINITY && value.is_finite()) {
            (best, place) = (value, x);
        }
    };
    for (i, &(x, value, _)) in grid.iter().enumerate() {
        offer(x, value);
        if let Some(&(next, _, rising)) = grid.get(i + 1)
            && grid[i].2 < 0.0
            && rising > 0.0
        {
            let [_, rises] = boundary([x, next], 0.0, |x| at(x).1 < 0.0);
            offer(rises, at(rises).0);
        }
    }
    (place, Place::of(best, [grid[0].1, grid[cells].1]))
}

/// Place at which a slope that changes its sign once turns positive; `None` if there is none within
/// `[low, high]`.
pub(crate) fn turning([low, high]: [f64; 2], slope: impl Fn(f64) -> f64) -> Option<f64> {
    let ends = [low, high].map(|x| (x, slope(x)));
    if ends[0].1 >= 0.0 {
        return Some(low);
    }
    if ends[1].1 <= 0.0 {
        return None;
    }
    root(ends, |x| TURN * x.abs().max(1.0), slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deeper_of_two_minima_is_found() {
        // minima near 1 and 4, the second one deeper
        let f = |x: f64| {
            ((x - 1.0).powi(2) * (x - 4.0).powi(2) - 0.3 * x, {
                2.0 * (x - 1.0) * (x - 4.0).powi(2) + 2.0 * (x - 1.0).powi(2) * (x - 4.0) - 0.3
            })
        };
        let (x, place) = least([-3.0, 8.0], f);
        assert!(place == Place::Inside && (x - 4.0).abs() < 0.1 && f(x).1.abs() < 1e-9, "{x}");
        assert_eq!(least([0.0, 2.0], |x| (x, 1.0)), (0.0, Place::Limit));
    }

    #[test]
    fn turning_points() {
        assert!((turning([-9.0, 9.0], |x| x - 2.5).unwrap() - 2.5).abs() < 1e-7);
        assert_eq!(turning([-9.0, 9.0], |x| x + 10.0), Some(-9.0));
        assert_eq!(turning([-9.0, 9.0], |x| x - 10.0), None);
    }
}
