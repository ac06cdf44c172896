//! Gears: `cargo xtask bench gear`. Nominal and modified grids of a million nodes, and what a
//! gear's data cost to work out.

use divan::{Bencher, counter::ItemsCount};
use flankfit_engine::gear::{
    FlankGrid, Gear, GearData, Geometry, GridSpec, Hand, Modifications, ProfileAxis, Side, Tool,
    generation::tooth::{Steps, Tooth},
    involute::{Flank, FlankPoint},
    modification::{End, Flanks, Growth, Law, Modification, Range},
};

const NODES: usize = 1_000_000;

fn gear() -> Gear {
    Gear::new(GearData {
        teeth: 83,
        normal_module: 2.03,
        pressure_angle: 18f64.to_radians(),
        helix_angle: 28f64.to_radians(),
        hand: Hand::Right,
        profile_shift: 0.1,
        face_width: Some(30.0),
        tip_diameter: None,
        root_diameter: None,
        internal: false,
        tool: Some(Tool { tip_radius: 0.6, addendum_factor: 1.35, protuberance: 0.03 }),
    })
    .expect("a gear")
}

/// `rows` × `columns` nodes of the usable flank.
fn nodes(gear: &Gear, rows: usize, columns: usize) -> GridSpec {
    let usable = Geometry::of(gear).usable_profile.expect("a usable flank");
    let between = |[a, b]: [f64; 2], k: usize, n: usize| a + (b - a) * k as f64 / (n - 1) as f64;
    GridSpec {
        side: Side::Left,
        axis: ProfileAxis::RollLength,
        values: (0..rows).map(|k| between(usable.roll_lengths_mm, k, rows)).collect(),
        positions: (0..columns).map(|k| between([0.0, 30.0], k, columns)).collect(),
        tooth: 1,
    }
}

#[divan::bench(sample_count = 20, sample_size = 1)]
fn a_million_nominal_nodes(bencher: Bencher) {
    let gear = gear();
    let spec = nodes(&gear, 1000, 1000);
    bencher.counter(ItemsCount::new(NODES)).bench_local(|| FlankGrid::new(&gear, divan::black_box(&spec), None));
}

/// The same node by node, with sine and cosine for each.
#[divan::bench(sample_count = 20, sample_size = 1)]
fn a_million_nominal_nodes_one_by_one(bencher: Bencher) {
    let gear = gear();
    let spec = nodes(&gear, 1000, 1000);
    bencher.counter(ItemsCount::new(NODES)).bench_local(|| -> Vec<FlankPoint> {
        let flank = Flank::new(&gear, spec.side);
        let row = |roll: &f64| {
            let roll = *roll;
            spec.positions.iter().map(move |z| flank.at(roll, *z))
        };
        divan::black_box(&spec).values.iter().flat_map(row).collect()
    });
}

#[divan::bench(sample_count = 20, sample_size = 1)]
fn a_million_modified_nodes(bencher: Bencher) {
    let gear = gear();
    let spec = nodes(&gear, 1000, 1000);
    let range = Range::whole(&gear).expect("a range");
    let start_diameter = gear.diameter(0.3 * range.profile()[0] + 0.7 * range.profile()[1]);
    let laws = [
        Law::ProfileCrowning { amount: 5.0 },
        Law::TipRelief { amount: 20.0, start_diameter, growth: Growth::Parabolic },
        Law::HelixCrowning { amount: 6.0 },
        Law::EndRelief { end: End::High, amount: 10.0, length: 4.0, growth: Growth::Linear },
        Law::Twist { amount: 8.0 },
    ];
    let list = laws.map(|law| Modification { flanks: Flanks::Both, law }).to_vec();
    let modifications = Modifications::new(&gear, range, list).expect("modifications");
    bencher
        .counter(ItemsCount::new(NODES))
        .bench_local(|| FlankGrid::new(&gear, divan::black_box(&spec), Some(&modifications)));
}

#[divan::bench]
fn geometry_of_a_gear(bencher: Bencher) {
    let gear = gear();
    bencher.bench_local(|| Geometry::of(divan::black_box(&gear)));
}

#[divan::bench]
fn profile_of_all_teeth(bencher: Bencher) {
    let gear = gear();
    bencher.bench_local(|| Tooth::new(divan::black_box(&gear), Steps::default()).map(|tooth| tooth.gear()));
}
