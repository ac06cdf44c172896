//! Run-out: how unevenly a ball or another probe goes into the tooth spaces.
//!
//! `F_r` is the range of the probe's radial readings all around. Eccentricity is the first harmonic
//! of the readings, the least-squares fit of `r₀ + a cos φ + b sin φ` at the angles φᵢ = 2π (i −
//! 1)/z of the spaces; alone it makes a run-out of twice its amount.
//!
//! Without a probe the readings follow from the index deviations of both flanks: a space that is
//! wider by Δw on the measuring circle lets the ball go deeper by `Δw cos α / (2 sin(α ± η))`, with
//! the transverse pressure angle α there and η half the angle of a space (+ on external, − on
//! internal gears): α ± η is the pressure angle at the centre of a ball that touches on the
//! measuring circle. So a gear that is shifted by e has a run-out of 2e. Whether the answer was
//! derived so is said.

use super::{
    pitch::{Pitch, count, exceeds},
    pitch_limits::Held,
    warning::RunoutWarning,
};
use crate::{
    Gear, Side,
    involute::Flank,
    tolerance::{Characteristic, Class, Rounding, Tolerances},
    trace::MOST_DEVIATION,
};
use flankfit_estimation::{
    self, FitError, FitSpec, Nodes,
    spec::{Model, Regularization},
};
use flankfit_numerics::{
    check::Faults,
    words::{Shown, entries, rounded},
};

/// The direction in which teeth are numbered, seen with the axis towards the viewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = ToothCounting)
)]
pub enum Counting {
    /// Against the direction of angles that grow.
    Clockwise,
    /// In the direction of angles that grow.
    Counterclockwise,
}

impl Counting {
    /// Returns the word for it in messages.
    pub fn word(self) -> &'static str {
        match self {
            Counting::Clockwise => "clockwise",
            Counting::Counterclockwise => "counterclockwise",
        }
    }
}

/// First harmonic of the readings.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct Eccentricity {
    /// Distance of the gear's axis from the axis of rotation: half the range of the harmonic.
    pub amount_um: f64,
    /// Standard error of the amount, from the residuals of the harmonic; absent if too few readings
    /// are defined.
    pub std_error_um: Option<f64>,
    /// Angle of the greatest readings, −180 to 180, in the direction of counting from the first
    /// one.
    pub angle_deg: f64,
}

/// Run-out of a gear.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = GearRunout)
)]
pub struct Runout {
    /// F_r: the range of the readings all around.
    pub runout_um: f64,
    /// True if it follows from pitches, without a probe.
    pub derived: bool,
    /// Radial readings in each tooth space, outwards, posted or derived; `null` if undefined.
    pub readings_um: Vec<Option<f64>>,
    /// First harmonic; absent if there are too few readings.
    pub eccentricity: Option<Eccentricity>,
    /// Number of tooth spaces without a reading.
    pub missing: usize,
    /// Class 1 to 11; absent if there is none, or a space is missing.
    pub class: Option<u8>,
    /// True if it exceeds even class 11.
    pub coarser_than_11: bool,
    /// Comparison with limits; set by callers that have some.
    #[cfg_attr(feature = "contract", serde(flatten), schema(inline))]
    pub held: Option<Held>,
    /// Warnings.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub warnings: Vec<RunoutWarning>,
}

/// Run-out from radial readings, µm (outwards positive), one per tooth space, NaN where there is
/// none.
pub fn from_readings(gear: &Gear, readings: &[f64], rounding: Rounding) -> Result<Runout, Faults> {
    let teeth = gear.data().teeth as usize;
    let mut faults = Faults::default();
    if readings.len() != teeth {
        let given = entries(readings.len());
        faults.push("readings_um", format_args!("{given}, but the gear has {teeth} tooth spaces"));
    }
    for (index, &value) in readings.iter().enumerate() {
        if value.abs() > MOST_DEVIATION {
            faults.push(format_args!("readings_um[{index}]"), exceeds(value, MOST_DEVIATION, "µm"));
        }
    }
    if !readings.is_empty() && readings.iter().all(|r| r.is_nan()) {
        faults.push("readings_um", "no space was measured");
    }
    faults.into_result(())?;
    Ok(evaluate(gear, readings, rounding, false))
}

