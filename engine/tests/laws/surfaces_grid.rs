//! Laws of surfaces on grids of nodes, and of evaluation in bulk.

use flankfit_engine::geometry::{
    BSplineBasis,
    curve::Parametrization,
    space::{Dimension, Vector},
    surface::{
        BSplineSurface, BezierSurface, Evaluator, NodeGrid, Surface, SurfaceShape,
        interpolate::interpolate,
        least_squares::{AxisKnots, FINE, least_squares},
    },
};
use proptest::prelude::*;

/// Ascending places with steps between 0.2 and 1.
fn places(n: usize) -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(0.2..1.0f64, n).prop_map(|steps| {
        let mut sum = -2.0;
        steps
            .iter()
            .map(|s| {
                sum += s;
                sum
            })
            .collect()
    })
}

fn vectors(n: usize) -> impl Strategy<Value = Vec<Vector>> {
    prop::collection::vec(prop::array::uniform3(-1.0..1.0f64).prop_map(Vector::from), n)
}

/// A surface with knots of any spacing, some of them repeated, and weights or none.
fn spline() -> impl Strategy<Value = BSplineSurface> {
    let axis = (1usize..7, prop::collection::vec((0.05..1.0f64, 1usize..3), 0..5));
    (axis.clone(), axis, vectors(17 * 17), prop::collection::vec(0.2..2.0f64, 17 * 17), any::<bool>(), any::<bool>())
        .prop_map(|(u, v, points, weights, rational, graph)| {
            let basis = |(p, steps): (usize, Vec<(f64, usize)>)| {
                let mut knots = vec![0.0; p + 1];
                let mut at = 0.0;
                for (step, times) in steps {
                    at += step;
                    knots.extend(std::iter::repeat_n(at, times.min(p)));
                }
                knots.extend(std::iter::repeat_n(at + 0.4, p + 1));
                BSplineBasis::new(p, knots).unwrap()
            };
            let bases = [basis(u), basis(v)];
            let size = bases[0].size() * bases[1].size();
            let dimension = if graph { Dimension::Graph } else { Dimension::Space };
            let points = points[..size].iter().map(|p| if graph { Vector::new(p.x, 0.0, 0.0) } else { *p }).collect();
            let weights = rational.then(|| weights[..size].to_vec());
            BSplineSurface::new(bases, dimension, points, weights).unwrap()
        })
}

