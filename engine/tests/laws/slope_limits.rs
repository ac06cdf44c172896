//! Slopes are extended linearly to the evaluation length and the face width and compared with the
//! full limits; over the evaluated range they get their share of them. Tolerances of a class are
//! transverse: conformity does not depend on the direction of the figures.

use flankfit_engine::{
    estimation::{
        FitSpec, Nodes,
        spec::{Degree, Model, PolynomialBasis, Regularization, Terms},
    },
    gear::{
        Gear, Kind, ProfileAxis, Side, Trace,
        evaluation::{
            Posted, ToleranceLimits, evaluate,
            flank_surface::{
                Border, FigureTerms, FittedFlank, FlankNodes, FlankSurface, Reference, SurfaceSettings, figure_limits,
                flank_surface,
            },
            settings::{HelixSettings, ProfileSettings, Settings},
        },
        tolerance::{Characteristic, Tolerances},
        trace::Direction,
    },
};

use super::{
    gear_evaluation::{gear, near},
    gear_evaluation_surface::{AS_FITTED, settings_of},
};
use crate::problems::fit;

const ROLL: [f64; 2] = [18.0, 26.0];
/// Face width of the gear, mm.
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

const EXTENDED: FigureTerms = FigureTerms { reference: Reference::Length, ..AS_FITTED };

type Slope = (f64, Option<[f64; 2]>);

/// Slopes of profile and helix with their limits: of a flank surface and of a fitted flank.
fn slopes(gear: &Gear, z: [f64; 2], limits: ToleranceLimits, terms: FigureTerms) -> [[Slope; 2]; 2] {
    let of_nodes = surface(gear, z, &SurfaceSettings { terms, ..settings_of(spec(), limits) });
    let side = Side::Left;
    // the same heights are transverse there and along the normal here
    let height = gear.base_helix_angle().cos();
    let flank = FittedFlank { gear, side, u: 1.0, v: 1.0, height, terms, roll_lengths: ROLL, z };
    let nodes = Nodes::grid(along(ROLL, 9), along(z, 7), heights(9, 7), None, None).expect("sound");
    let result = fit(&nodes, &FitSpec { sums: Some(flank.sums()), ..spec() });
    let limits = figure_limits(gear, terms, [ROLL, z], &limits);
    let fitted = flank.figures(result.sums.as_deref().expect("asked"), limits, result.doubts());
    let [profile, helix] = [fitted.profile_slope, fitted.helix_slope].map(|slope| slope.expect("determined"));
    [[of_nodes.profile_slope, of_nodes.helix_slope], [profile, helix]]
        .map(|pair| pair.map(|slope| (slope.value, slope.limits)))
}

