//! Files of gear measurements: `cargo xtask bench gear_files`. A curve file of 5 MB with teeth
//! all around, the same with its positions, a value file, and a list of points.

use std::fmt::Write as _;

use divan::{Bencher, counter::BytesCount};
use flankfit_engine::{
    formats::{
        gear_file,
        klingelnberg::{SignConvention, read_curves, read_values},
        table::{self, Mapping},
    },
    gear::Gear,
};

use klingelnberg_file::{Lines, Style, Trace};

/// 480 samples with the noise of a generator of fixed sequence, undefined at the end.
fn samples(seed: usize) -> Vec<Option<f64>> {
    let mut state = seed as u64 + 1;
    let mut value = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / 400.0 - 20_000.0 / 400.0
    };
    (0..480).map(|i| (i < 472).then(&mut value)).collect()
}

/// Traces until the file has 5 MB.
fn curve_file() -> Vec<u8> {
    let traces: Vec<Trace> = (0..800)
        .map(|k| Trace {
            tooth: (k / 4 + 1).to_string(),
            left: k % 2 == 0,
            profile: k % 4 < 2,
            index: 2,
            section: if k % 4 < 2 { 7.5 } else { 8.742 },
            values: samples(k),
        })
        .collect();
    let mut lines = Lines::new(&Style::default(), "MK");
    lines.gear(&klingelnberg_file::Gear::spur(), false).traces(&traces);
    lines.bytes()
}

#[divan::bench]
fn curves_of_5_mb(bencher: Bencher) {
    let bytes = curve_file();
    bencher.counter(BytesCount::of_slice(&bytes)).bench(|| read_curves(&bytes).expect("a sound file"));
}

#[divan::bench]
fn curves_of_5_mb_with_positions(bencher: Bencher) {
    let bytes = curve_file();
    bencher.counter(BytesCount::of_slice(&bytes)).bench(|| {
        let file = read_curves(&bytes).expect("a sound file");
        let data = file.header.gear(&mut Default::default()).gear_data().expect("a whole gear");
        let gear = Gear::new(data).expect("a gear");
        file.place(&gear).with_sense(file.signs(), SignConvention::Material)
    });
}

#[divan::bench]
fn values_of_10000_results(bencher: Bencher) {
    let mut lines = Lines::new(&Style::default(), "MW");
    lines.gear(&klingelnberg_file::Gear::spur(), false);
    for k in 0..10_000 {
        lines.line(&format!("{} : fHb links {k} : {:>7}", 10_000 + k, 0.1 * f64::from(k)));
    }
    let bytes = lines.bytes();
    bencher.counter(BytesCount::of_slice(&bytes)).bench(|| read_values(&bytes).expect("a sound file"));
}

#[divan::bench]
fn points_100000(bencher: Bencher) {
    let mut text = String::from("id,x,y,z,i,j,k\n");
    for k in 0..100_000 {
        let a = 1e-4 * f64::from(k);
        let _ =
            writeln!(text, "p{k},{:.6},{:.6},{:.6},{:.9},{:.9},0", 50.0 * a.cos(), 50.0 * a.sin(), a, a.cos(), a.sin());
    }
    bencher.counter(BytesCount::of_slice(text.as_bytes())).bench(|| {
        table::read(text.as_bytes(), &Mapping::default()).and_then(|table| table.points()).expect("a sound list")
    });
}

#[divan::bench]
fn recognised_by_content(bencher: Bencher) {
    let bytes = curve_file();
    bencher.counter(BytesCount::of_slice(&bytes)).bench(|| gear_file::read(&bytes, None, None).expect("a sound file"));
}
