//! The analytic modifications. Each depends on the profile alone or on the face width alone, but
//! for the twist, which is their product.

use super::{LEAST_LENGTH, Range, Topography};
use crate::Gear;
use flankfit_numerics::{
    check::Faults,
    words::{Shown, rounded},
};

/// Growth of a relief from its start. Default `linear`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = ReliefForm)
)]
pub enum Growth {
    /// With the distance t from its start.
    #[default]
    Linear,
    /// With t², tangent to the unmodified flank.
    Parabolic,
}

/// An end of the face width.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = FaceEnd)
)]
pub enum End {
    /// The end of lower z.
    #[cfg_attr(feature = "contract", serde(rename = "I"))]
    Low,
    /// The end of higher z.
    #[cfg_attr(feature = "contract", serde(rename = "II"))]
    High,
}

/// A modification. Amounts in µm, positive = material removed; the table of [`super`] says what
/// each is.
#[derive(Clone, Debug, PartialEq)]
pub enum Law {
    /// Crowning over the profile.
    ProfileCrowning {
        /// Amount, µm.
        amount: f64,
    },
    /// Profile slope.
    ProfileSlope {
        /// Amount, µm.
        amount: f64,
    },
    /// `start_diameter` in mm lies within the range.
    TipRelief {
        /// Amount at the end, µm.
        amount: f64,
        /// Diameter where the relief starts, mm.
        start_diameter: f64,
        /// How the relief grows from its start.
        growth: Growth,
    },
    /// `start_diameter` in mm lies within the range.
    RootRelief {
        /// Amount at the end, µm.
        amount: f64,
        /// Diameter where the relief starts, mm.
        start_diameter: f64,
        /// How the relief grows from its start.
        growth: Growth,
    },
    /// Crowning over the face width.
    HelixCrowning {
        /// Amount, µm.
        amount: f64,
    },
    /// Helix slope.
    HelixSlope {
        /// Amount, µm.
        amount: f64,
    },
    /// `length` in mm is at most that of the range.
    EndRelief {
        /// Amount at the end, µm.
        end: End,
        /// End of the face width.
        amount: f64,
        /// Length of the relief along the axis, mm.
        length: f64,
        /// How the relief grows from its start.
        growth: Growth,
    },
    /// Twist of the flank.
    Twist {
        /// Amount, µm.
        amount: f64,
    },
    /// Relief given at the nodes of a grid.
    Topography(Topography),
}

/// A checked analytic modification.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum AnalyticLaw {
    ProfileCrowning(f64),
    ProfileSlope(f64),
    /// From roll length `start`, where t = 0, to `end`, where t = 1.
    Profile {
        amount: f64,
        start: f64,
        end: f64,
        growth: Growth,
    },
    HelixCrowning(f64),
    HelixSlope(f64),
    /// The same along z.
    Helix {
        amount: f64,
        start: f64,
        end: f64,
        growth: Growth,
    },
    Twist(f64),
}

/// Relief and its slope at `x` of one that runs from `start` to `end`.
fn grown(amount: f64, start: f64, end: f64, growth: Growth, x: f64) -> (f64, f64) {
    let (t, slope) = ((x - start) / (end - start), amount / (end - start));
    match growth {
        _ if t < 0.0 => (0.0, 0.0),
        Growth::Linear => (amount * t, slope),
        Growth::Parabolic => (amount * t * t, 2.0 * t * slope),
    }
}

