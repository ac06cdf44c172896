//! Only the needed settings: how often correct ones are changed, and needed ones missed.

use flankfit_engine::gear::{
    Gear, GearData, Hand, Side,
    correction::{
        Correction, CorrectionSpec, Flank, Setting, SettingsUsed, Solution, Unchanged,
        machine::{FlankNode, Machine, Ranges},
    },
    evaluation::flank_surface::{FigureTerms, FlankFigures, Reference},
    trace::Direction,
};

use crate::oracle::random::Random;

pub const ROWS: usize = 5;
pub const COLUMNS: usize = 9;
pub const NEEDED: SettingsUsed = SettingsUsed::Needed;

pub fn helical() -> Gear {
    let data = GearData { helix_angle: 20f64.to_radians(), hand: Hand::Right, ..GearData::spur(37, 2.0) };
    Gear::new(GearData { face_width: Some(20.0), ..data }).unwrap()
}

/// A flank with 5 × 9 nodes.
pub fn flank(gear: Gear, side: Side) -> Flank {
    let ranges = Ranges { profile: [9.0, 17.0], helix: [1.0, 19.0] };
    let at = |[low, high]: [f64; 2], i: usize, n: usize| low + (high - low) * i as f64 / (n - 1) as f64;
    let place = |k: usize| FlankNode {
        side,
        roll_length: at(ranges.profile, k / COLUMNS, ROWS),
        z: at(ranges.helix, k % COLUMNS, COLUMNS),
    };
    let terms = FigureTerms { direction: Direction::Normal, reference: Reference::Evaluated };
    Flank { gear, side, places: (0..ROWS * COLUMNS).map(place).collect(), ranges, traces: None, terms }
}

/// The settings of generating grinding on one flank, without the offset of the tool, which has the
/// same effect there as the thickness: names and a matrix whose columns move the flank by 1 µm at
/// most.
pub fn six_settings(flank: &Flank) -> (Vec<Setting>, Vec<f64>) {
    let found = Machine::GeneratingGrinding.sensitivity(&flank.gear, &flank.places, flank.ranges).unwrap();
    let all = found.settings.len();
    let settings: Vec<Setting> = found.settings[..6].to_vec();
    let largest: Vec<f64> =
        (0..6).map(|j| found.matrix.chunks(all).fold(0.0f64, |most, row| most.max(row[j].abs()))).collect();
    let matrix = found.matrix.chunks(all).flat_map(|row| (0..6).map(|j| row[j] / largest[j]).collect::<Vec<_>>());
    (settings, matrix.collect())
}

fn solve(asked: CorrectionSpec) -> Solution {
    Correction::new(asked).unwrap().solve().unwrap()
}

fn median(mut list: Vec<f64>) -> f64 {
    list.sort_by(f64::total_cmp);
    list[list.len() / 2]
}

/// 2,000 flanks, at most two of six settings off by 3 to 12 µm: at least 0.97 of the corrections
/// change no setting that was correct (four to six correct settings, with a rate of 0.005 each),
/// and the corrected flank is better than with all settings.
#[test]
fn settings_that_are_right_are_left_alone() {
    let flank = flank(helical(), Side::Left);
    let (settings, matrix) = six_settings(&flank);
    let mut random = Random::new(41);
    for sigma in [0.3, 0.6] {
        let (flanks, mut clean, mut ratios) = (1000, 0, Vec::new());
        for _ in 0..flanks {
            let mut off = [0.0; 6];
            for _ in 0..random.below(3) {
                let sign = if random.unit() < 0.5 { -1.0 } else { 1.0 };
                off[random.below(6)] = sign * (3.0 + 9.0 * random.unit());
            }
            let truth: Vec<f64> =
                matrix.chunks(6).map(|row| row.iter().zip(off).map(|(j, off)| j * off).sum()).collect();
            let measured: Vec<f64> = truth.iter().map(|d| d + sigma * random.normal()).collect();
            let asked = CorrectionSpec::new(measured, matrix.clone(), settings.clone());
            let needed = solve(CorrectionSpec { used: NEEDED, ..asked.clone() });
            let touched = needed.settings.iter().zip(off).any(|(setting, off)| off == 0.0 && setting.change != 0.0);
            clean += usize::from(!touched);
            for (setting, off) in needed.settings.iter().zip(off) {
                assert!(off == 0.0 || setting.change * off < 0.0, "a setting that is off is missed");
                assert_eq!(setting.unchanged.is_some(), setting.change == 0.0);
            }
            let rms = |solution: &Solution| {
                let left = |(row, d): (&[f64], &f64)| {
                    d + row.iter().zip(&solution.settings).map(|(j, s)| j * s.change).sum::<f64>()
                };
                let square: f64 = matrix.chunks(6).zip(&truth).map(left).map(|d| d * d).sum();
                (square / truth.len() as f64).sqrt()
            };
            ratios.push(rms(&needed) / rms(&solve(asked)));
        }
        let share = clean as f64 / f64::from(flanks);
        assert!(share >= 0.97, "σ {sigma}: {share}");
        let ratio = median(ratios);
        assert!(ratio <= 0.6, "σ {sigma}: {ratio}");
    }
}

