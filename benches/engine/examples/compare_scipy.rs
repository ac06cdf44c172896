//! Our side of `tools/compare_scipy.py`: reads its data, does the work, writes the numbers, and
//! prints what it took.
//!
//! Run: `cargo run --release -p engine-benches --example compare_scipy -- FOLDER REPEATS`. The
//! folder holds little-endian doubles: `u`, `v`, `z` (the nodes of a grid, v running fastest),
//! `knots_u`, `knots_v` (for a bicubic surface), `at` (pairs of parameters), `grid_u`, `grid_v`.
//! Written are `coefficients`, `scattered` and `grid`; printed are the seconds of each repetition
//! as JSON.

mod timing;

use std::path::Path;

use flankfit_engine::geometry::surface::{
    SurfaceShape,
    evaluate::Evaluator,
    grid::NodeGrid,
    least_squares::{AxisKnots, least_squares},
};

use serde_json::json;
use timing::{Outcome, read, timed, write};

/// Allocator of the HTTP service.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, repeats] = &arguments[..] else { return Err("two arguments: FOLDER REPEATS".into()) };
    let (folder, repeats) = (Path::new(folder), repeats.parse()?);
    let [u, v, z] = [read(folder, "u")?, read(folder, "v")?, read(folder, "z")?];
    let knots = [read(folder, "knots_u")?, read(folder, "knots_v")?];
    let at: Vec<[f64; 2]> = read(folder, "at")?.chunks(2).map(|pair| [pair[0], pair[1]]).collect();
    let [grid_u, grid_v] = [read(folder, "grid_u")?, read(folder, "grid_v")?];

    let (fitted, fit) = timed(repeats, 500, || {
        let nodes = NodeGrid::heights(u.clone(), v.clone(), &z)?;
        Ok(least_squares(&nodes, [3, 3], knots.clone().map(AxisKnots::Given))?.0)
    })?;
    let coefficients: Vec<f64> = fitted.control_points().iter().map(|p| p.x).collect();
    write(folder, "coefficients", &coefficients)?;

    let surface = SurfaceShape::BSpline(fitted);
    let (heights, scattered) = timed(repeats, 1, || Ok(Evaluator::new(&surface).heights(&at)))?;
    write(folder, "scattered", &heights)?;
    let (heights, grid) = timed(repeats, 1, || Ok(Evaluator::new(&surface).grid_heights(&grid_u, &grid_v)))?;
    write(folder, "grid", &heights)?;
    println!("{}", json!({"fit": fit, "scattered": scattered, "grid": grid}));
    Ok(())
}
