//! Proved intervals contain the exact results of the posted doubles, in rational arithmetic, and
//! are short.

use crate::oracle::random::Random;
use crate::oracle::rational::{Dyadic, Exact, least_squares};
use crate::problems::{Problem, fit, linear, matrix, warned};
use flankfit_engine::estimation::{
    FitResult, Nodes,
    result::{Enclosure, NotEnclosed, Warning},
    spec::{
        Along, Correlation, Degree, Domain, Errors, Estimator, FitSpec, Include, Knots, Model, NodeUncertainty,
        PolynomialBasis, PositionKind, Regularization, Terms, Variance,
    },
};

fn enclosed(spec: FitSpec) -> FitSpec {
    FitSpec { include: Include { enclosure: true, ..Include::default() }, ..spec }
}

fn of(result: &FitResult) -> &Enclosure {
    result.numerics.enclosure.as_ref().unwrap_or_else(|| panic!("{:?}", result.warnings))
}

/// A posted problem and its columns, exactly: column j holds `factors[j]` times function j.
struct Posted {
    nodes: Nodes,
    spec: FitSpec,
    rows: Vec<Vec<Dyadic>>,
    factors: Vec<Dyadic>,
    heights: Vec<f64>,
    weights: Option<Vec<f64>>,
}

/// Values of functions 0 to `degree` at x times their factors, and the factors.
fn functions(basis: PolynomialBasis, [low, high]: [f64; 2], degree: usize, x: f64) -> Vec<(Dyadic, Dyadic)> {
    let (x, low, high) = (Dyadic::from(x), Dyadic::from(low), Dyadic::from(high));
    // τ = over/under
    let (over, under) = match basis {
        PolynomialBasis::Monomial => (x, Dyadic::integer(1)),
        _ => (&(&x + &x) - &(&low + &high), &high - &low),
    };
    let square = under.power(2);
    let mut out = vec![(Dyadic::integer(1), Dyadic::integer(1))];
    for j in 0..degree {
        let k = j as i64;
        let (value, factor) = &out[j];
        let before = || if j > 0 { out[j - 1].0.clone() } else { Dyadic::integer(0) };
        let next = match basis {
            _ if j == 0 => over.clone(),
            PolynomialBasis::Monomial => value * &over,
            PolynomialBasis::Chebyshev => &(&Dyadic::integer(2) * &(&over * value)) - &(&square * &before()),
            // j! under^j P_j
            PolynomialBasis::Legendre => {
                &(&Dyadic::integer(2 * k + 1) * &(&over * value)) - &(&Dyadic::integer(k * k) * &(&square * &before()))
            }
        };
        let grown = match basis {
            PolynomialBasis::Legendre => &Dyadic::integer(k + 1) * &under,
            _ => under.clone(),
        };
        out.push((next, factor * &grown));
    }
    out
}

impl Posted {
    fn matrix(x: &[Vec<f64>], heights: Vec<f64>, weights: Option<Vec<f64>>) -> Self {
        Posted {
            nodes: matrix(x, &heights, weights.clone()),
            spec: linear(),
            rows: x.iter().map(|row| row.iter().map(|&x| Dyadic::from(x)).collect()).collect(),
            factors: vec![Dyadic::integer(1); x[0].len()],
            heights,
            weights,
        }
    }

