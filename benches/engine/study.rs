//! The randomisation study: `cargo xtask bench study`. Levels from so small that arithmetic of
//! twice the precision is needed to so large that it is not.

use divan::Bencher;
use flankfit_engine::estimation::randomization::{ColumnScaling, Setup, Study, run};

/// Powers of a roll length from 9 to 17 mm.
fn study(rows: usize, columns: usize, level: f64) -> Study {
    let at = |i: usize| 9.0 + 8.0 * i as f64 / (rows - 1) as f64;
    Study::new(Setup {
        x: (0..rows).map(|i| (0..columns).map(|j| at(i).powi(j as i32)).collect::<Vec<f64>>()).collect(),
        coefficients: vec![1.0; columns],
        noise_sigma: 0.3,
        levels: vec![level],
        repetitions: 50,
        seed: 1,
        scaling: ColumnScaling::None,
    })
    .expect("the setup is valid")
}

#[divan::bench(args = [1e-6, 1e-1], consts = [3, 5, 9], max_time = 3)]
fn fifty_repetitions_of_a_level<const COLUMNS: usize>(bencher: Bencher, level: f64) {
    let study = study(135, COLUMNS, level);
    run(&study).expect("the study has an answer");
    bencher.bench_local(|| run(divan::black_box(&study)));
}
