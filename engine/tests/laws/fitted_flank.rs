//! Laws of the figures of a surface that was fitted for itself.

use flankfit_engine::{
    estimation::{
        FitResult, FitSpec, Nodes,
        spec::{
            Degree, Domain, Include, Kinds, Model, Places, PolynomialBasis, Predict, Prior, PriorSpread,
            Regularization, Terms,
        },
    },
    gear::{
        Gear, GearData, ProfileAxis, Side,
        evaluation::{
            ToleranceLimits,
            flank_surface::{
                Figure, FigureTerms, FittedFlank, FlankFigures, FlankNodes, NoRollLengths, Reference, flank_surface,
                over_roll_lengths,
            },
            settings::SlopeSign,
        },
    },
};

use super::{
    gear_evaluation::{data, gear},
    gear_evaluation_surface::settings_of,
};
use crate::oracle::random::Random;
use crate::problems::fit;

const ROLL: [f64; 2] = [18.0, 26.0];
const Z: [f64; 2] = [1.0, 19.0];

fn flank(gear: &Gear, side: Side) -> FittedFlank<'_> {
    let terms = FigureTerms { reference: Reference::Evaluated, ..FigureTerms::default() };
    FittedFlank { gear, side, u: 1.0, v: 1.0, height: 1.0, terms, roll_lengths: ROLL, z: Z }
}

fn polynomial(degree: Degree, basis: PolynomialBasis, terms: Terms) -> Model {
    Model::Polynomial { degree, basis, terms }
}

fn plain(model: Model) -> FitSpec {
    FitSpec { regularization: Regularization::None, ..FitSpec::new(model) }
}

fn axis([low, high]: [f64; 2], count: usize) -> Vec<f64> {
    (0..count).map(|k| low + (high - low) * k as f64 / (count - 1) as f64).collect()
}

fn mapped([low, high]: [f64; 2], x: f64) -> f64 {
    (2.0 * x - low - high) / (high - low)
}

/// Heights on a grid, as a function of u and v in [-1, 1].
fn grid(height: &mut dyn FnMut(f64, f64) -> f64) -> [Vec<f64>; 3] {
    let (u, v) = (axis(ROLL, 12), axis(Z, 9));
    let z = u.iter().flat_map(|u| v.iter().map(|v| (*u, *v)).collect::<Vec<_>>());
    let z = z.map(|(u, v)| height(mapped(ROLL, u), mapped(Z, v))).collect();
    [u, v, z]
}

fn asked(flank: &FittedFlank, spec: &FitSpec, nodes: &Nodes) -> (FitResult, [Figure; 5]) {
    let result = fit(nodes, &FitSpec { sums: Some(flank.sums()), ..spec.clone() });
    let found = flank.figures(result.sums.as_deref().unwrap(), FlankFigures::default(), result.doubts());
    let all = [found.profile_slope, found.helix_slope, found.profile_crowning, found.helix_crowning, found.twist];
    (result, all.map(Option::unwrap))
}

fn near(value: f64, want: f64, within: f64) {
    assert!((value - want).abs() <= within, "{value} is not {want}");
}

/// Figures of a surface of second order are those of the flank surface, with all their members.
#[test]
fn of_second_order_they_are_those_of_the_flank_surface() {
    let internal = Gear::new(GearData { teeth: 70, internal: true, ..data() }).unwrap();
    let mut random = Random::new(7);
    for gear in [gear(), internal] {
        let mut height =
            |u: f64, v: f64| 3.0 + 2.0 * u - 1.5 * v - 0.8 * u * u + 0.4 * u * v - 1.1 * v * v + 0.3 * random.normal();
        let [u, v, z] = grid(&mut height);
        let nodes = Nodes::grid(u.clone(), v.clone(), z.clone(), None, None).unwrap();
        let of_surface =
            FlankNodes { axis: ProfileAxis::RollLength, profile: &u, z: &v, deviation: &z, valid: None, grid: true };
        for side in [Side::Left, Side::Right] {
            for basis in [PolynomialBasis::Monomial, PolynomialBasis::Chebyshev, PolynomialBasis::Legendre] {
                let spec = plain(polynomial(Degree::Both(2), basis, Terms::Total));
                let settings = settings_of(spec.clone(), ToleranceLimits::default());
                let settings = flankfit_engine::gear::evaluation::flank_surface::SurfaceSettings {
                    side,
                    sign: SlopeSign::Din,
                    ..settings
                };
                let surface = flank_surface(&gear, &of_surface, &settings).unwrap();
                let want = [
                    surface.profile_slope,
                    surface.helix_slope,
                    surface.profile_crowning,
                    surface.helix_crowning,
                    surface.twist,
                ];
                let (_, found) = asked(&flank(&gear, side), &spec, &nodes);
                for (found, want) in found.into_iter().zip(want) {
                    near(found.value, want.value, 1e-9);
                    near(found.std_error.unwrap(), want.std_error.unwrap(), 1e-9);
                    near(found.least_squares, want.least_squares, 1e-9);
                    near(found.bias_bound, 0.0, 1e-12);
                    let [found, want] = [found, want].map(|one| one.inference.unwrap());
                    assert_eq!(found.kind, want.kind);
                    (0..2).for_each(|k| near(found.interval[k], want.interval[k], 1e-9));
                }
            }
        }
    }
}

