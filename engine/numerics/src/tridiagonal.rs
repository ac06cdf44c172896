//! Eigenvalues of symmetric tridiagonal matrices by implicit QL steps.

use super::cancel;

/// Steps for one eigenvalue; two or three are usual.
const MOST_STEPS: usize = 60;

/// Turns `diagonal` (d) with the off-diagonal entries `beside` (e, of the same length, its last
/// entry 0) into eigenvalues in no order, by implicit QL steps with Wilkinson's shift. `turn(i, c,
/// s)` is called for every rotation of the columns i and i+1: `(xᵢ, xᵢ₊₁) ← (c xᵢ − s xᵢ₊₁, s xᵢ +
/// c xᵢ₊₁)`. `None` if the iteration does not converge.
pub(super) fn ql(d: &mut [f64], e: &mut [f64], mut turn: impl FnMut(usize, f64, f64)) -> Option<()> {
    let k = d.len();
    for l in 0..k {
        for step in 0.. {
            cancel::every(20 * k, l + step);
            let small = |m: &usize| e[*m].abs() <= f64::EPSILON * (d[*m].abs() + d[*m + 1].abs());
            let m = (l..k - 1).find(small).unwrap_or(k - 1);
            if m == l {
                break;
            }
            if step == MOST_STEPS {
                return None;
            }
            // Wilkinson's shift
            let half = (d[l + 1] - d[l]) / (2.0 * e[l]);
            let mut g = d[m] - d[l] + e[l] / (half + half.hypot(1.0).copysign(half));
            let (mut s, mut c, mut p) = (1.0, 1.0, 0.0);
            let mut split = false;
            for i in (l..m).rev() {
                let (f, b) = (s * e[i], c * e[i]);
                let r = f.hypot(g);
                e[i + 1] = r;
                if r == 0.0 {
                    d[i + 1] -= p;
                    split = true;
                    break;
                }
                (s, c) = (f / r, g / r);
                let rest = d[i + 1] - p;
                let turned = (d[i] - rest) * s + 2.0 * c * b;
                p = s * turned;
                d[i + 1] = rest + p;
                g = c * turned - b;
                turn(i, c, s);
            }
            if !split {
                d[l] -= p;
                e[l] = g;
            }
            e[m] = 0.0;
        }
    }
    Some(())
}