impl AnalyticLaw {
    /// Checks `law`. A topography is checked where it is made.
    pub(super) fn new(gear: &Gear, range: &Range, law: &Law) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        let most = 1000.0 * gear.data().normal_module;
        let mut amount_of = |amount: f64| {
            if !(amount.abs() <= most) {
                let [amount, most] = [amount, most].map(Shown);
                faults.push("amount_um", format_args!("{amount} is not within ±{most} µm, one normal module"));
            }
            amount
        };
        let part = match *law {
            Law::ProfileCrowning { amount } => AnalyticLaw::ProfileCrowning(amount_of(amount)),
            Law::ProfileSlope { amount } => AnalyticLaw::ProfileSlope(amount_of(amount)),
            Law::HelixCrowning { amount } => AnalyticLaw::HelixCrowning(amount_of(amount)),
            Law::HelixSlope { amount } => AnalyticLaw::HelixSlope(amount_of(amount)),
            Law::Twist { amount } => AnalyticLaw::Twist(amount_of(amount)),
            Law::TipRelief { amount, start_diameter, growth } | Law::RootRelief { amount, start_diameter, growth } => {
                let amount = amount_of(amount);
                let to_tip = matches!(law, Law::TipRelief { .. });
                let [root, tip] = range.profile();
                let (end, other) = if to_tip { (tip, root) } else { (root, tip) };
                let start = gear.roll_length(start_diameter).unwrap_or(f64::NAN);
                // Within the range, and not at the end that the relief runs to.
                let share = (start - end) / (other - end);
                if !(share > 0.0 && share <= 1.0 && (start - end).abs() >= LEAST_LENGTH) {
                    let [start, root, tip] =
                        [start_diameter, gear.diameter(root), gear.diameter(tip)].map(|x| rounded(x, 7));
                    faults.push(
                        "start_diameter_mm",
                        format_args!(
                            "{start} mm does not lie between {root} mm and {tip} mm, or leaves no length for the \
                             relief"
                        ),
                    );
                }
                AnalyticLaw::Profile { amount, start, end, growth }
            }
            Law::EndRelief { end, amount, length, growth } => {
                let amount = amount_of(amount);
                let [low, high] = range.helix();
                if !(length >= LEAST_LENGTH && length <= high - low) {
                    let [length, most] = [length, high - low].map(|x| rounded(x, 7));
                    faults.push(
                        "length_mm",
                        format_args!("{length} mm is not within {LEAST_LENGTH} mm and {most} mm, the range's length"),
                    );
                }
                match end {
                    End::Low => AnalyticLaw::Helix { amount, start: low + length, end: low, growth },
                    End::High => AnalyticLaw::Helix { amount, start: high - length, end: high, growth },
                }
            }
            // Checked where it was made, and kept apart.
            Law::Topography(_) => AnalyticLaw::Twist(0.0),
        };
        faults.into_result(part)
    }

    /// Part that depends on the roll length alone: relief and its slope.
    pub(super) fn along_profile(&self, range: &Range, roll_length: f64) -> (f64, f64) {
        let (u, slope) = (range.u(roll_length), range.u_slope());
        match *self {
            AnalyticLaw::ProfileCrowning(amount) => (amount * u * u, 2.0 * amount * u * slope),
            AnalyticLaw::ProfileSlope(amount) => (0.5 * amount * u, 0.5 * amount * slope),
            AnalyticLaw::Profile { amount, start, end, growth } => grown(amount, start, end, growth, roll_length),
            AnalyticLaw::HelixCrowning(_)
            | AnalyticLaw::HelixSlope(_)
            | AnalyticLaw::Helix { .. }
            | AnalyticLaw::Twist(_) => (0.0, 0.0),
        }
    }

    /// Part that depends on z alone: relief and its slope.
    pub(super) fn along_helix(&self, range: &Range, z: f64) -> (f64, f64) {
        let (v, slope) = (range.v(z), range.v_slope());
        match *self {
            AnalyticLaw::HelixCrowning(amount) => (amount * v * v, 2.0 * amount * v * slope),
            AnalyticLaw::HelixSlope(amount) => (0.5 * amount * v, 0.5 * amount * slope),
            AnalyticLaw::Helix { amount, start, end, growth } => grown(amount, start, end, growth, z),
            AnalyticLaw::ProfileCrowning(_)
            | AnalyticLaw::ProfileSlope(_)
            | AnalyticLaw::Profile { .. }
            | AnalyticLaw::Twist(_) => (0.0, 0.0),
        }
    }

    /// S.
    pub(super) fn twist(&self) -> f64 {
        match *self {
            AnalyticLaw::Twist(amount) => amount,
            _ => 0.0,
        }
    }
}
