//! Our side of `tools/compare_scipy.py`: reads its data, does the work, writes the numbers, and
//! prints what it took.
//!
//! Run: `cargo run --release --example compare_scipy -- FOLDER REPEATS`. The folder holds
//! little-endian doubles: `u`, `v`, `z` (the nodes of a grid, v running fastest), `knots_u`,
//! `knots_v` (for a bicubic surface), `at` (pairs of parameters), `grid_u`, `grid_v`. Written are
//! `coefficients`, `scattered` and `grid`; printed are the seconds of each repetition as JSON.

use std::{error::Error, fs, path::Path, time::Instant};

use flankfit_engine::geometry::surface::{
    SurfaceShape,
    evaluate::Evaluator,
    grid::NodeGrid,
    least_squares::{AxisKnots, least_squares},
};

use serde_json::{Value, json};

/// As the HTTP service has it.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

type Outcome<T> = Result<T, Box<dyn Error>>;

fn read(folder: &Path, name: &str) -> Outcome<Vec<f64>> {
    let bytes = fs::read(folder.join(name))?;
    bytes.chunks(8).map(|b| Ok(f64::from_le_bytes(b.try_into()?))).collect()
}

fn write(folder: &Path, name: &str, numbers: &[f64]) -> Outcome<()> {
    let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    Ok(fs::write(folder.join(name), bytes)?)
}

/// Seconds that the threads of this process have been on a processor: what other programs do has
/// little part in it. `None` where the system does not say (it is Linux that does).
fn processor_seconds() -> Option<f64> {
    let mut nanoseconds = 0;
    for task in fs::read_dir("/proc/self/task").ok()? {
        let text = fs::read_to_string(task.ok()?.path().join("schedstat")).ok()?;
        nanoseconds += text.split(' ').next()?.parse::<u64>().ok()?;
    }
    Some(nanoseconds as f64 * 1e-9)
}

/// The last result, and seconds for every repetition: as a clock shows them, and of processors. One
/// repetition is `batch` times the work.
fn timed<T>(repeats: usize, batch: usize, mut work: impl FnMut() -> Outcome<T>) -> Outcome<(T, Value)> {
    let mut last = work()?;
    let (mut clock, mut processor) = (Vec::new(), Vec::new());
    for _ in 0..repeats {
        let (start, busy) = (Instant::now(), processor_seconds());
        for _ in 0..batch {
            last = work()?;
        }
        clock.push(start.elapsed().as_secs_f64() / batch as f64);
        if let (Some(from), Some(to)) = (busy, processor_seconds()) {
            processor.push((to - from) / batch as f64);
        }
    }
    Ok((last, json!({"clock": clock, "processor": processor})))
}

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