/// Slopes of the surface through traces with their limits, and the slope of the helices alone.
fn slopes_of_traces(gear: &Gear, z: [f64; 2], limits: ToleranceLimits) -> ([Slope; 2], f64) {
    let side = Side::Left;
    let trace = |kind, section: f64| {
        let at = along(if kind == Kind::Profile { ROLL } else { z }, 200);
        let deviation = (0..200).map(|k| 0.02 * f64::from(k)).collect();
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
    let figures = evaluated.surfaces[0].figures;
    let slopes = [figures.profile_slope, figures.helix_slope].map(|slope| slope.expect("determined"));
    (slopes.map(|slope| (slope.value, slope.limits)), evaluated.traces[0].values.expect("evaluated").slope_um)
}

#[track_caller]
fn alike(found: Option<[f64; 2]>, want: [f64; 2]) {
    let found = found.expect("there are limits");
    near(found[0], want[0], 1e-9);
    near(found[1], want[1], 1e-9);
}

#[test]
fn slopes_are_extended_to_the_whole_or_have_their_share_of_the_limits() {
    let gear = gear();
    let (profile, helix) = ([-5.0, 7.0], [2.0, 10.0]);
    let limits = ToleranceLimits { profile_slope_um: Some(profile), helix_slope_um: Some(helix), ..Default::default() };
    let class = ToleranceLimits { class: Some(5), ..Default::default() };
    let tolerances = Tolerances::new(&gear).expect("within the scope");
    let of = |characteristic| tolerances.rounded(characteristic, 5).expect("class 5");
    let (f_h_alpha, f_h_beta) = (of(Characteristic::ProfileSlope), of(Characteristic::HelixSlope));
    // the last two extend over the face
    for z in [[1.0, 19.0], [5.0, 10.0], [0.0, 20.0], [-4.0, 26.0], [0.0, 20.5]] {
        let factor = FACE_WIDTH / (z[1] - z[0]);
        let share = (1.0 / factor).min(1.0);
        let (evaluated, extended) = (slopes(&gear, z, limits, AS_FITTED), slopes(&gear, z, limits, EXTENDED));
        for (evaluated, extended) in evaluated.into_iter().zip(extended) {
            alike(evaluated[0].1, profile);
            alike(evaluated[1].1, helix.map(|end| share * end));
            near(extended[0].0, evaluated[0].0, 1e-9);
            near(extended[1].0, factor * evaluated[1].0, 1e-9);
            alike(extended[0].1, profile);
            alike(extended[1].1, helix);
        }
        for [of_profile, of_helix] in slopes(&gear, z, class, EXTENDED) {
            alike(of_profile.1, [-f_h_alpha, f_h_alpha]);
            alike(of_helix.1, [-f_h_beta, f_h_beta]);
        }
        // helices with the same slope at two diameters: the surface has that slope too
        let ([_, of_traces], of_each) = slopes_of_traces(&gear, z, limits);
        near(of_traces.0, of_each, 1e-6);
        alike(of_traces.1, helix);
    }
}

/// A border leaves a shorter profile, whose slope is extended to the evaluation range. Without a
/// face width, helix slopes refer to the evaluated length.
#[test]
fn borders_and_a_missing_face_width() {
    let limits = ToleranceLimits {
        profile_slope_um: Some([-5.0, 5.0]),
        helix_slope_um: Some([-6.0, 6.0]),
        ..Default::default()
    };
    let border = Border { root: 12.5, tip: 12.5, toe: 0.0, heel: 0.0 };
    let settings = SurfaceSettings { border, ..settings_of(spec(), limits) };
    let evaluated = surface(&gear(), [1.0, 19.0], &settings);
    alike(evaluated.profile_slope.limits, [-3.75, 3.75]);
    let extended = surface(&gear(), [1.0, 19.0], &SurfaceSettings { terms: EXTENDED, ..settings });
    alike(extended.profile_slope.limits, [-5.0, 5.0]);
    near(extended.profile_slope.value, evaluated.profile_slope.value / 0.75, 1e-9);
    near(extended.profile_crowning.value, evaluated.profile_crowning.value, 1e-12);
    let references = [extended.profile_reference_length_mm, extended.helix_reference_length_mm];
    assert_eq!(references, [ROLL[1] - ROLL[0], FACE_WIDTH]);
    let open = Gear::new(flankfit_engine::gear::GearData { face_width: None, ..super::gear_evaluation::data() });
    let open = open.expect("it exists");
    for terms in [AS_FITTED, EXTENDED] {
        let [found, _] = slopes(&open, [1.0, 19.0], limits, terms);
        alike(found[1].1, [-6.0, 6.0]);
    }
}

/// Deviations along the normal are smaller by cos β_b. Figures count in the requested direction,
/// with limits in the same direction; tolerances of a class are converted, so that a figure has the
/// same share of them in either.
#[test]
fn figures_refer_to_the_requested_direction() {
    let gear = gear();
    // sin β_b = sin β cos α_n
    let scale = (15f64.to_radians().sin() * 20f64.to_radians().cos()).asin().cos();
    let limits =
        ToleranceLimits { class: Some(6), profile_crowning_um: Some([1.0, 4.0]), ..ToleranceLimits::default() };
    let settings = settings_of(spec(), limits);
    let given = |direction| SurfaceSettings { direction, ..settings.clone() };
    let asked = |direction| SurfaceSettings { terms: FigureTerms { direction, ..AS_FITTED }, ..settings.clone() };
    let of = |settings: &SurfaceSettings| surface(&gear, [1.0, 19.0], settings);
    let transverse = of(&settings);
    let figures = |of: &FlankSurface| {
        [of.mean, of.profile_slope, of.helix_slope, of.profile_crowning, of.helix_crowning, of.twist]
    };
    for (other, factor) in [(of(&given(Direction::Normal)), 1.0 / scale), (of(&asked(Direction::Normal)), scale)] {
        for (other, transverse) in figures(&other).into_iter().zip(figures(&transverse)) {
            near(other.value, factor * transverse.value, 1e-9);
            near(other.std_error.expect("known"), factor * transverse.std_error.expect("known"), 1e-9);
        }
        near(other.form.peak_to_valley_um, factor * transverse.form.peak_to_valley_um, 1e-9);
        assert_eq!(other.result.residuals.rms, transverse.result.residuals.rms);
    }
    let normal = of(&asked(Direction::Normal));
    let share = |figure: flankfit_engine::gear::evaluation::flank_surface::Figure| {
        figure.value / figure.limits.expect("there are limits")[1]
    };
    near(share(normal.profile_slope), share(transverse.profile_slope), 1e-9);
    near(share(normal.helix_slope), share(transverse.helix_slope), 1e-9);
    assert_eq!(normal.profile_crowning.limits, Some([1.0, 4.0]));
}
