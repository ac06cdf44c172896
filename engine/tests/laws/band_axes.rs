//! Lines of bands are straight over the coordinate that their points are given in.

use flankfit_engine::gear::{
    Gear, GearData, Kind, ProfileAxis, Side, Trace,
    evaluation::{
        Against, Posted,
        band::{Band, BandPosition},
        evaluate,
        settings::{DeviationSign, ProfileSettings, Settings},
    },
};

const DIAMETERS: [f64; 2] = [49.5, 54.0];

/// A profile that rises by 10 µm for each mm of diameter.
fn found(gear: &Gear, band: Band) -> BandPosition {
    let diameter = |k: u32| DIAMETERS[0] + 0.045 * f64::from(k);
    let roll = |d: f64| (0.25 * d * d - gear.base_radius().powi(2)).sqrt();
    let trace = Trace {
        tooth: "1".into(),
        side: Side::Left,
        kind: Kind::Profile,
        at: (0..=100).map(|k| roll(diameter(k))).collect(),
        section: None,
        deviation: (0..=100).map(|k| 10.0 * (diameter(k) - DIAMETERS[0])).collect(),
    };
    let settings = Settings {
        profile: Some(ProfileSettings::on(DIAMETERS)),
        given: DeviationSign::Material,
        bands: vec![band],
        ..Settings::default()
    };
    let found = evaluate(gear, &[Posted { trace: &trace, design: None }], &settings).expect("the trace is sound");
    found.traces[0].bands[0]
}

/// In a band whose lines are straight over diameters the profile fits between them; over roll
/// lengths, with the same corners, it leaves the band.
#[test]
fn lines_over_diameters_are_straight_over_diameters() {
    let gear = Gear::new(GearData::spur(52, 1.0)).expect("it exists");
    // a little outside the samples, which are rounded
    let ends = [DIAMETERS[0] - 1e-6, DIAMETERS[1] + 1e-6];
    let line = |shift: f64| ends.map(|d| [d, shift + 10.0 * (d - DIAMETERS[0])]).to_vec();
    let (kind, side) = (Kind::Profile, None);
    let band = Band {
        kind,
        side,
        against: Against::Involute,
        axis: ProfileAxis::Diameter,
        upper: line(0.01),
        lower: line(-0.01),
    };
    let straight = found(&gear, band.clone());
    assert!((straight.clearance_um - 0.02).abs() < 1e-6 && straight.shift_um.abs() < 1e-6, "{straight:?}");
    assert_eq!(straight.within, Some(true));
    // where it is nearest is a roll length still
    assert!(straight.nearest_mm.iter().all(|roll| (0.0..13.0).contains(roll)), "{straight:?}");
    let rolls = |line: &[[f64; 2]]| -> Vec<[f64; 2]> {
        line.iter().map(|[d, y]| [gear.roll_length(*d).expect("above the base circle"), *y]).collect()
    };
    let bent = Band { axis: ProfileAxis::RollLength, upper: rolls(&band.upper), lower: rolls(&band.lower), ..band };
    let bent = found(&gear, bent);
    assert!(bent.clearance_um < -3.0 && bent.within == Some(false), "{bent:?}");
}
