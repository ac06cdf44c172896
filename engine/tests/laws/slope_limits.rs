//! Limits of slopes are of the whole evaluation length and of the whole face width: whoever
//! evaluates a range of it holds the slope against the same share of them. And they are transverse.

use flankfit_engine::{
    estimation::{
        FitSpec, Nodes,
        spec::{Degree, Model, PolynomialBasis, Regularization, Terms},
    },
    gear::{
        Gear, Kind, ProfileAxis, Side, Trace,
        evaluation::{
            Posted, ToleranceLimits, evaluate,
            flank_surface::{Border, FittedFlank, FlankNodes, FlankSurface, SurfaceSettings, flank_surface},
            settings::{HelixSettings, ProfileSettings, Settings},
        },
        tolerance::{Characteristic, Tolerances},
        trace::Direction,
    },
};

use super::{
    gear_evaluation::{gear, near},
    gear_evaluation_surface::settings_of,
};
use crate::problems::fit;

const ROLL: [f64; 2] = [18.0, 26.0];
/// Of the gear.
const FACE_WIDTH: f64 = 20.0;

fn spec() -> FitSpec {
    let model = Model::Polynomial { degree: Degree::Both(2), basis: PolynomialBasis::Monomial, terms: Terms::Total };
    FitSpec { regularization: Regularization::None, ..FitSpec::new(model) }
}

fn along([low, high]: [f64; 2], count: usize) -> Vec<f64> {
    (0..count).map(|k| low + (high - low) * k as f64 / (count - 1) as f64).collect()
}

/// Profile slope 4, helix slope 3 over the range, and something that is left over.
fn heights(rows: usize, columns: usize) -> Vec<f64> {
    let (u, v) = (along([-1.0, 1.0], rows), along([-1.0, 1.0], columns));
    let height = |u: &f64, v: &f64| 2.0 * u + 1.5 * v + 0.1 * (9.0 * u + 5.0 * v).sin();
    u.iter().flat_map(|u| v.iter().map(move |v| height(u, v))).collect()
}

fn surface(gear: &Gear, z: [f64; 2], settings: &SurfaceSettings) -> FlankSurface {
    let (profile, z, deviation) = (along(ROLL, 9), along(z, 7), heights(9, 7));
    let axis = ProfileAxis::RollLength;
    let nodes = FlankNodes { axis, profile: &profile, z: &z, deviation: &deviation, valid: None, grid: true };
    flank_surface(gear, &nodes, settings).expect("the nodes are sound")
}

type Limits = Option<[f64; 2]>;

/// Limits of the slopes of profile and helix: of a flank surface, of a fitted flank, of the surface
/// of traces.
fn held(gear: &Gear, z: [f64; 2], limits: ToleranceLimits) -> [[Limits; 2]; 3] {
    let of_nodes = surface(gear, z, &settings_of(spec(), limits));
    let (side, axis) = (Side::Left, ProfileAxis::RollLength);
    let flank = FittedFlank { gear, side, axis, u: 1.0, v: 1.0, height: 1.0, roll_lengths: ROLL, z };
    let nodes = Nodes::grid(along(ROLL, 9), along(z, 7), heights(9, 7), None, None).expect("sound");
    let result = fit(&nodes, &FitSpec { sums: Some(flank.sums()), ..spec() });
    let fitted = flank.figures(result.sums.as_deref().expect("asked"), &limits);
    let trace = |kind, section: f64| {
        let at = along(if kind == Kind::Profile { ROLL } else { z }, 200);
        let deviation = (0..200).map(|k| 0.02 * f64::from(k) + 0.1 * f64::from(k % 7)).collect();
        Trace { tooth: "1".into(), side, kind, at, section: Some(section), deviation }
    };
    let diameter = |share: f64| gear.diameter(ROLL[0] + share * (ROLL[1] - ROLL[0]));
    let traces = [
        trace(Kind::Helix, diameter(0.2)),
        trace(Kind::Helix, diameter(0.8)),
        trace(Kind::Profile, 0.5 * (z[0] + z[1])),
    ];
    let settings = Settings {
        profile: Some(ProfileSettings::on([diameter(0.0), diameter(1.0)])),
        helix: Some(HelixSettings::on(z)),
        limits: limits.into(),
        ..Settings::default()
    };
    let posted: Vec<Posted> = traces.iter().map(|trace| Posted { trace, design: None }).collect();
    let evaluated = evaluate(gear, &posted, &settings).expect("the traces are sound");
    let of_traces = evaluated.surfaces[0].figures;
    [
        [of_nodes.profile_slope.limits, of_nodes.helix_slope.limits],
        [fitted.profile_slope.expect("told").limits, fitted.helix_slope.expect("told").limits],
        [of_traces.profile_slope.expect("told").limits, of_traces.helix_slope.expect("told").limits],
    ]
}