/// The same sums of predicted heights, whatever is estimated and regularised how.
#[test]
fn they_are_sums_of_the_fitted_heights() {
    let gear = gear();
    let mut random = Random::new(11);
    let [u, v, z] = grid(&mut |u, v| 2.0 * u - v * v + 0.7 * u * u * v + 0.2 * random.normal());
    let nodes = Nodes::grid(u, v, z, None, None).unwrap();
    let flank = flank(&gear, Side::Left);
    let sums = flank.sums();
    let at = Places::Points {
        u: sums.places.iter().map(|place| place[0]).collect(),
        v: sums.places.iter().map(|place| place[1]).collect(),
    };
    let kinds = Kinds { confidence: true, prediction: false, simultaneous: false };
    let predict = Predict { at, level: None, kinds, slopes: false };
    let models = [
        polynomial(Degree::Each(4, 3), PolynomialBasis::Chebyshev, Terms::Tensor),
        polynomial(Degree::Both(3), PolynomialBasis::Monomial, Terms::Total),
    ];
    for model in models {
        for spec in [plain(model.clone()), FitSpec::new(model.clone())] {
            let spec = FitSpec { predict: Some(predict.clone()), ..spec };
            let (result, _) = asked(&flank, &spec, &nodes);
            let heights = &result.predictions.as_ref().unwrap().value;
            for (found, weights) in result.sums.as_ref().unwrap().iter().zip(&sums.weights) {
                let want: f64 = heights.iter().zip(weights).map(|(height, weight)| height * weight).sum();
                near(found.unwrap().value, want, 1e-9);
            }
        }
    }
}

/// The surface of second order that is nearest, found by least squares on a dense grid.
#[test]
fn of_higher_orders_they_are_those_of_the_nearest_surface_of_second_order() {
    let gear = gear();
    let shape = |u: f64, v: f64| {
        2.0 * u + 1.5 * u * u * u - v + 0.9 * u * v + 0.5 * u * v * v - u * u * v * v + 0.3 * v * v * v
    };
    let [u, v, z] = grid(&mut |u, v| shape(u, v));
    let nodes = Nodes::grid(u, v, z, None, None).unwrap();
    let spec = plain(polynomial(Degree::Each(3, 3), PolynomialBasis::Legendre, Terms::Tensor));
    let (_, found) = asked(&flank(&gear, Side::Left), &spec, &nodes);
    // midpoints of 200 × 200 squares
    let places: Vec<f64> = (0..200).map(|k| (2 * k + 1) as f64 / 200.0 - 1.0).collect();
    let heights = places.iter().flat_map(|u| places.iter().map(|v| shape(*u, *v)).collect::<Vec<_>>()).collect();
    let dense = Nodes::grid(places.clone(), places, heights, None, None).unwrap();
    let nearest = fit(&dense, &plain(polynomial(Degree::Both(2), PolynomialBasis::Monomial, Terms::Total)));
    let term = |name: [usize; 2]| {
        let key = flankfit_engine::estimation::result::TermKey::Powers(name.to_vec());
        nearest.coefficients.iter().find(|c| c.key == key).unwrap().value
    };
    let want = [2.0 * term([1, 0]), 2.0 * term([0, 1]), -term([2, 0]), -term([0, 2]), 4.0 * term([1, 1])];
    for (found, want) in found.into_iter().zip(want) {
        near(found.value, want, 2e-4);
    }
}