/// Crownings in the middle 45 % of their limits, f_Hα outside its limits, none for the others:
/// little else than the settings that move the profile slope is changed.
#[test]
fn figures_well_within_their_limits_are_left_alone() {
    let flank = flank(helical(), Side::Left);
    let (settings, matrix) = six_settings(&flank);
    let limits = FlankFigures {
        profile_slope: Some([-4.0, 4.0]),
        helix_slope: Some([-5.0, 5.0]),
        profile_crowning: Some([1.0, 6.0]),
        helix_crowning: Some([2.0, 8.0]),
        twist: None,
    };
    let mut random = Random::new(42);
    for sigma in [0.3, 0.6] {
        let (flanks, mut others) = (300, 0);
        for _ in 0..flanks {
            let mut within = |[low, high]: [f64; 2]| 0.5 * (low + high) + 0.45 * (high - low) * (random.unit() - 0.5);
            let crownings = [within([1.0, 6.0]), within([2.0, 8.0])];
            let slope = if random.unit() < 0.5 { -1.0 } else { 1.0 } * (6.0 + 9.0 * random.unit());
            let measured: Vec<f64> = (0..ROWS * COLUMNS)
                .map(|k| {
                    let t = |i: usize, n: usize| 2.0 * i as f64 / (n - 1) as f64 - 1.0;
                    let (u, v) = (t(k / COLUMNS, ROWS), t(k % COLUMNS, COLUMNS));
                    let form = sigma * random.normal();
                    0.5 * slope * u - crownings[0] * u * u - crownings[1] * v * v + 3.0 + form
                })
                .collect();
            let target = flank.target_within(&measured, None, limits);
            let asked = CorrectionSpec {
                target,
                used: NEEDED,
                absolute: false,
                ..CorrectionSpec::new(measured, matrix.clone(), settings.clone())
            };
            let asked = CorrectionSpec { figures: flank.held(&asked, limits), ..asked };
            let figures = asked.figures.clone();
            let found = solve(asked);
            let change: Vec<f64> = found.settings.iter().map(|setting| setting.change).collect();
            assert!(change[0] != 0.0, "the profile's angle is missed");
            assert!(!figures[0].is_outside(figures[0].after(&change)), "{}", figures[0].after(&change));
            others += usize::from(change[1..].iter().any(|change| *change != 0.0));
        }
        let share = others as f64 / f64::from(flanks);
        assert!(share <= 0.05, "σ {sigma}: {share}");
    }
}