#[track_caller]
fn alike(found: Limits, want: [f64; 2]) {
    let found = found.expect("there are limits");
    near(found[0], want[0], 1e-9);
    near(found[1], want[1], 1e-9);
}

#[test]
fn slopes_have_their_share_of_the_limits_and_never_more_than_the_whole() {
    let gear = gear();
    let (profile, helix) = ([-5.0, 7.0], [2.0, 10.0]);
    let told = ToleranceLimits { profile_slope: Some(profile), helix_slope: Some(helix), ..Default::default() };
    let class = ToleranceLimits { class: Some(5), ..Default::default() };
    let tolerances = Tolerances::new(&gear).expect("within the scope");
    let of = |characteristic| tolerances.rounded(characteristic, 5).expect("class 5");
    let (f_h_alpha, f_h_beta) = (of(Characteristic::ProfileSlope), of(Characteristic::HelixSlope));
    // the last two extend beyond the face
    for z in [[1.0, 19.0], [5.0, 10.0], [0.0, 20.0], [-4.0, 26.0], [0.0, 20.5]] {
        let share = ((z[1] - z[0]) / FACE_WIDTH).min(1.0);
        for [of_profile, of_helix] in held(&gear, z, told) {
            alike(of_profile, profile);
            alike(of_helix, helix.map(|end| share * end));
        }
        for [of_profile, of_helix] in held(&gear, z, class) {
            alike(of_profile, [-f_h_alpha, f_h_alpha]);
            alike(of_helix, [-share * f_h_beta, share * f_h_beta]);
        }
    }
}

/// What a border leaves of the profile has its share; a gear without a face width has the whole.
#[test]
fn borders_leave_shares_and_a_gear_without_width_has_the_whole() {
    let told =
        ToleranceLimits { profile_slope: Some([-5.0, 5.0]), helix_slope: Some([-6.0, 6.0]), ..Default::default() };
    let border = Border { root: 12.5, tip: 12.5, toe: 0.0, heel: 0.0 };
    let cut = surface(&gear(), [1.0, 19.0], &SurfaceSettings { border, ..settings_of(spec(), told) });
    alike(cut.profile_slope.limits, [-3.75, 3.75]);
    let open = Gear::new(flankfit_engine::gear::GearData { face_width: None, ..super::gear_evaluation::data() });
    let open = surface(&open.expect("it exists"), [1.0, 19.0], &settings_of(spec(), told));
    alike(open.helix_slope.limits, [-6.0, 6.0]);
}

/// Deviations along the normal are smaller by cos β_b; figures and form are transverse, the fit is
/// of what was given.
#[test]
fn figures_are_transverse_along_whatever_deviations_are() {
    let gear = gear();
    // sin β_b = sin β cos α_n
    let base_helix_angle = (15f64.to_radians().sin() * 20f64.to_radians().cos()).asin();
    let told = ToleranceLimits { profile_slope: Some([-4.1, 4.1]), ..Default::default() };
    let settings = settings_of(spec(), told);
    let transverse = surface(&gear, [1.0, 19.0], &settings);
    let normal = surface(&gear, [1.0, 19.0], &SurfaceSettings { direction: Direction::Normal, ..settings });
    let scale = 1.0 / base_helix_angle.cos();
    for (normal, transverse) in [
        (normal.mean, transverse.mean),
        (normal.profile_slope, transverse.profile_slope),
        (normal.helix_slope, transverse.helix_slope),
        (normal.profile_crowning, transverse.profile_crowning),
        (normal.helix_crowning, transverse.helix_crowning),
        (normal.twist, transverse.twist),
    ] {
        near(normal.value, scale * transverse.value, 1e-9);
        near(normal.std_error.expect("told"), scale * transverse.std_error.expect("told"), 1e-9);
        assert_eq!(normal.limits, transverse.limits);
    }
    near(normal.remainder.peak_to_valley, scale * transverse.remainder.peak_to_valley, 1e-9);
    assert_eq!(normal.result.residuals.rms, transverse.result.residuals.rms);
}