/// Standard errors by the covariance of the coefficients, which are those of raw powers.
#[test]
fn standard_errors_follow_from_the_covariance() {
    let gear = gear();
    let mut random = Random::new(5);
    let [u, v, z] = grid(&mut |u, v| u - 2.0 * v + 0.4 * random.normal());
    let nodes = Nodes::grid(u, v, z, None, None).unwrap();
    let flank = flank(&gear, Side::Left);
    let include = Include { covariance: true, ..Include::default() };
    let model = polynomial(Degree::Each(3, 2), PolynomialBasis::Chebyshev, Terms::Tensor);
    let (result, _) = asked(&flank, &FitSpec { include, ..plain(model) }, &nodes);
    let covariance = &result.covariance.as_ref().unwrap().coefficients;
    // Chebyshev polynomials on the mapped domain, row by row
    let chebyshev = |n: usize, x: f64| (n as f64 * x.clamp(-1.0, 1.0).acos()).cos();
    let sums = flank.sums();
    let orders: Vec<(usize, usize)> = result
        .coefficients
        .iter()
        .map(|c| match &c.key {
            flankfit_engine::estimation::result::TermKey::Powers(powers) => (powers[0], powers[1]),
            key => panic!("{key:?}"),
        })
        .collect();
    for (sum, weights) in result.sums.as_ref().unwrap().iter().zip(&sums.weights) {
        let row: Vec<f64> = orders
            .iter()
            .map(|&(i, j)| {
                let terms = sums.places.iter().zip(weights);
                terms.map(|(at, w)| w * chebyshev(i, mapped(ROLL, at[0])) * chebyshev(j, mapped(Z, at[1]))).sum()
            })
            .collect();
        let entry = |a: usize, b: usize| covariance[a.max(b)][a.min(b)];
        let n = row.len();
        let variance: f64 = (0..n * n).map(|k| row[k / n] * row[k % n] * entry(k / n, k % n)).sum();
        let sum = sum.unwrap();
        near(sum.conditional_std_error.or(sum.std_error).unwrap(), variance.sqrt(), 1e-9);
    }
}

/// 600 draws: three standard errors of a coverage of 0.95 are 0.027.
#[test]
fn intervals_hold_the_figures_of_the_truth() {
    let gear = gear();
    let flank = flank(&gear, Side::Right);
    let mut random = Random::new(2026);
    // slopes, crownings, twist of the truth over the range
    let truth = [4.0 + 2.0 * 0.6 * 1.5, -(-3.0), 0.8, 1.1, -(4.0 * 0.4)];
    let spec = plain(polynomial(Degree::Each(3, 2), PolynomialBasis::Legendre, Terms::Tensor));
    let mut held = [0_u32; 5];
    for _ in 0..600 {
        let mut height = |u: f64, v: f64| {
            let surface = 3.0 + 2.0 * u - 1.5 * v - 0.8 * u * u + 0.4 * u * v - 1.1 * v * v + 1.5 * u * u * u;
            surface + 0.5 * random.normal()
        };
        let [u, v, z] = grid(&mut height);
        let (_, found) = asked(&flank, &spec, &Nodes::grid(u, v, z, None, None).unwrap());
        for ((held, figure), truth) in held.iter_mut().zip(found).zip(truth) {
            let [low, high] = figure.inference.unwrap().interval;
            *held += u32::from(low <= truth && truth <= high);
        }
    }
    for held in held {
        let covered = f64::from(held) / 600.0;
        assert!((0.92..=0.98).contains(&covered), "{covered}");
    }
}