/// A sum of products of polynomials of degree 3 and 2.
fn polynomial(c: &[f64], u: f64, v: f64) -> f64 {
    (0..12).map(|k| c[k] * u.powi(k as i32 % 4) * v.powi(k as i32 / 4)).sum()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn many_places_at_once_are_the_same_places(surface in spline(),
        at in prop::collection::vec((0.0..=1.0f64, 0.0..=1.0f64), 1..40)) {
        let [[a, b], [c, d]] = surface.domain();
        let places: Vec<[f64; 2]> = at.iter().map(|(s, t)| [a + s * (b - a), c + t * (d - c)]).collect();
        let shape = SurfaceShape::BSpline(surface.clone());
        let evaluator = Evaluator::new(&shape);
        let (values, jets, heights) = (evaluator.values(&places), evaluator.jets(&places), evaluator.heights(&places));
        let us: Vec<f64> = places.iter().map(|p| p[0]).collect();
        let vs: Vec<f64> = places.iter().map(|p| p[1]).collect();
        let (grid, grid_jets) = (evaluator.grid_values(&us, &vs), evaluator.grid_jets(&us, &vs));
        let grid_heights = evaluator.grid_heights(&us, &vs);
        for (k, [u, v]) in places.into_iter().enumerate() {
            let truth = surface.jet(u, v);
            let diagonal = k * vs.len() + k;
            for value in [values[k], jets[k].value, grid[diagonal], grid_jets[diagonal].value] {
                prop_assert!((value - truth.value).norm() < 1e-14);
            }
            prop_assert!((heights[k] - truth.value.x).abs() < 1e-14
                && (grid_heights[diagonal] - truth.value.x).abs() < 1e-14);
            for jet in [&jets[k], &grid_jets[diagonal]] {
                let pairs = [(jet.u, truth.u), (jet.v, truth.v), (jet.uu, truth.uu), (jet.uv, truth.uv),
                    (jet.vv, truth.vv)];
                for (got, truth) in pairs {
                    prop_assert!((got - truth).norm() < 1e-12 * truth.norm().max(100.0), "{got:?} {truth:?}");
                }
            }
        }
    }

    /// Knots inserted, parts cut out, degrees raised: always the same surface.
    #[test]
    fn other_knots_leave_the_surface(surface in spline(), (s, t) in (0.0..=1.0f64, 0.0..=1.0f64), x in 0.05..0.95f64) {
        let [[a, b], [c, d]] = surface.domain();
        let (u, v) = (a + s * (b - a), c + t * (d - c));
        let truth = surface.value(u, v);
        let (at_u, at_v) = (a + x * (b - a), c + x * (d - c));
        let inserted = surface.refine(0, &[at_u]).unwrap().refine(1, &[at_v, 0.5 * (c + at_v)]).unwrap();
        prop_assert!((inserted.value(u, v) - truth).norm() < 1e-14);
        let raised = surface.elevate(0, 1).unwrap().elevate(1, 2).unwrap();
        prop_assert_eq!(raised.bases()[1].degree(), surface.bases()[1].degree() + 2);
        prop_assert!((raised.value(u, v) - truth).norm() < 1e-14);
        let part = if u <= at_u { surface.restrict(0, a, at_u) } else { surface.restrict(0, at_u, b) };
        prop_assert!((part.unwrap().value(u, v) - truth).norm() < 1e-14);
        let outside = surface.refine(1, &[d + 1.0]).unwrap_err().to_string();
        prop_assert!(outside.starts_with("nodes.v[0]: node 0 along v"), "{}", outside);
        let degree = surface.bases()[0].degree() + 25;
        let message = format!("degree[0]: degree {degree} along u is not within 1 to 25");
        prop_assert_eq!(surface.elevate(0, 25).unwrap_err().to_string(), message);
    }

    #[test]
    fn interpolation_hits_its_nodes_and_reproduces_polynomials(
        u in places(9), v in places(6), z in prop::collection::vec(-1.0..1.0f64, 54),
        c in prop::collection::vec(-1.0..1.0f64, 12), (p, q) in (1usize..6, 1usize..5)
    ) {
        let grid = NodeGrid::heights(u.clone(), v.clone(), &z).unwrap();
        let surface = interpolate(&grid, [p, q], [None, None]).unwrap();
        for (i, x) in u.iter().enumerate() {
            for (j, y) in v.iter().enumerate() {
                prop_assert!((surface.value(*x, *y).x - z[i * 6 + j]).abs() < 1e-13);
            }
        }
        let heights: Vec<f64> = u.iter().flat_map(|x| v.iter().map(|y| polynomial(&c, *x, *y))).collect();
        let grid = NodeGrid::heights(u.clone(), v.clone(), &heights).unwrap();
        let surface = interpolate(&grid, [3, 2], [None, None]).unwrap();
        let (x, y) = (0.3 * u[0] + 0.7 * u[8], 0.6 * v[0] + 0.4 * v[5]);
        let truth = polynomial(&c, x, y);
        let size = heights.iter().fold(1.0f64, |a, b| a.max(b.abs()));
        prop_assert!((surface.value(x, y).x - truth).abs() < 1e-13 * size);
    }

    /// The residuals are at right angles to every product of basis functions, and a surface of the
    /// space is found again.
    #[test]
    fn least_squares_residuals_are_orthogonal_to_all_functions(
        u in places(14), v in places(11), z in prop::collection::vec(-1.0..1.0f64, 154),
        (p, q) in (1usize..4, 1usize..4),
        spans in 1usize..6, large in any::<bool>()
    ) {
        // a grid of more than FINE nodes takes the other way
        let (u, z) = if large {
            let more = FINE / 154 + 1;
            let width = u[13] - u[0] + 0.5;
            let long: Vec<f64> = (0..more).flat_map(|k| u.iter().map(move |x| x + width * k as f64)).collect();
            (long, z.repeat(more))
        } else {
            (u, z)
        };
        let grid = NodeGrid::heights(u.clone(), v.clone(), &z).unwrap();
        let (surface, rss) = least_squares(&grid, [p, q], [AxisKnots::Spans(spans), AxisKnots::Spans(3)]).unwrap();
        let [bu, bv] = surface.bases();
        let mut sums = vec![0.0; bu.size() * bv.size()];
        let (mut nu, mut nv) = (vec![0.0; p + 1], vec![0.0; q + 1]);
        let mut squares = 0.0;
        for (i, x) in u.iter().enumerate() {
            for (j, y) in v.iter().enumerate() {
                let r = z[i * v.len() + j] - surface.value(*x, *y).x;
                squares += r * r;
                let (a, b) = (bu.values(*x, &mut nu), bv.values(*y, &mut nv));
                for (k, nu) in nu.iter().enumerate() {
                    for (l, nv) in nv.iter().enumerate() {
                        sums[(a + k) * bv.size() + b + l] += r * nu * nv;
                    }
                }
            }
        }
        let bound = 1e-14 * (u.len() * v.len()) as f64;
        prop_assert!(sums.iter().all(|s| s.abs() < bound), "{:?}", sums.iter().fold(0.0f64, |a, b| a.max(b.abs())));
        prop_assert!((squares - rss).abs() < 1e-12 * squares);
        let again: Vec<f64> = u.iter().flat_map(|x| v.iter().map(|y| surface.value(*x, *y).x)).collect();
        let knots = surface.bases().each_ref().map(|b| AxisKnots::Given(b.knots().to_vec()));
        let grid = NodeGrid::heights(u.clone(), v.clone(), &again).unwrap();
        let (same, rest) = least_squares(&grid, [p, q], knots).unwrap();
        for (one, other) in same.control_points().iter().zip(surface.control_points()) {
            prop_assert!((one.x - other.x).abs() < 1e-12 * other.x.abs().max(1.0), "{one:?} {other:?}");
        }
        prop_assert!(rest < 1e-24 * again.len() as f64);
    }
}

