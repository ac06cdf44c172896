//! Least condition is not least error: what each criterion costs and gains over many simulated
//! surfaces whose true coefficients are known. Seeded, so that every run sees the same noise.
//!
//! `cargo test --test laws simulation -- --nocapture` prints the figures that the documentation
//! quotes.

use crate::oracle::design::{Basis, crossings, surface};
use crate::oracle::matrix::{column, doubles, least_squares};
use crate::oracle::random::Random;
use crate::problems::{by, fit, linear, matrix, polynomial, spectral, warned};
use flankfit_engine::estimation::Nodes;
use flankfit_engine::estimation::spec::{
    Count, Criterion, Degree, FitSpec, PolynomialBasis, Regularization, Scaling, Scheme,
};

/// Surfaces of one degree on 9 × 5 crossings of [30, 34] × [0, 20] mm.
struct Place {
    nodes: Vec<[f64; 2]>,
    degree: usize,
    /// Products of Legendre polynomials at the nodes.
    orthogonal: Vec<Vec<f64>>,
    /// From their coefficients to those of u^p v^q.
    change: Vec<Vec<f64>>,
    /// Lengths of the raw columns, by which errors are scaled.
    scales: Vec<f64>,
}

impl Place {
    fn new(degree: usize) -> Self {
        let u: Vec<f64> = (0..9).map(|i| 30.0 + 0.5 * f64::from(i)).collect();
        let v: Vec<f64> = (0..5).map(|j| 5.0 * f64::from(j)).collect();
        let nodes = crossings(&u, &v);
        let legendre = [Basis::Legendre([30.0, 34.0]), Basis::Legendre([0.0, 20.0])];
        let orthogonal = surface(legendre, [degree, degree], &nodes, |_, _| true);
        let raw = surface([Basis::Monomial, Basis::Monomial], [degree, degree], &nodes, |_, _| true);
        let n = raw[0].len();
        let columns: Vec<Vec<f64>> =
            (0..n).map(|j| doubles(&least_squares(&raw, &column(&orthogonal, j)).coefficients)).collect();
        let change = (0..n).map(|i| columns.iter().map(|column| column[i]).collect()).collect();
        let scales = (0..n).map(|j| raw.iter().map(|row| row[j].to_f64().powi(2)).sum::<f64>().sqrt()).collect();
        Place { nodes, degree, orthogonal: orthogonal.iter().map(|row| doubles(row)).collect(), change, scales }
    }
}

/// A surface with known coefficients of u^p v^q.
struct Truth<'a> {
    place: &'a Place,
    heights: Vec<f64>,
    coefficients: Vec<f64>,
}

impl<'a> Truth<'a> {
    /// Coefficients of the orthogonal products decay like `decay` to the order; the constant is
    /// about 20 µm.
    fn new(place: &'a Place, random: &mut Random, decay: f64) -> Self {
        let size = 0..=place.degree;
        let orders = size.clone().flat_map(|p| size.clone().map(move |q| p + q));
        let true_ones: Vec<f64> = orders.map(|order| 0.02 * decay.powi(order as i32) * random.normal()).collect();
        let times = |rows: &[Vec<f64>]| -> Vec<f64> {
            rows.iter().map(|row| row.iter().zip(&true_ones).map(|(x, a)| x * a).sum()).collect()
        };
        Truth { place, heights: times(&place.orthogonal), coefficients: times(&place.change) }
    }

    fn measured(&self, random: &mut Random, noise: f64) -> Nodes {
        let axis = |k: usize| self.place.nodes.iter().map(|n| n[k]).collect();
        let z = self.heights.iter().map(|z| z + noise * random.normal()).collect();
        Nodes::scattered(axis(0), axis(1), z, None).expect("checked nodes")
    }

    fn squared_error(&self, values: impl Iterator<Item = f64>) -> f64 {
        let parts = values.zip(&self.coefficients).zip(&self.place.scales);
        parts.map(|((value, truth), scale)| ((value - truth) * scale).powi(2)).sum()
    }
}

struct Outcome {
    /// Mean squared error of the criterion over that of least squares, surface by surface.
    ratios: Vec<f64>,
    total: f64,
    warned: usize,
    fits: usize,
}

fn simulate(regularization: &Regularization, place: &Place, decay: f64, noise: f64, noises: usize) -> Outcome {
    let mut random = Random::new(7 + place.degree as u64);
    let spec = FitSpec {
        regularization: regularization.clone(),
        ..polynomial(Degree::Both(place.degree), PolynomialBasis::Monomial)
    };
    let (mut ratios, mut sums, mut warnings, mut fits) = (Vec::new(), [0.0, 0.0], 0, 0);
    for _ in 0..SURFACES {
        let truth = Truth::new(place, &mut random, decay);
        let (mut own, mut plain) = (0.0, 0.0);
        for _ in 0..noises {
            let result = fit(&truth.measured(&mut random, noise), &spec);
            own += truth.squared_error(result.coefficients.iter().map(|c| c.value));
            plain += truth.squared_error(result.coefficients.iter().map(|c| c.least_squares));
            warnings += usize::from(warned(&result, "worse_than_least_squares"));
            fits += 1;
        }
        ratios.push(own / plain);
        sums[0] += own;
        sums[1] += plain;
    }
    ratios.sort_by(f64::total_cmp);
    Outcome { ratios, total: sums[0] / sums[1], warned: warnings, fits }
}

