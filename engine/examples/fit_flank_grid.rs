//! Fits a flank grid and says which terms its nodes cannot tell apart.
//!
//! Run: `cargo run -p flankfit-engine --example fit_flank_grid`

use std::error::Error;

use flankfit_engine::estimation::{
    FitSpec, Nodes, fit,
    spec::{Degree, Model, PolynomialBasis, Terms},
};

/// A slope of 4 µm, crownings of 3 and 2 µm and a ripple, over roll length and face width in mm.
fn deviation(roll_length: f64, face_width: f64) -> f64 {
    let (s, t) = ((roll_length - 8.625) / 2.625, (face_width - 7.5) / 6.75);
    4.0 * s - 3.0 * s * s - 2.0 * t * t + 0.3 * (37.0 * roll_length + 19.0 * face_width).sin()
}

fn main() -> Result<(), Box<dyn Error>> {
    let roll_length: Vec<f64> = (0..9).map(|i| 6.0 + 0.65625 * f64::from(i)).collect();
    let face_width: Vec<f64> = (0..10).map(|j| 0.75 + 1.5 * f64::from(j)).collect();
    let heights = roll_length.iter().flat_map(|&u| face_width.iter().map(move |&v| deviation(u, v))).collect();
    let nodes = Nodes::grid(roll_length, face_width, heights, None, None)?;

    let model = Model::Polynomial { degree: Degree::Both(2), basis: PolynomialBasis::Monomial, terms: Terms::Tensor };
    let found = fit(&nodes, &FitSpec::new(model))?;

    println!("term        coefficient   std. error   bias at most");
    for coefficient in &found.coefficients {
        let error = coefficient.std_error.map_or("-".into(), |error| format!("{error:.5}"));
        println!("{:10} {:12.5} {error:>12} {:14.5}", coefficient.term, coefficient.value, coefficient.bias_bound);
    }
    println!("\nThe surface follows the nodes to {:.3} µm (rms). Over this grid:", found.residuals.rms);
    for dependency in &found.collinearity.near_dependencies {
        println!("- {}", dependency.sentence);
    }
    Ok(())
}
