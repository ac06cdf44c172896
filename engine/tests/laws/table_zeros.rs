//! Tables of traces: how often separate zeros are found, and how often one zero is doubted.

use crate::oracle::random::Random;
use flankfit_engine::formats::table::{self, Mapping, NodeSet};

/// Traces over a crowned and twisted flank, with noise and a zero for each trace.
fn nodes(random: &mut Random, each: usize, teeth: usize, noise: f64, zero: f64) -> Vec<NodeSet> {
    let mut text = "tooth;trace;roll_length [mm];face_width [mm];deviation [um]\n".to_owned();
    let sections = |low: f64, high: f64| (0..each).map(move |k| low + (high - low) * (k as f64 + 0.5) / each as f64);
    for tooth in 1..=teeth {
        let [slope, crowning] = [random.between(-10.0, 10.0), random.between(0.0, 6.0)];
        let flank = |u: f64, v: f64| {
            let (x, y) = ((u - 9.0) / 3.0, (v - 7.5) / 7.5);
            slope * x - 4.0 * y - crowning * (x * x + y * y) + 2.0 * x * y
        };
        for v in sections(0.0, 15.0) {
            let own = zero * random.normal();
            for u in (0..=40).map(|k| 6.0 + 0.15 * f64::from(k)) {
                let height = flank(u, v) + own + noise * random.normal();
                text += &format!("{tooth};profile;{u};{v};{height}\n");
            }
        }
        for u in sections(6.0, 12.0) {
            let own = zero * random.normal();
            for v in (0..=40).map(|k| 0.375 * f64::from(k)) {
                let height = flank(u, v) + own + noise * random.normal();
                text += &format!("{tooth};lead;{u};{v};{height}\n");
            }
        }
    }
    let table = table::read(text.as_bytes(), &Mapping::default()).expect("a table");
    table.node_sets().expect("nodes")
}

/// One zero is taken for several in about 1 of 100 tables at most, whatever the noise; zeros that
/// scatter by 3 µm are found in all but a few, of a plain cross in most.
#[test]
fn separate_zeros_are_found() {
    let mut random = Random::new(20_261_129);
    let draws = 400;
    for (each, teeth, noise, least) in
        [(1, 1, 0.3, 0.5), (2, 1, 0.1, 0.95), (2, 1, 0.6, 0.8), (3, 1, 0.6, 0.98), (3, 3, 0.3, 1.0), (5, 1, 0.6, 1.0)]
    {
        let mut share = |zero: f64| {
            let found = (0..draws).filter(|_| {
                let sets = nodes(&mut random, each, teeth, noise, zero);
                assert_eq!(sets.len(), teeth);
                sets.iter().all(|set| set.own_zeros.is_some())
            });
            found.count() as f64 / f64::from(draws)
        };
        let (one, several) = (share(0.0), share(3.0));
        assert!(one <= 0.025, "{each} {teeth} {noise}: {one}");
        assert!(several >= least, "{each} {teeth} {noise}: {several}");
    }
}