    /// `places` of the nodes that count, in order; v is 0 for curves.
    fn polynomial(
        nodes: Nodes,
        spec: FitSpec,
        places: &[[f64; 2]],
        heights: Vec<f64>,
        weights: Option<Vec<f64>>,
    ) -> Self {
        let Model::Polynomial { degree, basis, terms } = &spec.model else { panic!("a polynomial") };
        let curve = matches!(nodes, Nodes::Curve(_));
        let (p, q) = match *degree {
            Degree::Both(p) => (p, if curve { 0 } else { p }),
            Degree::Each(p, q) => (p, q),
        };
        let bounds = |k: usize| {
            let on = || places.iter().map(|place| place[k]);
            [on().fold(f64::INFINITY, f64::min), on().fold(f64::NEG_INFINITY, f64::max)]
        };
        let given = spec.domain.unwrap_or_default();
        let (on_u, on_v) = (given.u.unwrap_or(bounds(0)), given.v.unwrap_or(bounds(1)));
        let keep = |i: usize, j: usize| *terms != Terms::Total || i + j <= p;
        let row = |[u, v]: [f64; 2]| {
            let (in_u, in_v) = (functions(*basis, on_u, p, u), functions(*basis, on_v, q, v));
            let mut row = Vec::new();
            for (i, f) in in_u.iter().enumerate() {
                row.extend(
                    in_v.iter().enumerate().filter(|(j, _)| keep(i, *j)).map(|(_, g)| (&f.0 * &g.0, &f.1 * &g.1)),
                );
            }
            row
        };
        let rows: Vec<Vec<(Dyadic, Dyadic)>> = places.iter().map(|&place| row(place)).collect();
        let factors = rows[0].iter().map(|(_, factor)| factor.clone()).collect();
        let rows = rows.into_iter().map(|row| row.into_iter().map(|(value, _)| value).collect()).collect();
        Posted { nodes, spec, rows, factors, heights, weights }
    }

    /// Compares with the exact results; the greatest relative radius of a coefficient.
    fn check(&self, name: &str) -> (FitResult, f64) {
        let result = fit(&self.nodes, &enclosed(self.spec.clone()));
        let found = of(&result);
        let Exact { coefficients, inverse, rss } = least_squares(&self.rows, &self.heights, self.weights.as_deref());
        assert!(rss.within(found.rss), "{name}: rss {:?}", found.rss);
        let freedom = self.rows.len() - coefficients.len();
        let mut widest: f64 = 0.0;
        for (j, (exact, ends)) in coefficients.iter().zip(&found.coefficients).enumerate() {
            assert!(exact.times(&self.factors[j]).within(*ends), "{name}: coefficient {j} {ends:?}");
            widest = widest.max(radius(*ends));
            let value = result.coefficients[j].least_squares;
            let apart = (value - ends[0]).abs().max((value - ends[1]).abs());
            assert!(apart <= 1e-9 * value.abs() + 2.0 * (ends[1] - ends[0]) || result.numerics.correct_digits < 9.0);
            let Some(std_errors) = &found.std_errors else { continue };
            let square = inverse[j].times(&self.factors[j].power(2)).times_ratio(&rss).by(freedom);
            assert!(square.root_within(std_errors[j]), "{name}: standard error {j} {:?}", std_errors[j]);
        }
        (result, widest)
    }
}

/// Half the width over the greatest modulus.
fn radius([low, high]: [f64; 2]) -> f64 {
    0.5 * (high - low) / low.abs().max(high.abs()).max(f64::MIN_POSITIVE)
}

fn noisy(random: &mut Random, noise: f64, of: impl Fn(f64, f64) -> f64, places: &[[f64; 2]]) -> Vec<f64> {
    places.iter().map(|&[u, v]| of(u, v) + noise * random.normal()).collect()
}

fn weights(random: &mut Random, count: usize) -> Option<Vec<f64>> {
    (random.unit() < 0.5).then(|| (0..count).map(|_| 10f64.powf(random.between(-3.0, 1.0))).collect())
}

