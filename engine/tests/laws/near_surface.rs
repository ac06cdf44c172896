//! Big scattered surfaces: banded is dense, to the digits; what they reproduce; undetermined
//! coefficients; penalties and their choice.

use flankfit_engine::estimation::near::{Shape, SurfaceFit, SurfaceInclude, SurfacePoints, shape_of, surface};
use flankfit_engine::estimation::spec::{
    Criterion, Degree, Domain, FitSpec, Include, Knots, Model, Parameter, Regularization, Scaling, Tikhonov,
};
use flankfit_engine::estimation::{FitError, Nodes, Trace, fit};
use flankfit_engine::geometry::surface::Surface;
use proptest::prelude::*;

use crate::oracle::random::Random;

const ALL: SurfaceInclude = SurfaceInclude { standard_errors: true, residuals: true };

fn model(degree: [usize; 2], spans: [usize; 2]) -> Model {
    Model::BSpline {
        degree: Degree::Each(degree[0], degree[1]),
        knots: Knots::SpansEach(spans[0], spans[1]),
        weights: None,
    }
}

fn spec(model: Model, regularization: Regularization) -> FitSpec {
    let include = Include { residuals: true, ..Include::default() };
    FitSpec { regularization, include, ..FitSpec::new(model) }
}

struct Data {
    u: Vec<f64>,
    v: Vec<f64>,
    z: Vec<f64>,
    weight: Option<Vec<f64>>,
}

fn data(seed: u64, m: usize, weighted: bool) -> Data {
    let mut random = Random::new(seed);
    let u: Vec<f64> = (0..m).map(|_| random.between(30.0, 34.0)).collect();
    let v: Vec<f64> = (0..m).map(|_| random.between(0.0, 20.0)).collect();
    let z =
        u.iter().zip(&v).map(|(u, v)| (1.5 * u).sin() + (0.3 * v).cos() * u * 0.1 + 0.05 * random.normal()).collect();
    let weight = weighted.then(|| (0..m).map(|k| if k % 17 == 3 { 0.0 } else { random.between(0.5, 2.0) }).collect());
    Data { u, v, z, weight }
}

fn banded(data: &Data, spec: &FitSpec) -> SurfaceFit {
    let coordinates = [data.z.clone()];
    let points = SurfacePoints { u: &data.u, v: &data.v, coordinates: &coordinates, weight: data.weight.as_deref() };
    surface(&points, spec, ALL).unwrap()
}

fn dense(data: &Data, spec: &FitSpec) -> flankfit_engine::estimation::FitResult {
    let nodes = Nodes::scattered(data.u.clone(), data.v.clone(), data.z.clone(), data.weight.clone()).unwrap();
    fit(&nodes, spec).unwrap()
}

fn controls(fit: &SurfaceFit) -> Vec<f64> {
    fit.surface.control_points().iter().map(|p| p.x).collect()
}

