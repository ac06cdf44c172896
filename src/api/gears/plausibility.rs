//! Plausibility of the stated units of nodes, traces and pitches.

use serde_json::{Value, json};

use crate::api::{
    measurand::{
        axes::{AxesBody, AxisBody},
        units::{LENGTHS, micrometres, sign},
    },
    warning::WarningBody,
};
use flankfit_engine::{
    estimation::Nodes,
    gear::{
        Gear, ProfileAxis,
        evaluation::Evaluation,
        geometry::Geometry,
        tolerance::{COARSEST, Characteristic, FINEST, Tolerances},
    },
};

/// Code of the warning.
pub const IMPLAUSIBLE_UNIT: &str = "implausible_unit";
/// Least and greatest range of deviations, µm, if the gear has no tolerances.
const RANGE_UM: [f64; 2] = [0.1, 1000.0];
/// Least noise of any instrument that measures flanks, µm.
const LEAST_NOISE_UM: f64 = 0.005;
/// Degrees of freedom from which on the estimate of the noise is accurate enough.
const LEAST_FREEDOM: usize = 5;
/// Residuals below this share of the range mean an exact fit of computed, not measured, nodes.
const EXACT: f64 = 1e-9;

/// Share of a profile or a face that measured nodes cover at least: an inch is 25.4 mm.
const LEAST_SHARE: f64 = 0.05;

/// The noise estimated by a fit, in the unit of its heights.
#[derive(Clone, Copy, Debug)]
pub struct Noise {
    pub sigma: f64,
    pub degrees_of_freedom: usize,
}

/// How to settle it for the nodes of an iteration.
const OF_NODES: &str = "send `axes` with the right unit, or `accept_units: true` if this one is right, by `PATCH` of \
                        the iteration";
/// How to settle it for traces.
const OF_TRACES: &str = "send the deviations in µm, or `evaluation.accept_units: true` if they are";
/// How to settle it for what is sent without an iteration.
const OF_REQUEST: &str = "send the deviations in µm, or `accept_units: true` if they are";
/// The same for places.
const OF_PLACES: &str = "send the places in mm (roll angles in degrees), or \
                         `accept_units: true` if they are";

/// How to settle it for a grid.
const OF_GRID: &str = "send the deviations in µm";
/// How to settle it for points.
const OF_POINTS: &str = "send the points in mm, and check gear and position";

/// Returns the usual range of deviations of flanks, µm: a quarter of F_α of the finest class to
/// four times that of the coarsest.
fn usual_range(gear: Option<&Gear>) -> [f64; 2] {
    usual_range_of(Characteristic::ProfileTotal, gear)
}

/// The same of another characteristic.
fn usual_range_of(characteristic: Characteristic, gear: Option<&Gear>) -> [f64; 2] {
    let of = |tolerances: Tolerances| {
        let total = |class| tolerances.unrounded(characteristic, class);
        Some([total(FINEST)? / 4.0, total(COARSEST)? * 4.0])
    };
    gear.and_then(|gear| Tolerances::new(gear).ok()).and_then(of).unwrap_or(RANGE_UM)
}

/// Returns a warning if a unit is implausible: the first one found, heights before places. Only
/// axes whose units are lengths are checked, and roll angles.
pub fn implausible(nodes: &Nodes, axes: &AxesBody, gear: Option<&Gear>, noise: Option<Noise>) -> Option<WarningBody> {
    let [u, v, z] = lists(nodes)?;
    let heights = axes.z.as_ref().and_then(|axis| of_heights(axis, z, gear, noise));
    let places = || {
        let gear = gear?;
        let of_u = || axes.u.as_ref().and_then(|axis| of_axis(axis, &u, gear));
        of_u().or_else(|| axes.v.as_ref().and_then(|axis| of_axis(axis, &v, gear)))
    };
    heights.or_else(places)
}

/// Returns the warning on places along an axis of nodes.
fn of_axis(axis: &AxisBody, values: &[f64], gear: &Gear) -> Option<WarningBody> {
    let unit = axis.unit.as_str();
    match (axis.quantity.as_str(), unit) {
        ("roll_length", "deg") => of_profile(ProfileAxis::RollAngle, 1.0, values, gear, OF_NODES),
        ("roll_length", "arcmin") => of_profile(ProfileAxis::RollAngle, 1.0 / 60.0, values, gear, OF_NODES),
        ("roll_length", _) => of_profile(ProfileAxis::RollLength, mm(unit)?, values, gear, OF_NODES),
        ("diameter", _) => of_profile(ProfileAxis::Diameter, mm(unit)?, values, gear, OF_NODES),
        ("face_width", _) => of_width(mm(unit)?, values, gear, OF_NODES),
        _ => None,
    }
}