/// A random problem whose columns have a condition up to 1e12.
fn random_problem(seed: u64) -> Posted {
    let mut random = Random::new(seed ^ 0x00e4_c105_0e00);
    let noise = 10f64.powf(random.between(-9.0, 0.0));
    if seed.is_multiple_of(3) {
        let (n, extra) = (2 + random.below(5), random.below(12));
        let Problem { x, y } = Problem::graded(seed, n, extra, random.between(0.0, 24.0));
        let weights = weights(&mut random, y.len());
        return Posted::matrix(&x, y, weights);
    }
    let basis = [PolynomialBasis::Monomial, PolynomialBasis::Chebyshev, PolynomialBasis::Legendre][random.below(3)];
    // raw powers far from 0: the condition is about (4 × ratio)^degree
    let degree = 1 + random.below(5);
    let ratio = 10f64.powf(random.between(-1.0, 12.0 / degree as f64 - 0.6));
    let half = 10f64.powf(random.between(-2.0, 2.0));
    let middle = ratio.min(1e5) * half;
    let far = |x: f64| (x - middle) / half;
    if seed % 3 == 1 {
        let m = degree + 1 + random.below(15);
        let places: Vec<[f64; 2]> = (0..m).map(|_| [middle + half * random.between(-1.0, 1.0), 0.0]).collect();
        let heights = noisy(&mut random, noise, |u, _| (2.0 * far(u)).sin(), &places);
        let weights = weights(&mut random, m);
        let x = places.iter().map(|place| place[0]).collect();
        let nodes = Nodes::curve(x, heights.clone(), weights.clone()).expect("checked nodes");
        let model = Model::Polynomial { degree: Degree::Both(degree), basis, terms: Terms::Tensor };
        let domain = (random.unit() < 0.3).then_some(Domain { u: Some([middle - 2.0 * half, middle + half]), v: None });
        return Posted::polynomial(nodes, FitSpec { domain, ..FitSpec::new(model) }, &places, heights, weights);
    }
    let degree = 1 + degree % 2;
    let terms = if random.unit() < 0.3 { Terms::Total } else { Terms::Tensor };
    let model = Model::Polynomial { degree: Degree::Both(degree), basis, terms };
    let (nu, nv) = (degree + 1 + random.below(3), degree + 1 + random.below(4));
    let axis = |random: &mut Random, count: usize, [low, high]: [f64; 2]| -> Vec<f64> {
        (0..count).map(|i| low + (high - low) * (i as f64 + 0.4 * random.unit()) / count as f64).collect()
    };
    let (u, v) = (axis(&mut random, nu, [middle - half, middle + half]), axis(&mut random, nv, [0.5, 14.5]));
    let all: Vec<[f64; 2]> = u.iter().flat_map(|&u| v.iter().map(move |&v| [u, v])).collect();
    let heights = noisy(&mut random, noise, |u, v| 4.0 - far(u).powi(2) + 0.1 * v * far(u), &all);
    let weights = weights(&mut random, all.len());
    let spec = FitSpec::new(model);
    if nu > degree + 1 && nv > degree + 1 && weights.is_none() {
        // a hole
        let hole = random.below(all.len());
        let mut z = heights.clone();
        z[hole] = f64::NAN;
        let counted = |k: &usize| *k != hole;
        let places: Vec<[f64; 2]> = (0..all.len()).filter(counted).map(|k| all[k]).collect();
        let left = (0..all.len()).filter(counted).map(|k| heights[k]).collect();
        let nodes = Nodes::grid(u, v, z, None, None).expect("checked nodes");
        return Posted::polynomial(nodes, spec, &places, left, None);
    }
    if random.unit() < 0.7 {
        let nodes = Nodes::grid(u, v, heights.clone(), None, weights.clone()).expect("checked nodes");
        return Posted::polynomial(nodes, spec, &all, heights, weights);
    }
    let (in_u, in_v) = (all.iter().map(|place| place[0]).collect(), all.iter().map(|place| place[1]).collect());
    let nodes = Nodes::scattered(in_u, in_v, heights.clone(), weights.clone()).expect("checked nodes");
    Posted::polynomial(nodes, spec, &all, heights, weights)
}

/// Checks problems of these seeds; where 14 digits are claimed, radii are below 1e-13.
fn contained(seeds: std::ops::Range<u64>) {
    let (mut short, mut widest) = (0, 0.0f64);
    for seed in seeds.clone() {
        let (result, reached) = random_problem(seed).check(&format!("seed {seed}"));
        if result.numerics.correct_digits >= 14.0 {
            assert!(reached <= 1e-13, "seed {seed}: {reached:e}");
        }
        short += usize::from(reached <= 1e-13);
        widest = widest.max(reached);
    }
    println!("{short} of {} have radii below 1e-13, the widest is {widest:e}", seeds.end - seeds.start);
}

#[test]
fn exact_results_of_random_problems() {
    contained(0..600);
}

