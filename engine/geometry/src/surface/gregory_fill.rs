//! Gregory patches filled into four boundary curves.
//!
//! The borders of the patch are cubics with the ends and end tangents of the curves, which they
//! equal where these are cubics. The derivative across each border is a polynomial of its own:
//! given, or linear between the tangents of the borders that run into it. So it depends on nothing
//! but that border and the tangents at its ends, and patches that share these meet smoothly, which
//! is what the twenty control points are for.

use super::{
    GregoryPatch, Surface,
    boundaries::{Border, Boundaries, CORNERS, jet_over},
    check,
    continuity::Worst,
    gregory::GregoryNet,
};
use crate::{
    curve::{Curve, CurveShape},
    space::Vector,
};
use flankfit_numerics::check::Faults;

/// Places of a border between two breaks where patch and curve are compared.
const LOOKS: usize = 16;

/// The patch, and how far its borders are from the curves at worst. `cross` in the order u0, u1,
/// v0, v1: the derivatives by u or v across the borders, of which the values at the ends (which
/// must be the borders' tangents there, to `tolerance` times 1 / width) and the slopes there count.
pub fn gregory(
    boundaries: &Boundaries,
    cross: &[Option<CurveShape>; 4],
    tolerance: f64,
) -> Result<(GregoryPatch, Worst), Faults> {
    check::tolerance(tolerance)?;
    let domain = boundaries.domain();
    let thirds = domain.map(|[low, high]| (high - low) / 3.0);
    let sign = |end: usize| if end == 0 { 1.0 } else { -1.0 };
    let tangent = |border: usize, end: usize| boundaries.tangent(border, end);
    let mut net = [[Vector::zeros(); 4]; 4];
    for (i, j) in CORNERS {
        let (corner, [a, b]) = (boundaries.corner(i, j), [3 * i, 3 * j]);
        net[a][b] = corner;
        net[1 + i][b] = corner + tangent(2 + j, i) * (sign(i) * thirds[0]);
        net[a][1 + j] = corner + tangent(i, j) * (sign(j) * thirds[1]);
    }
    let mut b_points: [[Vector; 2]; 2] = Default::default();
    for (i, j) in CORNERS {
        let by_v = twist(boundaries, cross, [Border::V0, Border::V1][j], i, tolerance)?;
        let by_u = twist(boundaries, cross, [Border::U0, Border::U1][i], j, tolerance)?;
        let flat = net[1 + i][3 * j] + net[3 * i][1 + j] - net[3 * i][3 * j];
        let area = sign(i) * sign(j) * thirds[0] * thirds[1];
        // across v = const only the a points act, across u = const only the b points
        net[1 + i][1 + j] = flat + by_v * area;
        b_points[i][j] = flat + by_u * area;
    }
    let patch = GregoryPatch::new(domain, boundaries.dimension(), GregoryNet { net, b: b_points })
        .map_err(|_| check::twist_not_finite([0, 0]))?;
    let worst = deviation(boundaries, &patch);
    Ok((patch, worst))
}

/// The slope at `end` of the derivative across `border`.
fn twist(
    boundaries: &Boundaries,
    cross: &[Option<CurveShape>; 4],
    border: Border,
    end: usize,
    tolerance: f64,
) -> Result<Vector, Faults> {
    let domain = boundaries.domain();
    let (along, across) = (border.axis(), 1 - border.axis());
    let [low, high] = domain[along];
    // the borders that run into this one's ends, and which of their ends meets it
    let runs = |end: usize| boundaries.tangent(if along == 1 { 2 + end } else { end }, border.end());
    let Some(curve) = &cross[border as usize] else { return Ok((runs(1) - runs(0)) / (high - low)) };
    if curve.dimension() != boundaries.dimension() {
        return Err(check::border_dimension(border, curve.dimension()));
    }
    let [value, slope, _] = jet_over(curve, domain[along], domain[along][end]);
    let gap = (value - runs(end)).norm() * (domain[across][1] - domain[across][0]);
    if !(gap <= tolerance) {
        let corner = if along == 1 { [border.end(), end] } else { [end, border.end()] };
        return Err(check::cross_off(border, corner, gap, tolerance));
    }
    Ok(slope)
}

/// The largest distance between the borders of `patch` and the curves.
pub(super) fn deviation(boundaries: &Boundaries, patch: &dyn Surface) -> Worst {
    let (domain, breaks) = (boundaries.domain(), boundaries.breaks());
    let mut worst = Worst::default();
    for border in Border::ALL {
        for span in breaks[border.axis()].windows(2) {
            for k in 0..=LOOKS {
                let t = span[0] + (span[1] - span[0]) * (k as f64 / LOOKS as f64);
                let (u, v) = border.place(domain, t);
                let off = patch.value(u, v) - boundaries.jet(border as usize, t)[0];
                worst.see(off.norm(), [u, v]);
            }
        }
    }
    worst
}