/// Run-out from the index deviations of both flanks, measured on one circle and counted in the same
/// direction. Reading i is that of the space between tooth i and the next one.
pub fn from_pitches(
    gear: &Gear,
    left: &Pitch,
    right: &Pitch,
    counting: Counting,
    rounding: Rounding,
) -> Result<Runout, Faults> {
    let teeth = gear.data().teeth as usize;
    let mut faults = Faults::default();
    for (path, pitch) in [("left", left), ("right", right)] {
        if pitch.index_deviation_um.len() != teeth {
            faults.push(path, count(pitch.index_deviation_um.len(), teeth));
        }
    }
    let diameter = left.diameter_mm;
    if diameter != right.diameter_mm {
        let [left, right] = [diameter, right.diameter_mm].map(Shown);
        faults.push("right", format_args!("measured on {right} mm, the left flank on {left} mm"));
    }
    let base = 2.0 * gear.base_radius();
    if !(diameter > base) {
        let [diameter, base] = [diameter, base].map(|x| rounded(x, 7));
        faults.push(
            "left",
            format_args!("the measuring circle of {diameter} mm is not above the base circle of {base} mm"),
        );
    }
    faults.into_result(())?;
    // the left flank lies counterclockwise of its tooth: it is the one that bounds the next space
    // when counting runs that way
    let (near, far) = match counting {
        Counting::Counterclockwise => (left, right),
        Counting::Clockwise => (right, left),
    };
    let roll_length = 0.5 * ((diameter - base) * (diameter + base)).sqrt();
    let alpha = (roll_length / gear.base_radius()).atan();
    let half_space = 0.5 * gear.pitch_angle() - Flank::new(gear, Side::Left).half_angle(roll_length);
    let at_centre = alpha + gear.outward() * half_space;
    if !(at_centre > 0.0) {
        return Err(Faults::one("left", "no ball touches both flanks of a space on the measuring circle"));
    }
    let depth = gear.outward() * alpha.cos() / (2.0 * at_centre.sin());
    let reading = |i: usize| Some((near.index_deviation_um[i]? - far.index_deviation_um[(i + 1) % teeth]?) * depth);
    let readings: Vec<f64> = (0..teeth).map(|i| reading(i).unwrap_or(f64::NAN)).collect();
    if readings.iter().all(|r| r.is_nan()) {
        return Err(Faults::one("left", "no space has index deviations of both of its flanks"));
    }
    Ok(evaluate(gear, &readings, rounding, true))
}

/// Returns the correlation coefficient of readings of the tooth spaces and the run-out that follows
/// from the index deviations of both flanks with this direction of counting. `None` if either is
/// constant, or if fewer than three spaces have both.
pub fn agreement(
    left: &[Option<f64>],
    right: &[Option<f64>],
    readings: &[Option<f64>],
    counting: Counting,
) -> Option<f64> {
    let (near, far) = match counting {
        Counting::Counterclockwise => (left, right),
        Counting::Clockwise => (right, left),
    };
    let teeth = near.len().min(far.len()).min(readings.len());
    let pair = |i: usize| Some([near[i]? - far[(i + 1) % teeth]?, readings[i]?]);
    let pairs: Vec<[f64; 2]> = (0..teeth).filter_map(pair).collect();
    let mean = |k: usize| pairs.iter().map(|pair| pair[k]).sum::<f64>() / pairs.len() as f64;
    let [x, y] = [mean(0), mean(1)];
    let sum = |of: fn(f64, f64) -> f64| pairs.iter().map(|[a, b]| of(a - x, b - y)).sum::<f64>();
    let correlation = sum(|a, b| a * b) / (sum(|a, _| a * a) * sum(|_, b| b * b)).sqrt();
    (pairs.len() > 2 && correlation.is_finite()).then_some(correlation)
}

/// At least one reading is there.
fn evaluate(gear: &Gear, readings: &[f64], rounding: Rounding, derived: bool) -> Runout {
    let there = readings.iter().filter(|r| !r.is_nan());
    let (least, most) = there.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &r| (a.min(r), b.max(r)));
    let runout = most - least;
    let missing = readings.iter().filter(|r| r.is_nan()).count();
    let mut warnings = Vec::new();
    if missing > 0 {
        warnings.push(RunoutWarning::MissingSpaces { missing, spaces: readings.len() });
    }
    let class = match Tolerances::new(gear) {
        _ if missing > 0 => None,
        Ok(tolerances) => tolerances.class(Characteristic::Runout, runout, rounding),
        Err(out) => {
            warnings.push(RunoutWarning::OutsideTheStandard(out));
            None
        }
    };
    let eccentricity = eccentricity(readings).unwrap_or_else(|error| {
        warnings.push(RunoutWarning::NoEccentricity { error });
        None
    });
    let readings = readings.iter().map(|r| (!r.is_nan()).then_some(*r)).collect();
    Runout {
        runout_um: runout,
        derived,
        readings_um: readings,
        eccentricity,
        missing,
        class: class.and_then(Class::number),
        coarser_than_11: class == Some(Class::Beyond),
        held: None,
        warnings,
    }
}

/// `None` with fewer than three readings or with readings that do not tell the three numbers apart.
fn eccentricity(readings: &[f64]) -> Result<Option<Eccentricity>, FitError> {
    let (mut x, mut y) = (Vec::new(), Vec::new());
    for (i, &reading) in readings.iter().enumerate().filter(|(_, r)| !r.is_nan()) {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / readings.len() as f64).sin_cos();
        x.extend([1.0, cos, sin]);
        y.push(reading);
    }
    if y.len() < 3 {
        return Ok(None);
    }
    let spec = FitSpec { regularization: Regularization::None, ..FitSpec::new(Model::Linear) };
    let nodes = Nodes::matrix(x, 3, y, None, None).map_err(|faults| faults.within("nodes"))?;
    let fit = flankfit_estimation::fit(&nodes, &spec)?;
    if fit.spectrum.rank < 3 {
        return Ok(None);
    }
    let [cos, sin] = [&fit.coefficients[1], &fit.coefficients[2]];
    let amount = cos.value.hypot(sin.value);
    let std_error = cos.std_error.zip(sin.std_error).map(|(a, b)| match amount > 0.0 {
        true => (cos.value * a).hypot(sin.value * b) / amount,
        false => a.max(b),
    });
    let angle_deg = sin.value.atan2(cos.value).to_degrees();
    Ok(Some(Eccentricity { amount_um: amount, std_error_um: std_error, angle_deg }))
}