#[test]
fn bulk_does_not_depend_on_threads() {
    let net = (0..16).map(|k| Vector::new(f64::from(k).sin(), f64::from(k), 1.0)).collect();
    let patch = BezierSurface::new([4, 4], [[0.0, 1.0]; 2], Dimension::Space, net, None).unwrap();
    let shape = SurfaceShape::Bezier(patch);
    let at: Vec<[f64; 2]> = (0..20_000).map(|k| [f64::from(k) / 2e4, f64::from(k % 113) / 113.0]).collect();
    let axis: Vec<f64> = (0..150).map(|k| f64::from(k) / 149.0).collect();
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let evaluator = Evaluator::new(&shape);
        pool.install(|| (evaluator.values(&at), evaluator.grid_values(&axis, &axis)))
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn points_in_rows_get_parameters() {
    // a cylinder's quarter in rows of arcs; the last column is one point, as at a tip
    let rows: Vec<Vec<Vector>> = (0..5)
        .map(|i| {
            let angle = f64::from(i) * 0.3;
            let arc = |j: i32| Vector::new(angle.cos(), angle.sin(), f64::from(j * j)) * f64::from(4 - j);
            (0..5).map(|j| if j == 4 { Vector::z() } else { arc(j) }).collect()
        })
        .collect();
    let grid = NodeGrid::rows(&rows, Parametrization::ChordLength).unwrap();
    let [us, vs] = grid.parameters();
    assert!((us[1] - 0.25).abs() < 1e-14 && us[0] == 0.0 && (us[4] - 1.0).abs() < 1e-15 && vs.len() == 5);
    let surface = interpolate(&grid, [3, 2], [None, None]).unwrap();
    for (i, u) in us.iter().enumerate() {
        for (j, v) in vs.iter().enumerate() {
            assert!((surface.value(*u, *v) - rows[i][j]).norm() < 1e-13);
        }
    }
    let mut twice = rows.clone();
    twice[2][1] = twice[1][1];
    let fault = NodeGrid::rows(&twice, Parametrization::Centripetal).unwrap_err();
    assert!(fault.to_string().starts_with("nodes.points[2][1]: the point (2, 1) and the one before it along u"));
    twice[3].pop();
    let fault = NodeGrid::rows(&twice, Parametrization::Centripetal).unwrap_err();
    assert_eq!(fault.to_string(), "nodes.z[3]: row 3 has 4 points, the first one 5");
    let same = vec![vec![Vector::x(); 3]; 2];
    let fault = NodeGrid::rows(&same, Parametrization::Uniform).unwrap_err();
    assert_eq!(fault.to_string(), "nodes.points: along u all points of every line coincide");
}

#[test]
fn refused_grids() {
    let axis = |n: usize| (0..n).map(|k| k as f64).collect::<Vec<_>>();
    let fault = |u: Vec<f64>, v: Vec<f64>, z: &[f64]| NodeGrid::heights(u, v, z).unwrap_err().to_string();
    assert_eq!(fault(axis(1), axis(2), &[0.0; 2]), "nodes.u: 1 node along u; at least 2 are needed");
    assert_eq!(fault(axis(2), axis(2), &[0.0; 3]), "nodes.z: 3 values for 2 × 2 nodes");
    let missing = fault(axis(2), axis(2), &[0.0, 0.0, f64::NAN, 0.0]);
    assert_eq!(missing, "nodes.z[1][0]: the value at (1, 0) is not finite");
    let repeated = fault(axis(2), vec![0.0, 1.0, 1.0], &[0.0; 6]);
    assert_eq!(repeated, "nodes.v[2]: v number 2 (1) does not lie above the one before it (1)");
    let infinite = fault(vec![0.0, f64::INFINITY], axis(2), &[0.0; 4]);
    assert_eq!(infinite, "nodes.u[1]: u number 1 is not finite");

    let grid = NodeGrid::heights(axis(6), axis(5), &[1.0; 30]).unwrap();
    let through = |degrees, knots| interpolate(&grid, degrees, knots).unwrap_err().to_string();
    assert_eq!(through([3, 0], [None, None]), "degree[1]: degree 0 along v is not within 1 to 25");
    assert_eq!(through([3, 5], [None, None]), "nodes.v: 5 nodes along v; at least 6 are needed");
    let knots = |k: &[f64]| [Some(k.to_vec()), None];
    assert_eq!(
        through([1, 1], knots(&[0., 0., 1., 2., 1.5, 4., 5., 5.])),
        "knots[0][4]: knots along u: knot 4 (1.5) lies below the one before it (2)"
    );
    assert_eq!(through([1, 1], knots(&[0., 0., 5., 5.])), "knots[0]: 2 functions along u for 6 nodes");
    assert_eq!(
        through([1, 1], knots(&[0., 0., 1., 2., 3., 3.5, 4., 4.])),
        "nodes.u[5]: node 5 along u (5) lies outside of the knots' domain, [0, 4]"
    );
    let alone = through([1, 1], knots(&[0., 0., 0.1, 0.2, 0.3, 4., 5., 5.]));
    assert!(alone.starts_with(
        "knots[0][1]: no node along u is left for function 1, which is non-zero between knots 0 and \
            0.2"
    ));

    let near = |knots| least_squares(&grid, [2, 1], [knots, AxisKnots::Uniform(1)]).unwrap_err().to_string();
    assert!(near(AxisKnots::Spans(5)).starts_with("spans[0]: 5 spans along u need more functions than the 6 nodes"));
    assert!(near(AxisKnots::Uniform(0)).starts_with("spans[0]: 0 spans along u"));
    let alone = near(AxisKnots::Given(vec![0., 0., 0., 3.1, 3.2, 3.3, 5., 5., 5.]));
    assert!(alone.starts_with(
        "knots[0][4]: no node along u is left for function 4, which is non-zero between knots 3.2 \
            and 5"
    ));
    let many = AxisKnots::Given(vec![0., 0., 0., 0.5, 1., 2., 3., 4., 5., 5., 5.]);
    assert_eq!(near(many), "knots[0]: 8 functions along u for 6 nodes");
}
