//! Laws of the evaluation of traces: which sign a slope has, and what length it is extended to.

use flankfit_engine::gear::{
    Gear, GearData, Hand, Kind, Side,
    evaluation::settings::{
        DeviationSign, HelixReference, HelixSettings, ProfileReference, ProfileSettings, Settings, SlopeSign,
    },
    involute::Flank,
    trace::Direction,
};

use super::gear_evaluation::{KINDS, SIDES, data, gear, near, one, range, settings, trace};

#[test]
fn signs_are_those_documented() {
    let gear = gear();
    for given in [DeviationSign::Material, DeviationSign::Din, DeviationSign::Clockwise] {
        for kind in KINDS {
            for side in SIDES {
                let rising = trace(&gear, kind, side, 50, |u| u - 3.0 * u * u);
                let slope = |sign| one(&gear, &rising, &Settings { given, sign, ..settings() }).slope_um.signum();
                let side_sign = side.sign();
                // what the flank does, as seen by material
                let material = match given {
                    DeviationSign::Material => 1.0,
                    DeviationSign::Din if kind == Kind::Profile => 1.0,
                    DeviationSign::Din => side_sign,
                    DeviationSign::Clockwise => -side_sign,
                };
                assert_eq!(slope(SlopeSign::AsGiven), 1.0);
                assert_eq!(slope(SlopeSign::Vdi), material);
                let din = if kind == Kind::Profile { material } else { side_sign * material };
                assert_eq!(slope(SlopeSign::Din), din);
                let crowning = one(&gear, &rising, &Settings { given, ..settings() }).crowning_um;
                near(crowning, 3.0 * material, 1e-9);
            }
        }
    }
}

/// A flank turned towards the right hand is positive by DIN: points of the helicoid of a gear with
/// a little more helix angle.
#[test]
fn a_right_hand_deviation_is_positive_on_both_flanks() {
    for hand in [Hand::Right, Hand::Left] {
        let nominal = Gear::new(GearData { hand, ..data() }).expect("the gear exists");
        let steeper = GearData { hand, helix_angle: data().helix_angle + 1e-5, ..data() };
        let steeper = Gear::new(steeper).expect("the gear exists");
        for side in SIDES {
            let (flank, real) = (Flank::new(&nominal, side), Flank::new(&steeper, side));
            let roll = nominal.roll_length(104.0).expect("above the base circle");
            let mut helix = trace(&nominal, Kind::Helix, side, 40, |_| 0.0);
            for (z, deviation) in helix.at.iter().zip(&mut helix.deviation) {
                let place = flank.at(roll, *z);
                let step = real.at(roll, *z).point - place.point;
                *deviation = 1e3 * step.dot(&place.normal);
            }
            let direction = Direction::Normal;
            let values = one(&nominal, &helix, &Settings { direction, ..settings() });
            let right = if hand == Hand::Right { 1.0 } else { -1.0 };
            // Δβ seen over the face width on this cylinder
            assert!(right * values.slope_um > 0.05 && right * values.slope_um < 0.5, "{hand:?} {side:?} {values:?}");
        }
    }
}

#[test]
fn reversed_face_width_turns_the_helix_slope() {
    let gear = gear();
    for side in SIDES {
        let helix = trace(&gear, Kind::Helix, side, 60, |u| 4.0 * u + (5.0 * u).cos());
        let mut turned = helix.clone();
        turned.at.iter_mut().for_each(|z| *z = 20.0 - *z);
        let (a, b) = (one(&gear, &helix, &settings()), one(&gear, &turned, &settings()));
        near(b.slope_um, -a.slope_um, 1e-9);
        near(b.form_um, a.form_um, 1e-9);
        near(b.crowning_um, a.crowning_um, 1e-9);
    }
}

#[test]
fn reference_lengths_extend_the_slope() {
    let gear = gear();
    let helix = trace(&gear, Kind::Helix, Side::Left, 50, |u| 9.0 * u);
    let slope = |reference, reference_length| {
        let helix_settings = Some(HelixSettings { reference, reference_length, ..HelixSettings::on([1.0, 19.0]) });
        one(&gear, &helix, &Settings { helix: helix_settings, ..settings() }).slope_um
    };
    near(slope(HelixReference::EvaluationRange, None), 18.0, 1e-9);
    near(slope(HelixReference::FaceWidth, None), 20.0, 1e-9);
    near(slope(HelixReference::FaceWidth, Some(36.0)), 36.0, 1e-9);

    let [low, high] = range(&gear, Kind::Profile);
    let profile = trace(&gear, Kind::Profile, Side::Right, 50, |u| 9.0 * u);
    let slope = |reference, reference_length| {
        let asked = ProfileSettings { reference, reference_length, ..ProfileSettings::on([101.0, 107.0]) };
        one(&gear, &profile, &Settings { profile: Some(asked), ..settings() }).slope_um
    };
    near(slope(ProfileReference::EvaluationRange, None), 18.0, 1e-9);
    let tip = gear.roll_length(2.0 * gear.tip_radius()).expect("above the base circle");
    near(slope(ProfileReference::ToTip, None), 18.0 * (tip - low) / (high - low), 1e-9);
    near(slope(ProfileReference::ToTip, Some(1.0)), 18.0 / (high - low), 1e-9);
    // along the normal everything is cos β_b smaller
    let normal = Settings { direction: Direction::Normal, ..settings() };
    near(
        one(&gear, &profile, &normal).total_um * gear.base_helix_angle().cos(),
        one(&gear, &profile, &settings()).total_um,
        1e-9,
    );
}

/// On an internal gear the tip lies at smaller roll lengths.
#[test]
fn an_internal_profile_rises_towards_its_tip() {
    let data = GearData { internal: true, profile_shift: 0.0, ..data() };
    let gear = Gear::new(data).expect("the gear exists");
    let asked = Some(ProfileSettings::on([101.0, 106.0]));
    let low = gear.roll_length(101.0).expect("above the base circle");
    let mut profile = trace(&gear, Kind::Profile, Side::Left, 50, |_| 0.0);
    profile.deviation = profile.at.iter().map(|l| low - l).collect();
    let values = one(&gear, &profile, &Settings { profile: asked, ..settings() });
    assert!(values.slope_um > 0.0, "{values:?}");
}