#[test]
#[ignore = "it takes minutes"]
fn exact_results_of_a_hundred_thousand_problems() {
    contained(1_000..101_000);
}

/// Heights that a polynomial meets exactly have a residual sum of 0.
#[test]
fn heights_on_the_model() {
    let places: Vec<[f64; 2]> = (0..21).map(|k| [f64::from(k), 0.0]).collect();
    let heights: Vec<f64> = places.iter().map(|[x, _]| (0..6).map(|i| x.powi(i)).sum()).collect();
    let x = places.iter().map(|place| place[0]).collect();
    let nodes = Nodes::curve(x, heights.clone(), None).expect("checked nodes");
    let model = Model::Polynomial { degree: Degree::Both(5), basis: PolynomialBasis::Monomial, terms: Terms::Tensor };
    let posted = Posted::polynomial(nodes, FitSpec::new(model), &places, heights, None);
    let (result, widest) = posted.check("powers up to 5");
    assert!(widest <= 3e-16, "{widest:e}");
    let found = of(&result);
    assert!(found.rss[0] == 0.0 && found.rss[1] < 1e-35, "{:?}", found.rss);
    assert!(found.coefficients.iter().all(|[low, high]| *low <= 1.0 && *high >= 1.0));
}

/// More nodes than one chunk, where passes are projected in double elsewhere, and a large grid.
#[test]
fn many_nodes() {
    let mut random = Random::new(77);
    let places: Vec<[f64; 2]> = (0..9_000).map(|_| [random.between(5.0, 12.0), random.between(0.4, 14.6)]).collect();
    let heights = noisy(&mut random, 1e-3, |u, v| 4.0 * (u - 9.0).powi(2) + 0.1 * v, &places);
    let (in_u, in_v) = (places.iter().map(|place| place[0]).collect(), places.iter().map(|place| place[1]).collect());
    let nodes = Nodes::scattered(in_u, in_v, heights.clone(), None).expect("checked nodes");
    let model = |basis| Model::Polynomial { degree: Degree::Each(2, 1), basis, terms: Terms::Tensor };
    let spec = FitSpec::new(model(PolynomialBasis::Monomial));
    let (result, widest) = Posted::polynomial(nodes, spec, &places, heights.clone(), None).check("scattered");
    assert!(widest <= 1e-15, "{widest:e}");
    assert!(of(&result).std_errors.iter().flatten().all(|ends| radius(*ends) <= 1e-15), "{result:?}");

    let rows: Vec<Vec<f64>> = places.iter().map(|[u, v]| vec![1.0, *u, *v, u * u]).collect();
    let (result, widest) = Posted::matrix(&rows, heights, None).check("rows");
    assert!(widest <= 1e-15 && of(&result).std_errors.iter().flatten().all(|ends| radius(*ends) <= 1e-15));

    let (u, v): (Vec<f64>, Vec<f64>) =
        ((0..70).map(f64::from).collect(), (0..40).map(|j| 0.3 * f64::from(j)).collect());
    let all: Vec<[f64; 2]> = u.iter().flat_map(|&u| v.iter().map(move |&v| [u, v])).collect();
    let heights = noisy(&mut random, 1e-3, |u, v| (0.1 * u).sin() + 0.1 * v, &all);
    let nodes = Nodes::grid(u, v, heights.clone(), None, None).expect("checked nodes");
    let spec = FitSpec::new(model(PolynomialBasis::Legendre));
    let (result, widest) = Posted::polynomial(nodes, spec, &all, heights, None).check("grid");
    assert!(widest <= 1e-15, "{widest:e}");
    assert!(of(&result).std_errors.iter().flatten().all(|ends| radius(*ends) <= 1e-15), "{result:?}");
}