const SURFACES: usize = 24;

#[test]
fn the_default_beats_least_squares_on_smooth_surfaces_and_least_condition_does_not() {
    println!("degree decay noise_um | min_mse: all, median, worst | min_condition: all, median, worst, warned");
    let (mut all_default, mut worst_default, mut worst_condition, mut cases) = (0.0, 0.0f64, 0.0f64, 0);
    for degree in [2, 3] {
        let place = Place::new(degree);
        for decay in [0.1, 0.3, 0.6] {
            for noise in [0.5e-3, 2e-3] {
                let run = |r: &Regularization, noises| simulate(r, &place, decay, noise, noises);
                let default = run(&Regularization::default(), 100);
                let least = run(&spectral(Scheme::FirstOrder, Count::Auto, by(Criterion::MinCondition)), 20);
                let (last, middle) = (default.ratios.len() - 1, default.ratios.len() / 2);
                println!(
                    "{degree} {decay:5} {:4} | {:.3} {:.3} {:.3} | {:.3e} {:.3e} {:.3e} {:.2}",
                    noise * 1e3,
                    default.total,
                    default.ratios[middle],
                    default.ratios[last],
                    least.total,
                    least.ratios[middle],
                    least.ratios[last],
                    least.warned as f64 / least.fits as f64,
                );
                all_default += default.total.ln();
                worst_default = worst_default.max(default.ratios[last]);
                worst_condition = worst_condition.max(least.ratios[last]);
                cases += 1;
                if least.total > 2.0 {
                    assert!(least.warned * 2 > least.fits, "warned {} times in {}", least.warned, least.fits);
                }
            }
        }
    }
    let mean = (all_default / f64::from(cases)).exp();
    println!("min_mse over all: geometric mean {mean:.3}, worst surface {worst_default:.3}");
    println!("min_condition: worst surface {worst_condition:.3e}");
    assert!(mean < 0.75, "the default wins too little: {mean}");
    assert!(worst_default < 2.0, "the default loses too much: {worst_default}");
    assert!(worst_condition > 100.0, "the warning about least condition would be idle: {worst_condition}");
}

/// The price of one direction: ratio of mean squared errors against |a|√λ/σ.
fn price(scheme: Scheme, known_sigma: bool, strength: f64, repetitions: usize) -> f64 {
    let mut random = Random::new((strength * 1000.0) as u64 + 17);
    let (small, m) = (1e-4f64, 30);
    let x: Vec<Vec<f64>> = (0..m)
        .map(|k| match k {
            0 => vec![small, 0.0],
            1 => vec![0.0, 1.0],
            _ => vec![0.0, 0.0],
        })
        .collect();
    let regularization = spectral(scheme, Count::Given(1), by(Criterion::MinMse));
    let noise_sigma = known_sigma.then_some(1.0);
    let spec = FitSpec { scaling: Scaling::None, regularization, noise_sigma, ..linear() };
    let (mut own, mut plain) = (0.0, 0.0);
    for _ in 0..repetitions {
        let mut y = random.normals(m);
        y[0] += strength;
        let result = fit(&matrix(&x, &y, None), &spec);
        own += (result.coefficients[0].value * small - strength).powi(2);
        plain += (result.coefficients[0].least_squares * small - strength).powi(2);
    }
    own / plain
}

#[test]
fn the_price_of_shrinking_one_direction() {
    println!("|a|√λ/σ: first_order σ known, σ̂ estimated; exact σ known");
    let (mut worst, mut worst_at) = (0.0f64, 0.0);
    for step in 0..13 {
        let strength = 0.4 * f64::from(step);
        let known = price(Scheme::FirstOrder, true, strength, 4000);
        let estimated = price(Scheme::FirstOrder, false, strength, 4000);
        let exact = price(Scheme::Exact, true, strength, 4000);
        println!("{strength:4.1}: {known:.3} {estimated:.3}; {exact:.3}");
        // In theory both schemes shrink by (1 − 1/z²)₊ of the observed z.
        let expected = theory(strength);
        assert!((known / expected - 1.0).abs() < 0.08, "{known} measured, {expected} by quadrature");
        assert!((exact / expected - 1.0).abs() < 0.08, "{exact} measured, {expected} by quadrature");
        if estimated > worst {
            (worst, worst_at) = (estimated, strength);
        }
        if step == 0 {
            assert!(known < 0.4, "where there is nothing, shrinking wins three times: {known}");
        }
    }
    println!("worst {worst:.3} at {worst_at}");
    assert!(worst < 1.65 && (1.6..=3.2).contains(&worst_at));
}

/// E[((1 − 1/z²)₊ z − θ)²] for z ~ N(θ, 1), by the midpoint rule.
fn theory(strength: f64) -> f64 {
    let width = 16.0 / 20_000.0;
    (0..20_000)
        .map(|k| {
            let noise = -8.0 + (f64::from(k) + 0.5) * width;
            let z = strength + noise;
            let shrunk = if z.abs() > 1.0 { z - 1.0 / z } else { 0.0 };
            (shrunk - strength).powi(2) * (-0.5 * noise * noise).exp() / std::f64::consts::TAU.sqrt() * width
        })
        .sum()
}