/// A unit of length in mm.
fn mm(unit: &str) -> Option<f64> {
    micrometres(unit).map(|um| um / 1e3)
}

/// Returns a warning if the deviations of a flank extend over less, or over more, than those of any
/// gear, or if its places (mm or degrees, and z in mm) are not on it; the deviations are in µm.
/// Equal deviations were not measured.
pub fn implausible_flank(
    axis: ProfileAxis,
    profile: &[f64],
    z: &[f64],
    deviations: &[f64],
    gear: &Gear,
) -> Option<WarningBody> {
    let heights = span(deviations).and_then(|span| of_range("um", span, usual_range(Some(gear)), OF_REQUEST));
    let along_profile = || of_profile(axis, 1.0, profile, gear, OF_PLACES);
    heights.or_else(along_profile).or_else(|| of_width(1.0, z, gear, OF_PLACES))
}

/// The same of deviations on a grid, which are held against nothing.
pub fn implausible_grid(deviations: &[f64], gear: &Gear) -> Option<WarningBody> {
    of_range("um", span(deviations)?, usual_range(Some(gear)), OF_GRID)
}

/// Returns a warning if measured points lie farther from the flank than those of any gear, µm.
/// Points that were computed may lie on it.
pub fn implausible_points(deviations: &[f64], gear: &Gear) -> Option<WarningBody> {
    let (found, [_, most]) = (span(deviations)?, usual_range(Some(gear)));
    let what = format!(
        "the deviations extend over {} µm, more than those of any gear like this one ({} µm)",
        digits(found),
        digits(most)
    );
    let params = json!({"range_um": found, "limit_um": most});
    (found > most).then(|| of_sentence(&what, None, params, OF_POINTS))
}

/// Returns a warning if the index deviations of a flank do so, by F_p; they are in µm.
pub fn implausible_pitches(index: &[Option<f64>], gear: &Gear) -> Option<WarningBody> {
    let defined: Vec<f64> = index.iter().copied().flatten().collect();
    of_range("um", span(&defined)?, usual_range_of(Characteristic::CumulativePitch, Some(gear)), OF_REQUEST)
}

/// Returns a warning if every trace of a request deviates by less, or every one by more, than those
/// of any gear; its deviations are in µm. Traces without any deviation were not measured.
pub fn implausible_traces(evaluation: &Evaluation, gear: &Gear) -> Option<WarningBody> {
    let totals = evaluation.traces.iter().filter_map(|trace| trace.values.map(|values| values.total_um));
    let [least, most] = ends(&totals.collect::<Vec<_>>())?;
    let usual = usual_range(Some(gear));
    match usual {
        [low, _] if 0.0 < most && most < low => of_range("um", most, usual, OF_TRACES),
        [_, high] if least > high => of_range("um", least, usual, OF_TRACES),
        _ => None,
    }
}

fn of_heights(axis: &AxisBody, z: Vec<f64>, gear: Option<&Gear>, noise: Option<Noise>) -> Option<WarningBody> {
    let unit = axis.unit.as_str();
    let um = micrometres(unit)?;
    let usual = usual_range(gear);
    let span = span(&z)?;
    of_range(unit, span, usual, OF_NODES).or_else(|| {
        let Noise { sigma, degrees_of_freedom } = noise?;
        let found = sigma * um;
        (degrees_of_freedom >= LEAST_FREEDOM && found < LEAST_NOISE_UM && sigma > EXACT * span).then(|| {
            let what = format!(
                "the residuals scatter by {} nm only, less than the noise of any instrument",
                digits(1e3 * found)
            );
            let fits = |other: f64| sigma * other >= LEAST_NOISE_UM && within(span * other, usual);
            let params = json!({"sigma_um": found});
            notice(&what, unit, span, fits, params, OF_NODES)
        })
    })
}

fn of_range(unit: &str, span: f64, usual: [f64; 2], mend: &str) -> Option<WarningBody> {
    let found = span * micrometres(unit)?;
    let [least, most] = usual;
    let (how, limit) = match found {
        found if found < least => ("less", least),
        found if found > most => ("more", most),
        _ => return None,
    };
    let what = format!(
        "the deviations extend over {} µm, {how} than those of any gear like this one ({} µm)",
        digits(found),
        digits(limit)
    );
    let params = json!({"range_um": found, "limit_um": limit});
    Some(notice(&what, unit, span, |other| within(span * other, usual), params, mend))
}

