//! Laws of the second-order flank surface.

use flankfit_engine::{
    estimation::{
        FitError, FitSpec,
        spec::{Degree, Model, PolynomialBasis, Regularization, Terms},
    },
    gear::{
        Gear, GearData, ProfileAxis, Side,
        evaluation::{
            ToleranceLimits,
            flank_surface::{
                Border, FigureTerms, FlankNodes, FlankSurface, Reference, SurfaceSettings, flank_figures, flank_surface,
            },
            settings::{DeviationSign, SlopeSign},
            warning::SurfaceWarning,
        },
        trace::Direction,
    },
};
use proptest::prelude::*;

use super::gear_evaluation::{data, gear};

/// The model is not looked at.
fn plain() -> FitSpec {
    let model = Model::Polynomial { degree: Degree::Both(1), basis: PolynomialBasis::Legendre, terms: Terms::Tensor };
    FitSpec { regularization: Regularization::None, ..FitSpec::new(model) }
}

/// Transverse figures over the fitted range, without conversion.
pub const AS_FITTED: FigureTerms = FigureTerms { direction: Direction::Transverse, reference: Reference::Evaluated };

/// Settings of the left flank, not trimmed, deviations as material.
pub fn settings_of(spec: FitSpec, limits: ToleranceLimits) -> SurfaceSettings {
    SurfaceSettings {
        side: Side::Left,
        profile_range: None,
        helix_range: None,
        border: Border::default(),
        given: DeviationSign::Material,
        direction: Direction::Transverse,
        terms: AS_FITTED,
        sign: SlopeSign::AsGiven,
        limits,
        spec,
    }
}

fn settings() -> SurfaceSettings {
    settings_of(plain(), ToleranceLimits::default())
}

/// Nodes of a grid over a flank, deviation as a function of u, v in [-1, 1].
struct Grid {
    profile: Vec<f64>,
    z: Vec<f64>,
    deviation: Vec<f64>,
}

const ROLL: [f64; 2] = [18.0, 26.0];
const Z: [f64; 2] = [1.0, 19.0];

fn at(range: [f64; 2], t: f64) -> f64 {
    0.5 * (range[0] + range[1]) + 0.5 * (range[1] - range[0]) * t
}

fn grid(rows: usize, columns: usize, deviation: impl Fn(f64, f64) -> f64) -> Grid {
    let t = |i: usize, n: usize| 2.0 * i as f64 / (n - 1) as f64 - 1.0;
    Grid {
        profile: (0..rows).map(|i| at(ROLL, t(i, rows))).collect(),
        z: (0..columns).map(|j| at(Z, t(j, columns))).collect(),
        deviation: (0..rows * columns).map(|k| deviation(t(k / columns, rows), t(k % columns, columns))).collect(),
    }
}

impl Grid {
    fn nodes(&self) -> FlankNodes<'_> {
        FlankNodes {
            axis: ProfileAxis::RollLength,
            profile: &self.profile,
            z: &self.z,
            deviation: &self.deviation,
            valid: None,
            grid: true,
        }
    }
}

fn fitted(gear: &Gear, nodes: &FlankNodes, settings: &SurfaceSettings) -> FlankSurface {
    flank_surface(gear, nodes, settings).expect("the nodes are sound")
}

fn figures(surface: &FlankSurface) -> [f64; 6] {
    [
        surface.mean,
        surface.profile_slope,
        surface.helix_slope,
        surface.profile_crowning,
        surface.helix_crowning,
        surface.twist,
    ]
    .map(|figure| figure.value)
}

fn near(value: f64, want: f64, within: f64) {
    assert!((value - want).abs() <= within, "{value} is not {want}");
}