/// C_α = 3.7 µm conforms to 2…6 µm: the setting of the crowning stays unchanged and C_α still
/// conforms; the angles are corrected.
#[test]
fn a_conforming_crowning_is_unchanged_with_a_reason() {
    let flank = flank(helical(), Side::Right);
    let found = Machine::FormGrinding.sensitivity(&flank.gear, &flank.places, flank.ranges).unwrap();
    let mut random = Random::new(7);
    let measured: Vec<f64> = flank
        .places
        .iter()
        .map(|place| {
            let (u, v) = ((place.roll_length - 13.0) / 4.0, (place.z - 10.0) / 9.0);
            4.0 * u - 5.0 * v - 3.7 * u * u - 5.5 * v * v + 0.15 * random.normal()
        })
        .collect();
    let limits = FlankFigures {
        profile_slope: Some([-5.0, 5.0]),
        helix_slope: Some([-5.0, 5.0]),
        profile_crowning: Some([2.0, 6.0]),
        helix_crowning: Some([4.0, 9.0]),
        twist: None,
    };
    let target = flank.target_within(&measured, None, limits);
    let asked = CorrectionSpec {
        target,
        used: NEEDED,
        absolute: false,
        ..CorrectionSpec::new(measured, found.matrix, found.settings)
    };
    let asked = CorrectionSpec { figures: flank.held(&asked, limits), ..asked };
    let figures = asked.figures.clone();
    let solution = solve(asked);
    let setting = |name: &str| solution.settings.iter().find(|setting| setting.name == name).unwrap();
    for name in ["profile_crowning", "helix_crowning"] {
        assert_eq!((setting(name).change, setting(name).unchanged), (0.0, Some(Unchanged::WithinLimits)), "{name}");
        assert_eq!(setting(name).std_error, None);
    }
    assert!(setting("helix_angle").change != 0.0 && setting("helix_angle").unchanged.is_none());
    let change: Vec<f64> = solution.settings.iter().map(|setting| setting.change).collect();
    for figure in &figures {
        let [before, after] = [figure.measured.value, figure.after(&change)];
        assert!(!figure.is_outside(after), "{}: {after}", figure.name);
        match figure.name {
            "profile_slope" | "helix_slope" => assert!(figure.is_outside(before) && after.abs() < 1.0),
            _ => assert!((after - before).abs() < 0.3, "{}: {before} {after}", figure.name),
        }
        // predictions linear in the settings equal the figures of the predicted flank
        let predicted = flank.figures(&solution.predicted.deviation_um, None).unwrap();
        let again = predicted.named().into_iter().find(|(name, _)| *name == figure.name).unwrap().1.unwrap();
        assert!((after - again).abs() < 1e-9, "{}: {after} {again}", figure.name);
    }
}

/// For a flank with noise alone no setting is changed, and the solution is complete. A setting
/// whose limits exclude 0 is still solved for.
#[test]
fn all_settings_may_be_left_alone() {
    let flank = flank(helical(), Side::Left);
    let (mut settings, matrix) = six_settings(&flank);
    let mut random = Random::new(3);
    let measured: Vec<f64> = (0..ROWS * COLUMNS).map(|_| 0.3 * random.normal()).collect();
    let asked =
        CorrectionSpec { used: NEEDED, ..CorrectionSpec::new(measured.clone(), matrix.clone(), settings.clone()) };
    let found = solve(asked.clone());
    assert!(found.settings.iter().all(|setting| setting.unchanged == Some(Unchanged::NotDistinguishable)));
    assert_eq!(found.predicted.deviation_um, measured);
    assert!(found.noise.is_some() && found.leverage.iter().all(|h| *h == 0.0) && found.warnings.is_empty());
    settings[2].min = Some(1.0);
    let found = solve(CorrectionSpec { settings, ..asked });
    assert_eq!((found.settings[2].change, found.settings[2].unchanged), (1.0, None));
    assert!(found.settings.iter().enumerate().all(|(j, setting)| j == 2 || setting.unchanged.is_some()));
}

/// One of two settings with the same effect is changed, the other is not.
#[test]
fn of_settings_that_do_the_same_one_is_needed() {
    let sensitivity: Vec<f64> =
        (0..30).flat_map(|k| [f64::from(k), f64::from(k), (0.7 * f64::from(k)).sin()]).collect();
    let mut random = Random::new(5);
    let measured: Vec<f64> = (0..30).map(|k| 2.0 * f64::from(k) + 0.2 * random.normal()).collect();
    let settings = ["a", "b", "c"].map(|name| Setting::free(name, "µm")).to_vec();
    let asked = CorrectionSpec { used: NEEDED, ..CorrectionSpec::new(measured, sensitivity, settings) };
    let found = solve(asked);
    let changed: Vec<f64> = found.settings.iter().map(|s| s.change).filter(|change| *change != 0.0).collect();
    assert!(changed.len() == 1 && (changed[0] + 2.0).abs() < 0.1, "{changed:?}");
    assert_eq!(found.indistinguishable.len(), 1);
}