/// Values of the axis, times `factor` in its own unit.
fn of_profile(axis: ProfileAxis, factor: f64, values: &[f64], gear: &Gear, mend: &'static str) -> Option<WarningBody> {
    // an angle is the roll length on the base circle
    let (quantity, mm) = match axis {
        ProfileAxis::RollAngle => (ProfileAxis::RollLength, factor * 1.0_f64.to_radians() * gear.base_radius()),
        ProfileAxis::RollLength => (ProfileAxis::RollLength, factor),
        ProfileAxis::Diameter => (ProfileAxis::Diameter, factor),
    };
    let Geometry { form_roll_length_mm: root, tip_form_roll_length_mm: tip, .. } = Geometry::of(gear);
    let (low, high) = (root.min(tip), root.max(tip));
    let allowed = [low - 0.5 * (high - low), high + 0.5 * (high - low)];
    let ends = ends(values)?;
    let roll = |x: f64| match quantity {
        // a diameter below the base circle has none
        ProfileAxis::Diameter => Some(gear.roll_length(x).unwrap_or(0.0)),
        _ => quantity.roll_length(gear, x),
    };
    let inside = |mm: f64| ends.iter().all(|end| roll(end * mm).is_some_and(|roll| within(roll, allowed)));
    let span = |mm: f64| Some(roll(ends[1] * mm)? - roll(ends[0] * mm)?);
    let is_wide = |mm: f64| ends[0] == ends[1] || span(mm).is_some_and(|span| span >= LEAST_SHARE * (high - low));
    if is_plausible(mm, inside, is_wide) {
        return None;
    }
    let fits = |mm: f64| inside(mm) && is_wide(mm);
    let shown = ends.map(|end| end * mm);
    let what = match quantity {
        ProfileAxis::Diameter => "diameters",
        _ => "roll lengths",
    };
    let what = format!(
        "along the profile the nodes lie from {} to {} mm, but the flank has {what} from {} to {} mm",
        digits(shown[0]),
        digits(shown[1]),
        digits(quantity.value(gear, low)),
        digits(quantity.value(gear, high))
    );
    Some(of_place(&what, "u", ends, fits, shown, mend))
}

fn of_width(mm: f64, values: &[f64], gear: &Gear, mend: &'static str) -> Option<WarningBody> {
    let width = gear.data().face_width?;
    let ends = ends(values)?;
    // z may count from an end or from the middle
    let inside = |mm: f64| ends.iter().all(|end| within(end * mm, [-1.5 * width, 2.0 * width]));
    let is_wide = |mm: f64| ends[0] == ends[1] || (ends[1] - ends[0]) * mm >= LEAST_SHARE * width;
    if is_plausible(mm, inside, is_wide) {
        return None;
    }
    let fits = |mm: f64| inside(mm) && is_wide(mm);
    let shown = ends.map(|end| end * mm);
    let [low, high] = shown.map(digits);
    let what =
        format!("along the axis the nodes lie from {low} to {high} mm, but the face is {} mm wide", digits(width));
    Some(of_place(&what, "v", ends, fits, shown, mend))
}

/// True if places lie on the flank and cover enough of it; where no unit makes them do so, little
/// of the flank was measured, and the unit is not to blame.
fn is_plausible(mm: f64, inside: impl Fn(f64) -> bool, is_wide: impl Fn(f64) -> bool) -> bool {
    let fits = |mm: f64| inside(mm) && is_wide(mm);
    inside(mm) && (is_wide(mm) || !LENGTHS.iter().any(|(_, other)| fits(*other)))
}

fn of_place(
    what: &str,
    name: &'static str,
    ends: [f64; 2],
    fits: impl Fn(f64) -> bool,
    shown: [f64; 2],
    mend: &str,
) -> WarningBody {
    let mut params = json!({"axis": name, "from_mm": shown[0], "to_mm": shown[1]});
    // with a far smaller unit everything would fit, so the largest come first
    let other = LENGTHS.iter().rev().find(|(_, mm)| fits(*mm));
    let then = other.map(|(unit, mm)| {
        let [low, high] = ends.map(|end| digits(end * mm));
        params["unit"] = json!(unit);
        format!(" (in {}? then {low} to {high} mm)", named(unit))
    });
    of_sentence(what, then, params, mend)
}