fn close(a: f64, b: f64, relative: f64) -> bool {
    (a - b).abs() <= relative * b.abs()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(10))]

    #[test]
    fn banded_is_dense(seed: u64, p in 1usize..4, q in 1usize..4, a in 1usize..6, b in 1usize..4, weighted: bool) {
        let data = data(seed, 1500, weighted);
        let spec = spec(model([p, q], [a, b]), Regularization::None);
        let (banded, dense) = (banded(&data, &spec), dense(&data, &spec));
        let size = dense.coefficients.iter().map(|c| c.value.abs()).fold(0.0, f64::max);
        for ((c, got), k) in dense.coefficients.iter().zip(controls(&banded)).zip(0..) {
            prop_assert!((got - c.value).abs() < 1e-13 * size, "{} {got} {}", c.term, c.value);
            let errors = banded.coordinates[0].standard_errors.as_ref().unwrap();
            prop_assert!(close(errors[k], c.error_given_lambda().unwrap(), 1e-9));
        }
        let one = &banded.coordinates[0];
        prop_assert!(close(one.rss, dense.residuals.rss, 1e-12));
        prop_assert!(close(one.rms, dense.residuals.rms, 1e-12));
        prop_assert!(close(one.max_abs, dense.residuals.max_abs.unwrap(), 1e-11));
        prop_assert!(close(one.sigma.unwrap(), dense.residuals.sigma.unwrap(), 1e-12));
        prop_assert!(close(banded.condition.unwrap(), dense.spectrum.condition.unwrap(), 1e-6));
        prop_assert_eq!(banded.count, dense.residuals.count);
        prop_assert_eq!(banded.nodes_per_span.iter().sum::<usize>(), banded.count);
        let (mine, theirs) = (one.residuals.as_ref().unwrap(), dense.residuals.values.as_ref().unwrap());
        prop_assert!(mine.iter().zip(theirs).all(|(a, b)| (a - b).abs() < 1e-12));
        // and the surface is the one of the service's fit
        let Some(Shape::Surface(shape)) = shape_of(&spec, &dense) else { panic!("a surface") };
        for k in 0..20 {
            let (u, v) = (data.u[k], data.v[k]);
            prop_assert!((shape.value(u, v).x - banded.surface.value(u, v).x).abs() < 1e-12);
        }
    }

    #[test]
    fn penalised_banded_is_dense(seed: u64, order in 0usize..4, power in -6i32..2, ridge: bool) {
        let data = data(seed, 900, false);
        let parameter = Parameter::Fixed(10f64.powi(power));
        let regularization = if ridge {
            Regularization::Ridge { parameter }
        } else {
            Regularization::Tikhonov(Tikhonov { order, weights: Some(vec![0.7, 1.3]), parameter })
        };
        let spec = spec(model([3, 3], [4, 3]), regularization);
        let (banded, dense) = (banded(&data, &spec), dense(&data, &spec));
        for ((c, got), k) in dense.coefficients.iter().zip(controls(&banded)).zip(0..) {
            prop_assert!((got - c.value).abs() < 1e-11, "{} {got} {}", c.term, c.value);
            // σ̂ of the service is that of least squares
            let error = banded.coordinates[0].standard_errors.as_ref().unwrap()[k]
                / banded.coordinates[0].sigma.unwrap();
            prop_assert!(close(error, c.error_given_lambda().unwrap() / dense.residuals.sigma.unwrap(), 1e-7));
        }
        let factors: f64 = dense.regularization.filter_factors.iter().sum();
        prop_assert!((banded.effective_degrees_of_freedom - factors).abs() < 1e-7, "{factors}");
        prop_assert!(close(banded.coordinates[0].rss, dense.residuals.rss, 1e-10));
    }

    /// A polynomial within the degree is found without a residual, over several coordinates at
    /// once.
    #[test]
    fn polynomials_are_reproduced(seed: u64, spans in 2usize..12) {
        let Data { u, v, .. } = data(seed, 4000, false);
        let along = |u: f64, v: f64| [u * v - 3.0, u * u + 0.1 * v, 2.0 * u - v * v * v * 0.01];
        let coordinates: Vec<Vec<f64>> = (0..3).map(|c| u.iter().zip(&v).map(|(u, v)| along(*u,
            *v)[c]).collect()).collect();
        let points = SurfacePoints { u: &u, v: &v, coordinates: &coordinates, weight: None };
        let found = surface(&points, &spec(model([3, 3], [spans, 4]), Regularization::None), ALL).unwrap();
        for c in &found.coordinates {
            prop_assert!(c.max_abs < 1e-10, "{}", c.max_abs);
        }
        for k in 0..50 {
            let (at, truth) = (found.surface.value(u[k], v[k]), along(u[k], v[k]));
            prop_assert!((0..3).all(|c| (at[c] - truth[c]).abs() < 1e-10));
        }
    }
}

/// Wherever they lie: outside the others they would stretch the knots, or be refused outside given
/// ones.
#[test]
fn nodes_of_weight_0_say_nothing() {
    let counted = data(11, 1500, false);
    let mut more = data(11, 1500, false);
    more.weight = Some(vec![1.0; 1500]);
    for (u, v, z) in [(29.0, 3.0, 1e6), (36.0, 21.0, -4.0), (31.0, 5.0, 7.0)] {
        more.u.push(u);
        more.v.push(v);
        more.z.push(z);
        more.weight.as_mut().unwrap().push(0.0);
    }
    let asked = spec(model([1, 3], [4, 3]), Regularization::None);
    let (plain, silent) = (banded(&counted, &asked), banded(&more, &asked));
    assert_eq!(controls(&plain), controls(&silent));
    assert_eq!(plain.coordinates[0].residuals, silent.coordinates[0].residuals);
    let given = FitSpec { domain: Some(Domain { u: Some([30.0, 34.0]), v: Some([0.0, 20.0]) }), ..asked };
    assert_eq!(controls(&banded(&counted, &given)), controls(&banded(&more, &given)));
}

#[test]
fn criteria_choose_as_in_the_dense_fit() {
    let data = data(7, 1200, false);
    for criterion in [Criterion::Gcv, Criterion::Discrepancy, Criterion::LCurve] {
        let parameter = Parameter::Criterion(criterion);
        let regularization = Regularization::Tikhonov(Tikhonov { order: 2, weights: None, parameter });
        let spec = FitSpec { noise_sigma: Some(0.055), ..spec(model([3, 3], [6, 6]), regularization) };
        let (banded, dense) = (banded(&data, &spec), dense(&data, &spec));
        let (mine, theirs) = (banded.regularization.unwrap(), dense.regularization.lambda_star.unwrap());
        assert_eq!(mine.trace, Trace::Exact);
        assert!((mine.lambda / theirs).ln().abs() < 1e-3, "{criterion:?} {} {theirs}", mine.lambda);
    }
}

