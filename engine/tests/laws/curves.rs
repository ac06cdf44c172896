//! Laws of curves: what B-splines keep, what interpolation means, and that measures agree with
//! their definitions.

use crate::problems::config;
use flankfit_engine::geometry::BSplineBasis;
use flankfit_engine::geometry::curve::{
    BSplineCurve, Closest, Curve, CurveShape, Ends, KnotChoice, Method, Parametrization, Points, Tangents, arc_length,
    bending, construct::shape_through, knots, measure::DEFAULT_TOLERANCE, through,
};
use flankfit_engine::geometry::space::{Dimension, Vector};
use proptest::prelude::*;

fn vector() -> impl Strategy<Value = Vector> {
    prop::array::uniform3(-1.0f64..1.0).prop_map(Vector::from)
}

/// A B-spline curve of space, clamped, with inner knots of any multiplicity that keeps it
/// continuous; with weights or without.
fn b_spline() -> impl Strategy<Value = BSplineCurve> {
    let spans = prop::collection::vec((0.1f64..1.0, 1usize..5), 0..5);
    (1usize..6, spans, any::<bool>(), prop::collection::vec((vector(), 0.2f64..3.0), 31)).prop_map(
        |(p, spans, rational, controls)| {
            let mut knots = vec![0.0; p + 1];
            let mut at = 0.0;
            for (width, times) in spans {
                at += width;
                knots.extend(std::iter::repeat_n(at, times.min(p)));
            }
            knots.extend(vec![at + 0.7; p + 1]);
            let basis = BSplineBasis::new(p, knots).unwrap();
            let (points, weights): (Vec<Vector>, Vec<f64>) = controls.into_iter().take(basis.size()).unzip();
            BSplineCurve::new(basis, Dimension::Space, points, rational.then_some(weights)).unwrap()
        },
    )
}

/// Ascending places with the points there, first and last alike where asked.
fn nodes(count: std::ops::Range<usize>) -> impl Strategy<Value = (Vec<f64>, Vec<Vector>)> {
    prop::collection::vec((0.2f64..1.0, vector()), count).prop_map(|steps| {
        let mut at = -2.0;
        let step = |(width, value)| {
            at += width;
            (at, value)
        };
        steps.into_iter().map(step).unzip()
    })
}

fn linear_methods(count: usize) -> Vec<Method> {
    let mut methods = vec![
        Method::Lagrange,
        Method::Newton,
        Method::Hermite { derivatives: vec![Vec::new(); count] },
        Method::CubicHermite(Tangents::FiniteDifference),
        Method::CubicHermite(Tangents::CatmullRom),
        Method::CubicHermite(Tangents::Parabola),
        Method::CubicSpline(Ends::natural()),
        Method::CubicSpline(Ends::not_a_knot()),
    ];
    for degree in 1..count.min(6) {
        methods.push(Method::BSpline { degree, knots: KnotChoice::Averaging });
        methods.push(Method::BSpline { degree, knots: KnotChoice::NotAKnot });
    }
    methods
}

fn methods(count: usize) -> Vec<Method> {
    let rules = [Tangents::Monotone, Tangents::Akima, Tangents::ModifiedAkima];
    linear_methods(count).into_iter().chain(rules.map(Method::CubicHermite)).collect()
}

fn graph(x: &[f64], values: &[Vector]) -> Points {
    Points::Graph { x: x.to_vec(), y: values.iter().map(|v| v.x).collect() }
}

fn space(points: Vec<Vector>, parametrization: Parametrization) -> Points {
    Points::Space { points, dimension: Dimension::Space, parametrization }
}

/// Places of the domain, ends included, none of them at an inner break.
fn places(curve: &impl Curve, count: usize) -> Vec<f64> {
    let [low, high] = curve.domain();
    let breaks = curve.breaks();
    let place = |i: usize| low + (high - low) * i as f64 / count as f64;
    (0..=count).map(place).filter(|t| *t == low || *t == high || breaks.iter().all(|b| (b - t).abs() > 1e-4)).collect()
}

fn changes_of_side(sides: impl Iterator<Item = f64>) -> usize {
    let signs: Vec<bool> = sides.filter(|s| s.abs() > 1e-12).map(|s| s > 0.0).collect();
    signs.windows(2).filter(|s| s[0] != s[1]).count()
}