fn second_order(put: [f64; 6]) -> impl Fn(f64, f64) -> f64 {
    let [mean, profile, helix, profile_crowning, helix_crowning, twist] = put;
    move |u, v| {
        mean + 0.5 * profile * u + 0.5 * helix * v - profile_crowning * u * u - helix_crowning * v * v
            + 0.25 * twist * u * v
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Given deviations come back from grids, from grids with gaps and from scattered nodes.
    #[test]
    fn second_order_deviations_come_back(
        put in prop::array::uniform6(-20.0..20.0f64), rows in 4usize..12, columns in 4usize..16, gap in 0usize..1000,
    ) {
        let gear = gear();
        let full = grid(rows, columns, second_order(put));
        let mut holed = grid(rows, columns, second_order(put));
        holed.deviation[gap % (rows * columns)] = f64::NAN;
        let mut valid = vec![true; rows * columns];
        valid[(gap / 7) % (rows * columns)] = false;
        holed.deviation[(gap / 7) % (rows * columns)] = 1e3;
        let ranges = SurfaceSettings { profile_range: Some(ROLL), helix_range: Some(Z), ..settings() };
        let holes = FlankNodes { valid: Some(&valid), ..holed.nodes() };
        let profile: Vec<f64> = (0..rows * columns).map(|k| full.profile[k / columns]).collect();
        let z: Vec<f64> = (0..rows * columns).map(|k| full.z[k % columns]).collect();
        let scattered = FlankNodes { profile: &profile, z: &z, grid: false, ..full.nodes() };
        if gap % (rows * columns) != (gap / 7) % (rows * columns) {
            prop_assert_eq!(fitted(&gear, &holes, &ranges).nodes.missing, 2);
        }
        for nodes in [full.nodes(), holes, scattered] {
            let surface = fitted(&gear, &nodes, &ranges);
            for (found, want) in figures(&surface).into_iter().zip(put) {
                near(found, want, 1e-6);
            }
            near(surface.form.peak_to_valley_um, 0.0, 1e-6);
            prop_assert_eq!(surface.nodes.posted, rows * columns);
            prop_assert_eq!(surface.nodes.used + surface.nodes.missing, rows * columns);
        }
    }

    /// Regularisation moves a figure by no more than the bound given with it, and reports the value
    /// without regularisation.
    #[test]
    fn bias_stays_within_its_bound(put in prop::array::uniform6(-20.0..20.0f64), k in 1e-4..1.0f64) {
        use flankfit_engine::estimation::spec::Parameter;
        let gear = gear();
        let noisy = grid(6, 9, |u, v| second_order(put)(u, v) + (37.0 * u + 91.0 * v).sin());
        let spec = FitSpec { regularization: Regularization::Ridge { parameter: Parameter::Fixed(k) }, ..plain() };
        let surface = fitted(&gear, &noisy.nodes(), &SurfaceSettings { spec, ..settings() });
        for figure in [surface.mean, surface.profile_slope, surface.helix_slope, surface.profile_crowning,
            surface.helix_crowning, surface.twist] {
            prop_assert!((figure.value - figure.least_squares).abs() <= figure.bias_bound * (1.0 + 1e-9), "{:?}",
                figure);
            prop_assert!(figure.std_error.is_some_and(|e| e > 0.0));
        }
        prop_assert!(surface.form.peak_to_valley_um <= 2.0 * surface.form.max_abs_um + 1e-12);
        prop_assert!(surface.form.rms_um <= surface.form.max_abs_um);
    }
}

#[test]
fn trimming_cuts_the_range_and_its_figures() {
    let gear = gear();
    let put = [1.0, 10.0, 8.0, 4.0, 6.0, 12.0];
    let full = grid(41, 41, second_order(put));
    // a quarter of the range at every side leaves u, v in [-1/2, 1/2]
    let border = Border { root: 25.0, tip: 25.0, toe: 25.0, heel: 25.0 };
    let surface = fitted(&gear, &full.nodes(), &SurfaceSettings { border, ..settings() });
    for (found, want) in figures(&surface).into_iter().zip([1.0, 5.0, 4.0, 1.0, 1.5, 3.0]) {
        near(found, want, 1e-6);
    }
    near(surface.roll_length_range_mm[0], 20.0, 1e-12);
    near(surface.z_range_mm[1], 14.5, 1e-12);
    assert_eq!((surface.nodes.used, surface.nodes.trimmed), (21 * 21, 41 * 41 - 21 * 21));
    // only the tip's border
    let border = Border { tip: 50.0, ..Border::default() };
    let surface = fitted(&gear, &full.nodes(), &SurfaceSettings { border, ..settings() });
    near(surface.roll_length_range_mm[0], 18.0, 1e-12);
    near(surface.roll_length_range_mm[1], 22.0, 1e-12);
}

#[test]
fn signs_follow_flank_and_convention() {
    let gear = gear();
    let put = [1.0, 10.0, 8.0, 4.0, 6.0, 12.0];
    let full = grid(7, 9, second_order(put));
    for side in [Side::Left, Side::Right] {
        let of = |sign| figures(&fitted(&gear, &full.nodes(), &SurfaceSettings { side, sign, ..settings() }));
        assert_eq!(of(SlopeSign::Vdi), of(SlopeSign::AsGiven));
        let (vdi, din) = (of(SlopeSign::Vdi), of(SlopeSign::Din));
        let hand = side.sign();
        for k in 0..6 {
            near(din[k], if k == 2 || k == 5 { hand * vdi[k] } else { vdi[k] }, 1e-12);
        }
        // numbers that count clockwise: heights and crownings turn on the left flank
        let given = DeviationSign::Clockwise;
        let turned = fitted(&gear, &full.nodes(), &SurfaceSettings { side, given, sign: SlopeSign::Vdi, ..settings() });
        for (a, b) in figures(&turned).into_iter().zip(vdi) {
            near(a, -hand * b, 1e-9);
        }
    }
}

/// The tip of an internal gear lies at the smaller diameters; a grid by diameter is a grid by roll
/// length.
#[test]
fn internal_gears_and_diameters() {
    let internal = Gear::new(GearData { internal: true, profile_shift: 0.0, ..data() }).expect("the gear exists");
    let put = [1.0, 10.0, 8.0, 4.0, 6.0, 12.0];
    let full = grid(6, 5, |t, v| second_order(put)(-t, v));
    let diameters: Vec<f64> = full.profile.iter().map(|&l| internal.diameter(l)).collect();
    let by_diameter = FlankNodes { axis: ProfileAxis::Diameter, profile: &diameters, ..full.nodes() };
    for nodes in [full.nodes(), by_diameter] {
        for (found, want) in figures(&fitted(&internal, &nodes, &settings())).into_iter().zip(put) {
            near(found, want, 1e-6);
        }
    }
    let border = Border { tip: 40.0, ..Border::default() };
    let cut = fitted(&internal, &full.nodes(), &SurfaceSettings { border, ..settings() });
    near(cut.roll_length_range_mm[0], 21.2, 1e-9);
}

#[test]
fn impossible_requests_name_their_place() {
    let gear = gear();
    let full = grid(6, 5, |_, _| 0.0);
    let places = |nodes: &FlankNodes, settings: &SurfaceSettings| -> Vec<String> {
        match flank_surface(&gear, nodes, settings).expect_err("impossible") {
            FitError::Invalid(faults) => faults.list().iter().map(|fault| fault.path.clone()).collect(),
            other => panic!("{other}"),
        }
    };
    let border = Border { root: 60.0, tip: 40.0, toe: -1.0, heel: f64::NAN };
    assert_eq!(
        places(&full.nodes(), &SurfaceSettings { border, ..settings() }),
        ["border_percent.toe", "border_percent.heel", "border_percent"]
    );
    assert_eq!(places(&FlankNodes { z: &full.z[..4], ..full.nodes() }, &settings()), ["deviation_um"]);
    let by_diameter = FlankNodes { axis: ProfileAxis::Diameter, ..full.nodes() };
    assert_eq!(places(&by_diameter, &settings())[0], "profile[0]");
    let mut turned = full.profile.clone();
    turned.swap(0, 1);
    assert_eq!(places(&FlankNodes { profile: &turned, ..full.nodes() }, &settings()), ["profile[1]"]);
    let nothing = vec![f64::NAN; 30];
    assert_eq!(places(&FlankNodes { deviation: &nothing, ..full.nodes() }, &settings()), ["deviation_um"]);
    // figures of a range that the nodes reach half of would be extrapolated
    let [least, most] = [full.profile[0], full.profile[5]];
    let wider = SurfaceSettings { profile_range: Some([least, 2.0 * most - least]), ..settings() };
    assert_eq!(places(&full.nodes(), &wider), ["profile_range"]);
    let longer = SurfaceSettings { helix_range: Some([full.z[0] - 20.0, full.z[4]]), ..settings() };
    assert_eq!(places(&full.nodes(), &longer), ["helix_range_mm"]);
    let beside = SurfaceSettings { helix_range: Some([30.0, 40.0]), ..settings() };
    assert_eq!(places(&full.nodes(), &beside), ["border_percent"]);
}

/// A border that cuts the outermost nodes off leaves a range that the others reach little of: its
/// figures are returned, but not compared with limits, with the share in a warning.
#[test]
fn uncovered_ranges_are_not_compared_with_limits() {
    let gear = gear();
    let full = grid(5, 9, second_order([0.0, 1.0, 1.0, 1.0, 1.0, 0.0]));
    let wide = Some([-90.0, 90.0]);
    let limits = ToleranceLimits {
        profile_slope_um: wide,
        helix_slope_um: wide,
        profile_crowning_um: wide,
        helix_crowning_um: wide,
        twist_um: wide,
        ..ToleranceLimits::default()
    };
    let cut = |root: f64, toe: f64| {
        let border = Border { root, tip: root, toe, heel: toe };
        let found = fitted(&gear, &full.nodes(), &SurfaceSettings { border, ..settings_of(plain(), limits) });
        let held = [found.profile_slope, found.profile_crowning, found.helix_slope, found.helix_crowning, found.twist]
            .map(|figure| figure.limits.is_some());
        (held, found.warnings)
    };
    assert_eq!(cut(0.0, 0.0), ([true; 5], vec![]));
    // 3 of 5 rows are left: 0.5 of 0.9; of 9 columns 7: 0.75 of 0.9
    let (held, warnings) = cut(5.0, 5.0);
    assert_eq!(held, [false, false, true, true, false]);
    let [SurfaceWarning::RangeNotCovered { path: "border_percent", covered, .. }] = warnings[..] else {
        panic!("{warnings:?}")
    };
    near(covered, 0.5 / 0.9, 1e-9);
    assert!(warnings[0].to_string().contains("55.6 % of the range"), "{}", warnings[0]);
    // a border at the nodes
    assert_eq!(cut(25.0, 12.5), ([true; 5], vec![]));
}

/// Lengths that no gear has are errors at their field, and those outside the face have a warning.
#[test]
fn places_outside_the_face_are_warned_of_or_refused() {
    let gear = gear();
    let width = gear.data().face_width.unwrap();
    let mut far = grid(5, 9, |_, _| 0.0);
    far.z[8] = far.z[0] + 1.04 * width;
    assert_eq!(fitted(&gear, &far.nodes(), &settings()).warnings, vec![]);
    far.z[8] = far.z[0] + 2.0 * width;
    let warnings = fitted(&gear, &far.nodes(), &settings()).warnings;
    assert!(matches!(warnings[..], [SurfaceWarning::OutsideFace { .. }]), "{warnings:?}");
    far.z[8] = 1e30;
    match flank_surface(&gear, &far.nodes(), &settings()).expect_err("no gear is so wide") {
        FitError::Invalid(faults) => {
            let paths: Vec<&str> = faults.list().iter().map(|fault| &*fault.path).collect();
            assert_eq!(paths, ["z_mm[8]"]);
        }
        other => panic!("{other}"),
    }
}

/// Figures by name are those of the surface. A cross of a profile and a helix determines all but
/// the twist, wherever they cross; one trace determines nothing, and regularisation does not
/// matter.
#[test]
fn figures_are_given_where_the_nodes_determine_them() {
    let gear = gear();
    let put = [3.0, -8.0, 5.0, 4.0, -6.0, 7.0];
    let spec = FitSpec {
        regularization: Regularization::Ridge { parameter: flankfit_engine::estimation::spec::Parameter::Fixed(1.0) },
        ..plain()
    };
    let settings = SurfaceSettings { side: Side::Right, sign: SlopeSign::Din, spec, ..settings() };
    let whole = grid(5, 9, second_order(put));
    let figures = flank_figures(&gear, &whole.nodes(), &settings).unwrap();
    // on right flanks DIN turns the sign of helix slope and twist
    near(figures.profile_slope.unwrap(), -8.0, 1e-9);
    near(figures.helix_slope.unwrap(), -5.0, 1e-9);
    near(figures.profile_crowning.unwrap(), 4.0, 1e-9);
    near(figures.helix_crowning.unwrap(), -6.0, 1e-9);
    near(figures.twist.unwrap(), -7.0, 1e-9);
    for (row, column) in [(2, 4), (1, 6), (0, 4)] {
        let mut cross = grid(5, 9, second_order([3.0, -8.0, 5.0, 4.0, -6.0, 0.0]));
        for k in (0..45).filter(|k| k / 9 != row && k % 9 != column) {
            cross.deviation[k] = f64::NAN;
        }
        let figures = flank_figures(&gear, &cross.nodes(), &settings).unwrap();
        near(figures.profile_slope.unwrap(), -8.0, 1e-9);
        near(figures.helix_slope.unwrap(), -5.0, 1e-9);
        near(figures.profile_crowning.unwrap(), 4.0, 1e-9);
        near(figures.helix_crowning.unwrap(), -6.0, 1e-9);
        assert_eq!(figures.twist, None);
        let flat = FlankNodes {
            profile: &(0..45).map(|k| cross.profile[k / 9]).collect::<Vec<f64>>(),
            z: &(0..45).map(|k| cross.z[k % 9]).collect::<Vec<f64>>(),
            grid: false,
            ..cross.nodes()
        };
        near(flank_figures(&gear, &flat, &settings).unwrap().profile_slope.unwrap(), -8.0, 1e-9);
    }
    let mut lead = whole;
    lead.deviation.iter_mut().enumerate().filter(|(k, _)| k / 9 != 2).for_each(|(_, d)| *d = f64::NAN);
    assert_eq!(flank_figures(&gear, &lead.nodes(), &settings), None);
    let ranges = SurfaceSettings { profile_range: Some(ROLL), helix_range: Some(Z), ..settings };
    assert_eq!(flank_figures(&gear, &lead.nodes(), &ranges), None);
}
