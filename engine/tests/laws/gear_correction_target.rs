//! Targets of corrections: a design, or the middle of limits.

use flankfit_engine::gear::{
    Side,
    correction::{
        Flank,
        flank::Design,
        machine::{Machine, Ranges},
    },
    evaluation::flank_surface::{FigureTerms, FlankFigures, Reference},
    modification::{End, Flanks, Growth, Law, Modification},
    trace::Direction,
};

use super::gear_correction_needed::{flank, helical};

const DESIGN: FlankFigures = FlankFigures {
    profile_slope: Some(3.0),
    helix_slope: Some(-4.0),
    profile_crowning: Some(5.0),
    helix_crowning: Some(6.0),
    twist: Some(2.5),
};

/// The deviations of a design have its figures, on either flank; over half the range a quarter of
/// the crowning and half of a slope.
#[test]
fn a_design_has_its_own_figures() {
    for side in [Side::Left, Side::Right] {
        let flank = flank(helical(), side);
        let whole = Design { figures: DESIGN, ..Design::default() };
        let found = flank.figures(&flank.designed(&whole).unwrap(), None).unwrap();
        for ((name, found), (_, wanted)) in found.named().into_iter().zip(DESIGN.named()) {
            assert!((found.unwrap() - wanted.unwrap()).abs() < 1e-9, "{side:?} {name}");
        }
        let Ranges { profile: [from, to], helix: [low, high] } = flank.ranges;
        let (l, z) = (to - from, high - low);
        let twice = Design {
            profile: Some([from - 0.5 * l, to + 0.5 * l]),
            helix: Some([low - 0.5 * z, high + 0.5 * z]),
            ..whole
        };
        let found = flank.figures(&flank.designed(&twice).unwrap(), None).unwrap();
        for ((name, found), share) in found.named().into_iter().zip([0.5, 0.5, 0.25, 0.25, 0.25]) {
            let wanted = share * DESIGN.named().into_iter().find(|(other, _)| *other == name).unwrap().1.unwrap();
            assert!((found.unwrap() - wanted).abs() < 1e-9, "{side:?} {name}: {found:?} {wanted}");
        }
        assert!(flank.designed(&Design::default()).unwrap().iter().all(|t| *t == 0.0));
        // also where slopes refer to the face width, and in the transverse plane
        for direction in [Direction::Normal, Direction::Transverse] {
            let flank = Flank { terms: FigureTerms { direction, reference: Reference::Length }, ..flank.clone() };
            let whole = Design { figures: DESIGN, ..Design::default() };
            let found = flank.figures(&flank.designed(&whole).unwrap(), None).unwrap();
            for ((name, found), (_, wanted)) in found.named().into_iter().zip(DESIGN.named()) {
                assert!((found.unwrap() - wanted.unwrap()).abs() < 1e-9, "{side:?} {direction:?} {name}");
            }
        }
    }
}

/// An end relief removes material at its end and nowhere else.
#[test]
fn modifications_are_part_of_a_design() {
    let flank = flank(helical(), Side::Right);
    let law = Law::EndRelief { end: End::High, amount: 4.0, length: 4.0, growth: Growth::Linear };
    let relief =
        |flanks| Design { modifications: vec![Modification { flanks, law: law.clone() }], ..Design::default() };
    let target = flank.designed(&relief(Flanks::Right)).unwrap();
    for (place, t) in flank.places.iter().zip(&target) {
        let wanted = -((place.z - 15.0) / 4.0).max(0.0) * 4.0;
        assert!((t - wanted).abs() < 1e-9, "{place:?}: {t} {wanted}");
    }
    assert!(flank.designed(&relief(Flanks::Left)).unwrap().iter().all(|t| *t == 0.0));
}

fn measured(flank: &Flank) -> Vec<f64> {
    let value = |(k, place): (usize, &flankfit_engine::gear::correction::machine::FlankNode)| {
        let (u, v) = ((place.roll_length - 13.0) / 4.0, (place.z - 10.0) / 9.0);
        7.0 + 4.0 * u - 5.0 * v - 3.7 * u * u - 5.5 * v * v + 0.9 * u * v + 0.4 * (1.7 * k as f64).sin()
    };
    let mut list: Vec<f64> = flank.places.iter().enumerate().map(value).collect();
    list[3] = f64::NAN;
    list
}

/// The target moves each figure with limits to their middle; the other second-order terms and the
/// level stay as measured, form deviations do not.
#[test]
fn limits_are_aimed_at_in_their_middle() {
    let flank = flank(helical(), Side::Right);
    let measured = measured(&flank);
    let mut weight = vec![1.0; measured.len()];
    weight[7] = 0.0;
    let limits = FlankFigures {
        profile_slope: Some([-5.0, 3.0]),
        profile_crowning: Some([2.0, 6.0]),
        ..FlankFigures::default()
    };
    let target = flank.target_within(&measured, Some(&weight), limits).unwrap();
    assert!(target.iter().all(|t| t.is_finite()));
    let [before, wanted] = [&measured, &target].map(|list| flank.figures(list, Some(&weight)).unwrap());
    for ((name, before), (_, wanted)) in before.named().into_iter().zip(wanted.named()) {
        let aim = match name {
            "profile_slope" => -1.0,
            "profile_crowning" => 4.0,
            _ => before.unwrap(),
        };
        assert!((wanted.unwrap() - aim).abs() < 1e-9, "{name}: {wanted:?} {aim}");
    }
    // the target is a surface of second order, on the level of the measured flank
    let left: f64 = (0..measured.len())
        .filter(|&k| weight[k] > 0.0 && !measured[k].is_nan())
        .map(|k| {
            let place = &flank.places[k];
            let (u, _) = ((place.roll_length - 13.0) / 4.0, place.z);
            let moved =
                0.5 * (before.profile_slope.unwrap() + 1.0) * u - (before.profile_crowning.unwrap() - 4.0) * u * u;
            measured[k] - target[k] - moved
        })
        .sum();
    assert!(left.abs() < 1e-9, "{left}");
    // nodes on one line determine no figures, and so no target
    let line = Flank { places: flank.places[..9].to_vec(), ..flank.clone() };
    assert_eq!(line.target_within(&measured[..9], None, limits), None);
}

/// Changes of the figures by the settings of both machines, on either flank.
#[test]
fn figures_follow_the_settings() {
    for (machine, side) in [(Machine::FormGrinding, Side::Left), (Machine::GeneratingGrinding, Side::Right)] {
        let flank = flank(helical(), side);
        let found = machine.sensitivity(&flank.gear, &flank.places, flank.ranges).unwrap();
        let asked = flankfit_engine::gear::correction::CorrectionSpec::new(
            measured(&flank),
            found.matrix.clone(),
            found.settings.clone(),
        );
        let held = flank.held(&asked, FlankFigures::default());
        assert_eq!(held.len(), 6, "five figures and the level");
        let moved = |figure: &str, setting: &str| {
            let place = found.settings.iter().position(|found| found.name == setting).unwrap();
            held.iter().find(|held| held.name == figure).unwrap().moved[place]
        };
        assert!((moved("profile_crowning", "profile_crowning") - 1.0).abs() < 1e-9);
        assert!(moved("profile_slope", "profile_angle") < 0.0 && moved("helix_slope", "helix_angle") > 0.0);
        assert!(moved("profile_slope", "helix_angle").abs() < 1e-9);
        let thickness = 0.5 * flank.gear.data().pressure_angle.cos();
        assert!((moved("mean", "tooth_thickness") - thickness).abs() < 1e-9);
    }
}