/// The same flank in mm of space, over roll angles in degrees and z in µm.
#[test]
fn units_and_signs_are_as_specified() {
    let gear = gear();
    let shape = |u: f64, v: f64| 3.0 + 2.0 * u - 1.5 * v - 0.8 * u * u + 0.4 * u * v - 1.1 * v * v;
    let [u, v, z] = grid(&mut |u, v| shape(u, v));
    let spec = plain(polynomial(Degree::Both(2), PolynomialBasis::Chebyshev, Terms::Total));
    let nodes = Nodes::grid(u.clone(), v.clone(), z.clone(), None, None).unwrap();
    let (_, want) = asked(&flank(&gear, Side::Left), &spec, &nodes);
    let degree = std::f64::consts::PI / 180.0;
    let angles: Vec<f64> = u.iter().map(|roll| roll / gear.base_radius() / degree).collect();
    let heights: Vec<f64> = z.iter().map(|z| -1e-3 * z).collect();
    let u = degree * gear.base_radius();
    let other = FittedFlank { u, v: 1e-3, height: -1e3, ..flank(&gear, Side::Left) };
    let nodes = Nodes::grid(angles, v.iter().map(|z| 1e3 * z).collect(), heights, None, None).unwrap();
    let (_, found) = asked(&other, &spec, &nodes);
    for (found, want) in found.into_iter().zip(want) {
        near(found.value, want.value, 1e-9);
    }
}

/// A flank over diameters is fitted over its roll lengths. The hand-computed surface has f_Hα 4 µm
/// and C_α 3 µm; of second order over diameters f_Hα would be 0.2 µm off.
#[test]
fn figures_over_diameters_are_those_over_roll_lengths() {
    let gear = gear();
    let [u, v, z] = grid(&mut |u, v| 2.0 * u - 3.0 * u * u + v);
    let diameters: Vec<f64> = u.iter().map(|roll| gear.diameter(*roll)).collect();
    let domain = Domain { u: Some([diameters[0], diameters[11]]), v: None };
    let spec =
        FitSpec { domain: Some(domain), ..plain(polynomial(Degree::Both(2), PolynomialBasis::Legendre, Terms::Total)) };
    let nodes = Nodes::grid(diameters.iter().map(|d| d / 25.4).collect(), v, z, None, None).unwrap();
    let inches = FitSpec {
        domain: Some(Domain { u: domain.u.map(|ends| ends.map(|end| end / 25.4)), v: None }),
        ..spec.clone()
    };
    let (over, converted) = over_roll_lengths(&gear, 25.4, &nodes, &inches).unwrap();
    let (_, found) = asked(&flank(&gear, Side::Left), &converted, &over);
    near(found[0].value, 4.0, 1e-9);
    near(found[2].value, 3.0, 1e-9);
    let Nodes::Grid(over) = over else { panic!() };
    assert!(over.u().iter().zip(&u).all(|(found, roll)| (found - roll).abs() < 1e-9));
    assert!((converted.domain.unwrap().u.unwrap()[1] - ROLL[1]).abs() < 1e-9);

    // the same heights over diameters alone: another slope
    let mapped_wrongly = Nodes::scattered(
        diameters.iter().flat_map(|d| [*d; 9]).collect(),
        diameters.iter().flat_map(|_| axis(Z, 9)).collect(),
        u.iter()
            .flat_map(|roll| axis(Z, 9).into_iter().map(move |z| shape(mapped(ROLL, *roll), mapped(Z, z))))
            .collect(),
        None,
    );
    let wrong = FittedFlank { roll_lengths: domain.u.unwrap(), ..flank(&gear, Side::Left) };
    let (_, wrong) = asked(&wrong, &spec, &mapped_wrongly.unwrap());
    assert!((wrong[0].value - 4.0).abs() > 0.1, "{}", wrong[0].value);

    // below the base circle there is no involute, and coefficients over diameters are of no use
    let below = Nodes::scattered(vec![0.9 * gear.base_radius()], vec![1.0], vec![0.0], None).unwrap();
    assert_eq!(over_roll_lengths(&gear, 2.0, &below, &spec), Err(NoRollLengths::NoInvolute));
    let prior = Prior::Given { mean: vec![0.0; 6], spread: PriorSpread::StdError(vec![1.0; 6]) };
    let known = FitSpec { prior: Some(prior), ..spec };
    assert_eq!(over_roll_lengths(&gear, 25.4, &nodes, &known), Err(NoRollLengths::Coefficients));
}

/// 2 u − 3 u² + v.
fn shape(u: f64, v: f64) -> f64 {
    2.0 * u - 3.0 * u * u + v
}