/// Nodes on a ring only: the nodes do not determine the corners and the middle, and a penalty fills
/// them in.
#[test]
fn starved_cells_are_named_or_smoothed() {
    let mut random = Random::new(4);
    let (mut u, mut v) = (Vec::new(), Vec::new());
    while u.len() < 3000 {
        let (a, b) = (random.between(-1.0, 1.0), random.between(-1.0, 1.0));
        if (0.5..1.0).contains(&f64::hypot(a, b)) {
            u.push(a);
            v.push(b);
        }
    }
    // the limits of the domain are reached
    u.extend([-1.0, 1.0, 0.0, 0.0]);
    v.extend([0.0, 0.0, -1.0, 1.0]);
    let z: Vec<f64> = u.iter().zip(&v).map(|(u, v)| 2.0 * u - 3.0 * v + 1.0).collect();
    let coordinates = [z];
    let points = SurfacePoints { u: &u, v: &v, coordinates: &coordinates, weight: None };
    let plain = spec(model([3, 3], [12, 12]), Regularization::None);
    let Err(FitError::Invalid(faults)) = surface(&points, &plain, ALL) else { panic!("undetermined") };
    assert!(faults.list().iter().all(|fault| {
        let open = fault.message.ends_with("use `tikhonov`");
        fault.path == "model" && open
    }));
    assert!(faults.list()[0].message.contains("B0(u)*B0(v)"), "{}", faults.list()[0].message);
    let parameter = Parameter::Fixed(1e-6);
    let smooth = Regularization::Tikhonov(Tikhonov { order: 2, weights: None, parameter });
    let found = surface(&points, &spec(model([3, 3], [12, 12]), smooth), ALL).unwrap();
    assert!(found.empty_spans > 20 && found.warnings.iter().any(|w| w.code() == "empty_spans"));
    // a plane has no roughness
    for (u, v) in [(-0.99, -0.99), (0.0, 0.0), (0.97, -0.9)] {
        assert!(
            (found.surface.value(u, v).x - (2.0 * u - 3.0 * v + 1.0)).abs() < 1e-8,
            "{}",
            found.surface.value(u, v).x
        );
    }
    let automatic =
        Regularization::Tikhonov(Tikhonov { order: 2, weights: None, parameter: Parameter::Criterion(Criterion::Gcv) });
    assert!(surface(&points, &spec(model([3, 3], [12, 12]), automatic), ALL).is_ok());
}

/// Nodes that crowd in a corner of every cell leave columns nearly parallel: doubles do not
/// suffice, double-double does.
#[test]
fn delicate_nodes_are_factored_in_double_double() {
    let mut random = Random::new(9);
    let (mut u, mut v) = (Vec::new(), Vec::new());
    for i in 0..4 {
        for j in 0..4 {
            for _ in 0..60 {
                u.push(f64::from(i) + 0.0003 * random.unit());
                v.push(f64::from(j) + 0.0003 * random.unit());
            }
        }
    }
    let z: Vec<f64> = u.iter().zip(&v).map(|(u, v)| 1.0 + u * v * v - u * u).collect();
    let coordinates = [z];
    let points = SurfacePoints { u: &u, v: &v, coordinates: &coordinates, weight: None };
    let given = FitSpec {
        domain: Some(flankfit_engine::estimation::spec::Domain { u: Some([0.0, 4.0]), v: Some([0.0, 4.0]) }),
        ..spec(model([3, 3], [4, 4]), Regularization::None)
    };
    let found = surface(&points, &given, ALL).unwrap();
    assert_eq!(found.arithmetic, flankfit_engine::estimation::result::Arithmetic::DoubleDouble);
    assert!(found.condition.unwrap() > 1e12);
    assert!(found.coordinates[0].max_abs < 1e-12);
}

#[test]
fn options_unsupported_for_large_surfaces_are_refused() {
    let data = data(1, 50, false);
    let coordinates = [data.z.clone()];
    let points = SurfacePoints { u: &data.u, v: &data.v, coordinates: &coordinates, weight: None };
    let field = |spec: &FitSpec| match surface(&points, spec, ALL) {
        Err(FitError::Invalid(faults)) => faults.list()[0].path.clone(),
        other => panic!("{other:?}"),
    };
    let plain = spec(model([3, 3], [2, 2]), Regularization::None);
    assert_eq!(field(&FitSpec { regularization: Regularization::default(), ..plain.clone() }), "regularization.type");
    assert_eq!(field(&FitSpec { scaling: Scaling::Standardized, ..plain.clone() }), "scaling");
    assert_eq!(field(&spec(model([3, 3], [8, 8]), Regularization::None)), "model");
    assert_eq!(field(&spec(model([12, 3], [2, 2]), Regularization::None)), "model.degree");
    assert_eq!(field(&spec(Model::Linear, Regularization::None)), "model.type");
    let gcv = Regularization::Ridge { parameter: Parameter::Criterion(Criterion::Discrepancy) };
    assert_eq!(field(&FitSpec { regularization: gcv, ..plain }), "noise_sigma");
}