/// A given σ is the double that was posted; as many coefficients as nodes leave no estimate.
#[test]
fn the_noise_may_be_given() {
    let x: Vec<Vec<f64>> = (0..4).map(|k| vec![1.0, f64::from(k)]).collect();
    let nodes = matrix(&x, &[1.0, 2.0, 2.0, 4.0], None);
    let result = fit(&nodes, &enclosed(FitSpec { noise_sigma: Some(2.0), ..linear() }));
    // (XᵀX)⁻¹ = ((0.7, −0.3), (−0.3, 0.2))
    let ends = of(&result).std_errors.as_ref().expect("a given σ");
    for (ends, square) in ends.iter().zip([2.8_f64, 0.8]) {
        assert!(ends[0] <= square.sqrt() && square.sqrt() <= ends[1] && radius(*ends) < 1e-15, "{ends:?}");
    }
    let nodes = matrix(&x[..2], &[1.0, 2.0], None);
    let found = fit(&nodes, &enclosed(linear()));
    assert!(of(&found).std_errors.is_none() && of(&found).rss[0] == 0.0 && of(&found).rss[1] < 1e-30);
}

/// Columns closer to dependent than double-double can tell, and numbers near the ends of double.
#[test]
fn unproved_enclosures_are_reported() {
    let x: Vec<Vec<f64>> = (0..9).map(|k| vec![1.0, 1.0 + 1e-300 * f64::from(k * k % 5)]).collect();
    let dependent: Vec<Vec<f64>> = (0..9).map(|k| vec![f64::from(k), 2.0 * f64::from(k)]).collect();
    let y: Vec<f64> = (0..9).map(|k| f64::from(k * 4 % 7)).collect();
    let plain = FitSpec { regularization: Regularization::TruncatedSvd { rank: 1 }, ..linear() };
    for nodes in [matrix(&x, &y, None), matrix(&dependent, &y, None)] {
        let result = fit(&nodes, &enclosed(plain.clone()));
        assert!(result.numerics.enclosure.is_none());
        assert!(result.warnings.contains(&Warning::NoEnclosure { reason: NotEnclosed::NotProved }));
    }
    let large: Vec<f64> = y.iter().map(|y| 1e120 * y).collect();
    let line: Vec<Vec<f64>> = (0..9).map(|k| vec![1.0, f64::from(k)]).collect();
    let result = fit(&matrix(&line, &large, None), &enclosed(linear()));
    assert!(result.warnings.contains(&Warning::NoEnclosure { reason: NotEnclosed::NotProved }));
}

#[test]
fn other_fits_have_none() {
    let u: Vec<f64> = (0..9).map(f64::from).collect();
    let v: Vec<f64> = (0..7).map(f64::from).collect();
    let z: Vec<f64> = (0..63).map(|k| f64::from(k * 17 % 11)).collect();
    let nodes = Nodes::grid(u, v, z, None, None).expect("checked nodes");
    let degree = Degree::Both(2);
    let plain = FitSpec::new(Model::Polynomial { degree, basis: PolynomialBasis::Legendre, terms: Terms::Tensor });
    assert!(fit(&nodes, &plain).numerics.enclosure.is_none());
    let spline = Model::BSpline { degree, knots: Knots::Spans(2), weights: None };
    let ar1 = Errors { correlation: Correlation::Ar1 { rho: None }, along: Along::V, lines: None };
    let positions = NodeUncertainty { position: 0.01, height: 0.1, kind: Some(PositionKind::Measured) };
    let others = [
        FitSpec { model: spline, ..plain.clone() },
        FitSpec { estimator: Estimator::LeastAbsolute, ..plain.clone() },
        FitSpec { errors: Some(ar1), regularization: Regularization::None, ..plain.clone() },
        FitSpec { variance: Variance::Hc3, regularization: Regularization::None, ..plain.clone() },
        FitSpec { node_uncertainty: Some(positions), ..plain.clone() },
    ];
    for other in others {
        let result = fit(&nodes, &enclosed(other));
        assert!(result.numerics.enclosure.is_none() && warned(&result, "no_enclosure"), "{:?}", result.warnings);
        assert!(result.warnings.contains(&Warning::NoEnclosure { reason: NotEnclosed::OtherFit }));
    }
    // nothing else changes
    let with = fit(&nodes, &enclosed(plain.clone()));
    let mut without = with.clone();
    without.numerics.enclosure = None;
    assert_eq!(without, fit(&nodes, &plain));
}