proptest! {
    #![proptest_config(config(48))]

    #[test]
    fn knots_and_degrees_leave_the_curve(curve in b_spline(), part in 0.01f64..0.99, more in 1usize..4) {
        let [low, high] = curve.domain();
        let at = low + part * (high - low);
        let [left, right] = [[low, at], [at, high]].map(|[low, high]| curve.restrict(low, high).unwrap());
        let elevated = curve.elevate(more).unwrap();
        prop_assert_eq!(elevated.basis().degree(), curve.basis().degree() + more);
        let inserted = curve.refine(&[at]).unwrap();
        prop_assert_eq!(inserted.control_points().len(), curve.control_points().len() + 1);
        for t in places(&curve, 60) {
            let value = curve.value(t);
            for other in [&inserted, &elevated, if t < at { &left } else { &right }] {
                prop_assert!((other.value(t) - value).amax() < 1e-13, "{} {:?}", t, (other.value(t) - value));
            }
        }
    }

    #[test]
    fn inside_the_hull_of_its_control_points(curve in b_spline(), normal in vector()) {
        // in every direction: no value outside the extremes of the degree + 1 control points that
        // count
        for t in places(&curve, 40) {
            let mut basis = vec![0.0; curve.basis().degree() + 1];
            let first = curve.basis().values(t, &mut basis);
            prop_assert!((basis.iter().sum::<f64>() - 1.0).abs() < 1e-14 && basis.iter().all(|n| *n >= 0.0));
            let along: Vec<f64> = curve.control_points()[first..][..basis.len()].iter()
                .map(|p| p.dot(&normal)).collect();
            let value = curve.value(t).dot(&normal);
            let (low, high) = along.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
            prop_assert!(value >= low - 1e-14 && value <= high + 1e-14);
        }
    }

    #[test]
    fn no_plane_is_crossed_more_often_than_by_the_polygon(curve in b_spline(), normal in vector(),
        height in -0.5f64..0.5) {
        let polygon = changes_of_side(curve.control_points().iter().map(|p| p.dot(&normal) - height));
        let along = changes_of_side(places(&curve, 500).into_iter().map(|t| curve.value(t).dot(&normal) - height));
        prop_assert!(along <= polygon, "{} {}", along, polygon);
    }

    #[test]
    fn control_points_move_with_the_curve(curve in b_spline(), rows in prop::array::uniform3(vector()),
        shift in vector()) {
        let map = |p: &Vector| Vector::new(rows[0].dot(p), rows[1].dot(p), rows[2].dot(p)) + shift;
        let points = curve.control_points().iter().map(map).collect();
        let weights = curve.weights().map(<[f64]>::to_vec);
        let moved = BSplineCurve::new(curve.basis().clone(), Dimension::Space, points, weights).unwrap();
        for t in places(&curve, 20) {
            prop_assert!((moved.value(t) - map(&curve.value(t))).amax() < 1e-14);
        }
    }

    #[test]
    fn derivatives_are_limits_of_differences((x, values) in nodes(4..9), curve in b_spline()) {
        let mut shapes = vec![CurveShape::BSpline(curve)];
        for method in methods(x.len()) {
            shapes.push(shape_through(&graph(&x, &values), &method).unwrap().0);
            shapes.push(shape_through(&space(values.clone(), Parametrization::ChordLength), &method).unwrap().0);
        }
        for shape in shapes {
            let [low, high] = shape.domain();
            let h = 1e-6 * (high - low);
            for t in places(&shape, 11).into_iter().filter(|t| *t > low && *t < high) {
                let (before, here, after) = (shape.jet(t - h), shape.jet(t), shape.jet(t + h));
                for k in 0..3 {
                    let difference = (after[k] - before[k]) / (2.0 * h);
                    // two values cancel, and the fourth derivative counts
                    let size = here[k].amax() * 1e-9 / h + 1e3 * (here[3].amax() + here[k + 1].amax()) * 1e-6 + 1e-3;
                    prop_assert!((difference - here[k + 1]).amax() < size, "{:?} {} {}", shape, t, k);
                }
            }
        }
    }

    #[test]
    fn every_method_passes_through_its_points((x, values) in nodes(4..12)) {
        for method in methods(x.len()) {
            let (curve, at) = shape_through(&graph(&x, &values), &method).unwrap();
            prop_assert_eq!(&at, &x);
            for (x, v) in x.iter().zip(&values) {
                prop_assert!((curve.value(*x).x - v.x).abs() < 1e-14);
                prop_assert_eq!(curve.value(*x).yz(), Vector::zeros().yz());
            }
            for parametrization in [Parametrization::Uniform, Parametrization::ChordLength,
                Parametrization::Centripetal] {
                let (curve, at) = shape_through(&space(values.clone(), parametrization), &method).unwrap();
                prop_assert_eq!((at[0], at[at.len() - 1]), (0.0, 1.0));
                for (t, v) in at.iter().zip(&values) {
                    prop_assert!((curve.value(*t) - v).amax() < 1e-11);
                }
            }
        }
    }

    #[test]
    fn curves_move_with_their_points((_, values) in nodes(4..10), rows in prop::array::uniform3(vector()),
        shift in vector()) {
        let map = |p: &Vector| Vector::new(rows[0].dot(p), rows[1].dot(p), rows[2].dot(p)) + shift;
        let moved: Vec<Vector> = values.iter().map(map).collect();
        for method in linear_methods(values.len()) {
            let (one, _) = shape_through(&space(values.clone(), Parametrization::Uniform), &method).unwrap();
            let (other, _) = shape_through(&space(moved.clone(), Parametrization::Uniform), &method).unwrap();
            for t in places(&one, 30) {
                let size = 1.0 + one.value(t).amax();
                prop_assert!((other.value(t) - map(&one.value(t))).amax() < 1e-12 * size);
            }
        }
    }

    #[test]
    fn a_cubic_is_reproduced((x, _) in nodes(4..8), c in prop::array::uniform4(-1.0f64..1.0)) {
        let cubic = |x: f64| c[0] + x * (c[1] + x * (c[2] + x * c[3]));
        let y: Vec<f64> = x.iter().map(|x| cubic(*x)).collect();
        let derivatives: Vec<Vec<Vector>> = (0..x.len()).map(|i| match i % 3 {
            0 => Vec::new(),
            1 => vec![Vector::x() * (c[1] + x[i] * (2.0 * c[2] + x[i] * 3.0 * c[3]))],
            _ => vec![
                Vector::x() * (c[1] + x[i] * (2.0 * c[2] + x[i] * 3.0 * c[3])),
                Vector::x() * (2.0 * c[2] + 6.0 * c[3] * x[i]),
            ],
        }).collect();
        let mut all = vec![
            Method::Lagrange,
            Method::Newton,
            Method::Hermite { derivatives },
            Method::CubicSpline(Ends::not_a_knot()),
        ];
        all.extend((3..x.len().min(8)).map(|degree| Method::BSpline { degree, knots: KnotChoice::Averaging }));
        let points = Points::Graph { x: x.clone(), y };
        for method in all {
            let (curve, _) = shape_through(&points, &method).unwrap();
            for t in places(&curve, 30) {
                prop_assert!((curve.value(t).x - cubic(t)).abs() < 1e-10 * (1.0 + cubic(t).abs()), "{:?} {}", method,
                    t);
            }
        }
    }

    #[test]
    fn errors_grow_by_the_lebesgue_constant_at_most((x, values) in nodes(4..9),
        errors in prop::collection::vec(-1.0f64..1.0, 9)) {
        for method in linear_methods(x.len()) {
            let one = through(&graph(&x, &values), &method).unwrap();
            let moved: Vec<Vector> = values.iter().zip(&errors).map(|(v, e)| v + Vector::x() * *e).collect();
            let other = shape_through(&graph(&x, &moved), &method).unwrap().0;
            let constant = one.stability.lebesgue.unwrap().constant;
            for t in places(&one.shape, 200) {
                let moved = (one.shape.value(t) - other.value(t)).x.abs();
                prop_assert!(moved <= constant * (1.0 + 1e-9), "{:?} {} {}", method, moved, constant);
            }
        }
    }

    #[test]
    fn monotone_curves_stay_between_their_nodes((x, values) in nodes(2..12)) {
        let curve = through(&graph(&x, &values), &Method::CubicHermite(Tangents::Monotone)).unwrap();
        prop_assert_eq!(curve.stability.overshoot, None);
        for (x, y) in x.windows(2).zip(values.windows(2)) {
            for k in 0..=20 {
                let value = curve.shape.value(x[0] + (x[1] - x[0]) * f64::from(k) / 20.0).x;
                prop_assert!(value >= y[0].x.min(y[1].x) - 1e-15 && value <= y[0].x.max(y[1].x) + 1e-15);
            }
        }
    }

    #[test]
    fn an_overshoot_is_the_largest((x, values) in nodes(3..9)) {
        for method in methods(x.len()) {
            let curve = through(&graph(&x, &values), &method).unwrap();
            let amount = curve.stability.overshoot.map_or(0.0, |o| o.amount);
            if let Some(o) = curve.stability.overshoot {
                let [a, b] = o.between.map(|i| values[i].x);
                let value = curve.shape.value(o.at).x;
                prop_assert!(((value - a.max(b)).max(a.min(b) - value) - amount).abs() < 1e-14);
            }
            for (x, y) in x.windows(2).zip(values.windows(2)) {
                for k in 0..=50 {
                    let value = curve.shape.value(x[0] + (x[1] - x[0]) * f64::from(k) / 50.0).x;
                    let over = (value - y[0].x.max(y[1].x)).max(y[0].x.min(y[1].x) - value);
                    prop_assert!(over <= amount + 1e-13, "{:?} {} {}", method, over, amount);
                }
            }
        }
    }

    #[test]
    fn a_period_goes_on((x, mut values) in nodes(3..12)) {
        let last = values.len() - 1;
        values[last] = values[0];
        let (curve, _) = shape_through(&graph(&x, &values), &Method::CubicSpline(Ends::Periodic)).unwrap();
        let (start, end) = (curve.jet(x[0]), curve.jet(x[last]));
        for k in 0..3 {
            prop_assert!((start[k] - end[k]).amax() < 1e-11 * (1.0 + start[k].amax()));
        }
        // the same spline of the points from another one on
        let turn = 1 + last / 2;
        let period = x[last] - x[0];
        let again: Vec<f64> = x[turn..].iter().copied().chain(x[1..=turn].iter().map(|x| x + period)).collect();
        let turned: Vec<Vector> = values[turn..].iter().chain(&values[1..=turn]).copied().collect();
        let (other, _) = shape_through(&graph(&again, &turned), &Method::CubicSpline(Ends::Periodic)).unwrap();
        for t in places(&curve, 40) {
            let shifted = if t < x[turn] { t + period } else { t };
            prop_assert!((curve.value(t) - other.value(shifted)).amax() < 1e-12);
        }
    }

    #[test]
    fn any_curve_is_a_b_spline((x, values) in nodes(4..10)) {
        for method in methods(x.len()) {
            for points in [graph(&x, &values), space(values.clone(), Parametrization::Centripetal)] {
                let (curve, _) = shape_through(&points, &method).unwrap();
                let spline = curve.to_b_spline().unwrap();
                prop_assert_eq!(spline.domain(), curve.domain());
                let largest = places(&curve, 40).iter().fold(1.0f64, |m, t| m.max(curve.value(*t).amax()));
                for t in places(&curve, 40) {
                    prop_assert!((spline.value(t) - curve.value(t)).amax() < 1e-13 * largest, "{:?} {}", method, t);
                }
            }
        }
    }

    #[test]
    fn no_sample_is_closer_than_the_closest_point(curve in b_spline(), to in vector(), scale in -4i32..3) {
        let to = to * 2f64.powi(scale);
        let shape = CurveShape::BSpline(curve);
        let answer = Closest::on(&shape).to(to);
        prop_assert!((shape.value(answer.parameter) - answer.point).amax() < 1e-15);
        prop_assert_eq!(answer.distance, (answer.point - to).norm());
        let [low, high] = shape.domain();
        for k in 0..=3000 {
            let sampled = (shape.value(low + (high - low) * f64::from(k) / 3000.0) - to).norm();
            prop_assert!(answer.distance <= sampled * (1.0 + 1e-13), "{} {}", answer.distance, sampled);
        }
        // a point of the curve is its own
        let on = shape.value(low + 0.37 * (high - low));
        prop_assert!(Closest::on(&shape).to(on).distance < 1e-14);
    }

    #[test]
    fn lengths_add_up_and_know_no_parameter(curve in b_spline(), part in 0.1f64..0.9) {
        let [low, high] = curve.domain();
        let at = low + part * (high - low);
        let of = |curve: &BSplineCurve, a: f64, b: f64| arc_length(curve, a, b, DEFAULT_TOLERANCE).unwrap().length;
        let whole = of(&curve, low, high);
        prop_assert!((of(&curve, low, at) + of(&curve, at, high) - whole).abs() < 1e-10 * whole);
        prop_assert!((of(&curve.elevate(1).unwrap(), low, high) - whole).abs() < 1e-10 * whole);
        let polygon = |points: &[Vector]| points.windows(2).map(|p| (p[1] - p[0]).norm()).sum::<f64>();
        let samples: Vec<Vector> = (0..=4000)
            .map(|k| curve.value(low + (high - low) * f64::from(k) / 4000.0)).collect();
        prop_assert!(polygon(&samples) <= whole * (1.0 + 1e-12) && polygon(&samples) >= whole * 0.98);
        prop_assert!(whole <= polygon(curve.control_points()) * (1.0 + 1e-12));
        if curve.basis().degree() == 1 {
            prop_assert!((whole - polygon(curve.control_points())).abs() < 1e-12);
        }
    }

    #[test]
    fn circles_are_round(radius in 1e-3f64..1e3, angle in 0.1f64..3.0, turn in 0.0f64..6.0) {
        // an arc as a rational quadratic: the middle weight is the cosine of half the angle
        let (half, at) = (0.5 * angle, |a: f64, r: f64| Vector::new(r * (turn + a).cos(), r * (turn + a).sin(), 0.0));
        let points = vec![at(0.0, radius), at(half, radius / half.cos()), at(angle, radius)];
        let basis = BSplineBasis::new(2, vec![0., 0., 0., 1., 1., 1.]).unwrap();
        let arc = BSplineCurve::new(basis, Dimension::Plane, points, Some(vec![1.0, half.cos(), 1.0])).unwrap();
        let length = arc_length(&arc, 0.0, 1.0, DEFAULT_TOLERANCE).unwrap();
        prop_assert!((length.length - radius * angle).abs() < 1e-12 * radius);
        for k in 0..=10 {
            let bending = bending(&arc, f64::from(k) / 10.0);
            prop_assert!((bending.curvature.unwrap() * radius - 1.0).abs() < 1e-10);
        }
        let shape = CurveShape::BSpline(arc);
        let answer = Closest::on(&shape).to(at(0.3 * angle, 0.6 * radius));
        prop_assert!((answer.signed_distance.unwrap() / radius - 0.4).abs() < 1e-14);
    }

    #[test]
    fn placed_knots_can_interpolate_and_fit((x, _) in nodes(3..40), degree in 1usize..8, share in 0.0f64..1.0) {
        prop_assume!(degree < x.len());
        for knots in [knots::averaging(degree, &x).unwrap(), knots::not_a_knot(degree, &x).unwrap()] {
            for i in 0..x.len() {
                prop_assert!(knots[i] <= x[i] && x[i] <= knots[i + degree + 1] && knots[i] < knots[i + degree + 1]);
            }
        }
        // every span of a least-squares basis holds a parameter
        let controls = degree + 1 + (share * (x.len() - degree - 1) as f64) as usize;
        let knots = knots::averaging_least_squares(degree, &x, controls).unwrap();
        prop_assert_eq!(knots.len(), controls + degree + 1);
        for pair in knots[degree..=controls].windows(2) {
            prop_assert!(x.iter().any(|x| pair[0] <= *x && *x <= pair[1]));
        }
    }

    #[test]
    fn errors_name_the_invalid_point((x, values) in nodes(4..9), place in 1usize..3) {
        for method in methods(x.len()) {
            let polynomial = matches!(method, Method::Lagrange | Method::Newton | Method::Hermite { .. });
            let of = |x: &[f64], values: &[Vector]| {
                shape_through(&graph(x, values), &method).unwrap_err().list()[0].path.clone()
            };
            let mut bad = x.clone();
            bad[place] = bad[place - 1];
            let fault = of(&bad, &values);
            prop_assert_eq!(fault, format!("points.x[{place}]"));
            bad[place] = f64::NAN;
            let fault = of(&bad, &values);
            prop_assert_eq!(fault, format!("points.x[{place}]"));
            let mut bad = x.clone();
            bad.reverse();
            if polynomial {
                // the order of the nodes does not matter, and stays
                let (curve, at) = shape_through(&graph(&bad, &values), &method).unwrap();
                prop_assert_eq!((curve.domain(), at), ([x[0], x[x.len() - 1]], bad));
            } else {
                let fault = of(&bad, &values);
                prop_assert_eq!(fault, "points.x[1]");
            }
            let mut bad = values.clone();
            bad[place].x = f64::INFINITY;
            let fault = of(&x, &bad);
            prop_assert_eq!(fault, format!("points.y[{place}]"));
            prop_assert_eq!(of(&x, &values[1..]), "points.y");
            let fault = shape_through(&space(bad.clone(), Parametrization::Uniform), &method).unwrap_err();
            prop_assert_eq!(&*fault.list()[0].path, format!("points.xyz[{place}]"));
            bad[place] = bad[place - 1];
            let fault = shape_through(&space(bad, Parametrization::Centripetal), &method).unwrap_err();
            prop_assert_eq!(&*fault.list()[0].path, format!("points.xyz[{place}]"));
        }
    }
}
