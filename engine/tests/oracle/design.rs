//! The columns of the models, by the textbook recurrences, in the oracle's numbers.

use super::big::Big;
use super::matrix::Rows;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Basis<'a> {
    Monomial,
    /// On the interval mapped to [-1, 1].
    Chebyshev([f64; 2]),
    Legendre([f64; 2]),
    /// The full knot vector.
    BSpline(&'a [f64]),
}

/// The values at `x` of every function up to `degree` (of every B-spline of that degree).
pub fn functions(basis: Basis<'_>, degree: usize, x: f64) -> Vec<Big> {
    match basis {
        Basis::Monomial => recurrence(degree, &Big::from(x), |_, t, p, _| t * p),
        Basis::Chebyshev(domain) => {
            recurrence(degree, &mapped(domain, x), |_, t, p, before| &(&Big::from(2.0) * &(t * p)) - before)
        }
        Basis::Legendre(domain) => recurrence(degree, &mapped(domain, x), |k, t, p, before| {
            let (next, last) = (&Big::from(2 * k + 1) * &(t * p), &Big::from(k) * before);
            &(&next - &last) / &Big::from(k + 1)
        }),
        Basis::BSpline(knots) => cox_de_boor(knots, degree, x),
    }
}

fn mapped([low, high]: [f64; 2], x: f64) -> Big {
    let (low, high, x) = (Big::from(low), Big::from(high), Big::from(x));
    &(&(&x - &low) - &(&high - &x)) / &(&high - &low)
}

/// Functions 0 (one), 1 (t) and `step(k, t, f_k, f_{k−1})` for k+1.
fn recurrence(degree: usize, t: &Big, step: impl Fn(usize, &Big, &Big, &Big) -> Big) -> Vec<Big> {
    let mut f = vec![Big::one(), t.clone()];
    for k in 1..degree {
        let next = step(k, t, &f[k], &f[k - 1]);
        f.push(next);
    }
    f.truncate(degree + 1);
    f
}

/// All B-splines by their definition (Eq. 8), the last span closed on the right.
fn cox_de_boor(knots: &[f64], degree: usize, x: f64) -> Vec<Big> {
    let last = *knots.last().expect("knots");
    let inside = |i: usize| {
        let (low, high) = (knots[i], knots[i + 1]);
        low < high && low <= x && (x < high || (x == last && high == last))
    };
    let mut f: Vec<Big> = (0..knots.len() - 1).map(|i| if inside(i) { Big::one() } else { Big::zero() }).collect();
    let x = Big::from(x);
    let knots: Vec<Big> = knots.iter().map(|k| Big::from(*k)).collect();
    let part = |above: Big, width: Big, f: &Big| if width.is_zero() { Big::zero() } else { &(&above / &width) * f };
    for p in 1..=degree {
        f = (0..f.len() - 1)
            .map(|i| {
                let rising = part(&x - &knots[i], &knots[i + p] - &knots[i], &f[i]);
                let falling = part(&knots[i + p + 1] - &x, &knots[i + p + 1] - &knots[i + 1], &f[i + 1]);
                rising + falling
            })
            .collect();
    }
    f
}

pub fn curve(basis: Basis<'_>, degree: usize, x: &[f64]) -> Rows {
    x.iter().map(|x| functions(basis, degree, *x)).collect()
}

/// One row per node; the columns are the products kept by `keep(p, q)`, lexicographic in (p, q).
pub fn surface(
    bases: [Basis<'_>; 2],
    degrees: [usize; 2],
    nodes: &[[f64; 2]],
    keep: impl Fn(usize, usize) -> bool,
) -> Rows {
    nodes
        .iter()
        .map(|[u, v]| {
            let (in_u, in_v) = (functions(bases[0], degrees[0], *u), functions(bases[1], degrees[1], *v));
            let mut row = Vec::new();
            for (p, f) in in_u.iter().enumerate() {
                row.extend(in_v.iter().enumerate().filter(|(q, _)| keep(p, *q)).map(|(_, g)| f * g));
            }
            row
        })
        .collect()
}

/// The crossings of two axes, row by row.
pub fn crossings(u: &[f64], v: &[f64]) -> Vec<[f64; 2]> {
    u.iter().flat_map(|u| v.iter().map(|v| [*u, *v])).collect()
}