fn notice(what: &str, unit: &str, span: f64, fits: impl Fn(f64) -> bool, mut params: Value, mend: &str) -> WarningBody {
    let known = || LENGTHS.iter().map(|(name, _)| *name).filter(|name| *name != unit);
    // testers use mm more often than any other unit
    let mut others: Vec<&str> = known().collect();
    others.sort_by_key(|name| *name != "mm");
    let other = others.into_iter().find(|name| micrometres(name).is_some_and(&fits));
    let then = other.and_then(|name| {
        let range = span * micrometres(name)?;
        params["unit"] = json!(name);
        params["then_um"] = json!(range);
        Some(format!(" (in {}? then {} µm)", named(name), digits(range)))
    });
    of_sentence(what, then, params, mend)
}

/// The name of a unit of length in a sentence.
fn named(unit: &str) -> &str {
    match unit {
        "in" => "inches",
        other => sign(other),
    }
}

fn of_sentence(what: &str, then: Option<String>, params: Value, mend: &str) -> WarningBody {
    let message = format!("{what}{}: {mend}", then.unwrap_or_default());
    WarningBody::new(IMPLAUSIBLE_UNIT, &message).with_values(&params)
}

/// Returns u, v and z of the nodes of a surface that count.
fn lists(nodes: &Nodes) -> Option<[Vec<f64>; 3]> {
    match nodes {
        Nodes::Scattered(nodes) => Some([nodes.u().to_vec(), nodes.v().to_vec(), nodes.z().to_vec()]),
        Nodes::Grid(grid) => {
            let valid = |k: usize| grid.valid().as_ref().is_none_or(|valid| valid[k]);
            let z = grid.z().iter().enumerate().filter(|(k, _)| valid(*k)).map(|(_, z)| *z).collect();
            Some([grid.u().to_vec(), grid.v().to_vec(), z])
        }
        Nodes::Curve(_) | Nodes::Matrix(_) => None,
    }
}

fn ends(values: &[f64]) -> Option<[f64; 2]> {
    let finite = values.iter().copied().filter(|x| x.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    (low <= high).then_some([low, high])
}

/// Returns the range of values; `None` if they are all equal.
fn span(values: &[f64]) -> Option<f64> {
    ends(values).map(|[low, high]| high - low).filter(|span| *span > 0.0)
}

fn within(value: f64, [low, high]: [f64; 2]) -> bool {
    (low..=high).contains(&value)
}

/// Formats with three significant digits, without trailing zeros.
pub fn digits(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    #[expect(clippy::cast_possible_truncation, reason = "an exponent of ten of a finite number")]
    let before = value.abs().log10().floor() as i32 + 1;
    let decimals = usize::try_from(3 - before).unwrap_or(0);
    let text = format!("{value:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flankfit_engine::gear::GearData;

    fn gear() -> Gear {
        Gear::new(GearData { face_width: Some(20.0), ..GearData::spur(52, 1.0) }).unwrap()
    }

    fn axes(units: [&str; 3]) -> AxesBody {
        let [u, v, z] = units;
        serde_json::from_value(serde_json::json!({
            "u": {"quantity": "roll_length", "unit": u},
            "v": {"quantity": "face_width", "unit": v},
            "z": {"quantity": "deviation", "unit": z},
        }))
        .unwrap()
    }

    /// Returns nodes whose heights span 20.8 µm, scaled by these factors.
    fn nodes([u, v, z]: [f64; 3]) -> Nodes {
        let of = |list: &[f64], factor: f64| list.iter().map(|x| x * factor).collect::<Vec<_>>();
        Nodes::scattered(
            of(&[6.0, 11.0, 9.0, 8.0], u),
            of(&[1.0, 19.0, 3.0, 4.0], v),
            of(&[-10.8, 10.0, 0.0, 1.0], z),
            None,
        )
        .unwrap()
    }

    #[test]
    fn the_usual_range_is_that_of_the_standards_classes() {
        // F_α of class 5, m 1, d 52: √((0.4 + 0.052 + 4)² + 5.55²); a quarter of it is class 1,
        // eightfold class 11
        let fifth = f64::hypot(4.452, 5.55);
        let [low, high] = usual_range(Some(&gear()));
        assert!((low - fifth / 16.0).abs() < 1e-12 && (high - 32.0 * fifth).abs() < 1e-9, "{low} {high}");
        assert_eq!(usual_range(None), [0.1, 1000.0]);
        let tiny = Gear::new(GearData::spur(52, 0.1)).unwrap();
        assert_eq!(usual_range(Some(&tiny)), [0.1, 1000.0], "the standard does not cover it");
    }

    #[test]
    fn an_implausible_unit_is_reported_with_one_that_fits() {
        let of = |units, factors| implausible(&nodes(factors), &axes(units), Some(&gear()), None);
        assert_eq!(of(["mm", "mm", "um"], [1.0, 1.0, 1.0]), None);
        assert_eq!(of(["mm", "mm", "mm"], [1.0, 1.0, 1e-3]), None);
        let heights = of(["mm", "mm", "um"], [1.0, 1.0, 1e-3]).unwrap();
        assert_eq!(heights.code, IMPLAUSIBLE_UNIT);
        assert!(
            heights.message.starts_with(
                "the deviations extend over 0.0208 µm, less than those of any gear like this one (0.445 µm) (in mm? \
                 then 20.8 µm): send `axes`"
            ),
            "{}",
            heights.message
        );
        let nanometres = of(["mm", "mm", "um"], [1.0, 1.0, 1e3]).unwrap();
        assert!(nanometres.message.contains("more than") && nanometres.message.contains("(in nm? then 20.8 µm)"));
        let profile = of(["mm", "mm", "um"], [1e3, 1.0, 1.0]).unwrap();
        assert!(profile.message.contains("(in µm? then 6 to 11 mm)"), "{}", profile.message);
        let inches = of(["in", "mm", "um"], [1.0, 1.0, 1.0]).unwrap();
        assert!(inches.message.contains("(in mm? then 6 to 11 mm)"), "{}", inches.message);
        let width = of(["mm", "mm", "um"], [1.0, 1e3, 1.0]).unwrap();
        assert!(width.message.contains("(in µm? then 1 to 19 mm)"), "{}", width.message);
        // inches taken for millimetres: 0.71 of 20 mm
        let inches = of(["mm", "mm", "um"], [1.0, 1.0 / 25.4, 1.0]).unwrap();
        assert!(inches.message.contains("(in inches? then 1 to 19 mm)"), "{}", inches.message);
        let inches = of(["mm", "mm", "um"], [1.0 / 25.4, 1.0, 1.0]).unwrap();
        assert!(inches.message.contains("(in inches? then 6 to 11 mm)"), "{}", inches.message);
    }

    #[test]
    fn nodes_on_little_of_a_flank_have_no_wrong_unit() {
        let of = |u: [f64; 4], v: [f64; 4]| {
            let nodes = Nodes::scattered(u.to_vec(), v.to_vec(), vec![-5.0, 5.0, 0.0, 1.0], None).unwrap();
            implausible(&nodes, &axes(["mm", "mm", "um"]), Some(&gear()), None)
        };
        let [whole, width] = [[6.0, 11.0, 9.0, 8.0], [1.0, 19.0, 3.0, 4.0]];
        // a strip that is none of a flank in inches, a single profile, a single helix
        assert_eq!(of(whole, [10.0, 10.6, 10.1, 10.2]), None);
        assert_eq!((of(whole, [0.5; 4]), of([8.0; 4], width)), (None, None));
        // roll lengths 8 to 8.2 mm: in inches they would lie outside the tip
        assert_eq!(of([8.0, 8.2, 8.1, 8.1], width), None);
    }

    #[test]
    fn no_instrument_scatters_by_less_than_five_nanometres() {
        let noise = |sigma, degrees_of_freedom| Some(Noise { sigma, degrees_of_freedom });
        let of = |noise| implausible(&nodes([1.0; 3]), &axes(["mm", "mm", "um"]), Some(&gear()), noise);
        assert_eq!(
            (of(noise(0.006, 5)), of(noise(0.0004, 4)), of(noise(1e-12, 5)), of(None)),
            (None, None, None, None)
        );
        let found = of(noise(0.0004, 5)).unwrap();
        assert!(found.message.starts_with("the residuals scatter by 0.4 nm only"), "{}", found.message);
    }

    #[test]
    fn numbers_are_written_with_three_digits() {
        let written = [0.0208, 20.8, 5.0, 231.4, 1234.0, 0.44489].map(digits);
        assert_eq!(written, ["0.0208", "20.8", "5", "231", "1234", "0.445"]);
    }
}
