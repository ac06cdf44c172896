//! Tolerances and classes of ISO 1328-1:2013.
//!
//! The formulas give class 5; every class is √2 wider than the one before. They hold within the
//! standard's scope only: outside of it there are no tolerances and no class, and [`OutOfScope`]
//! says which quantity lies where. Totals (F_α, F_β) are made of unrounded parts. Values are µm,
//! gear data mm.

use std::f64::consts::SQRT_2;

use super::Gear;
use flankfit_numerics::words::Shown;

/// Deviations that the standard gives tolerances for, in the order in which they are listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Characteristic {
    /// f_p.
    SinglePitch,
    /// F_p.
    CumulativePitch,
    /// F_r.
    Runout,
    /// f_Hα.
    ProfileSlope,
    /// f_fα.
    ProfileForm,
    /// F_α.
    ProfileTotal,
    /// f_Hβ.
    HelixSlope,
    /// f_fβ.
    HelixForm,
    /// F_β.
    HelixTotal,
}

impl Characteristic {
    /// All nine, in the order f_p, F_p, F_r, f_Hα, f_fα, F_α, f_Hβ, f_fβ, F_β.
    pub const ALL: [Characteristic; 9] = [
        Characteristic::SinglePitch,
        Characteristic::CumulativePitch,
        Characteristic::Runout,
        Characteristic::ProfileSlope,
        Characteristic::ProfileForm,
        Characteristic::ProfileTotal,
        Characteristic::HelixSlope,
        Characteristic::HelixForm,
        Characteristic::HelixTotal,
    ];

    /// The standard's symbol, in letters of ASCII: `f_Halpha`.
    pub fn symbol(self) -> &'static str {
        match self {
            Characteristic::SinglePitch => "f_p",
            Characteristic::CumulativePitch => "F_p",
            Characteristic::Runout => "F_r",
            Characteristic::ProfileSlope => "f_Halpha",
            Characteristic::ProfileForm => "f_falpha",
            Characteristic::ProfileTotal => "F_alpha",
            Characteristic::HelixSlope => "f_Hbeta",
            Characteristic::HelixForm => "f_fbeta",
            Characteristic::HelixTotal => "F_beta",
        }
    }
}

/// The finest class.
pub const FINEST: u8 = 1;
/// The coarsest class.
pub const COARSEST: u8 = 11;

/// The class that a measured value reaches; finer ones are smaller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// The finest class whose tolerance is not exceeded, [`FINEST`] to [`COARSEST`].
    Within(u8),
    /// Even the tolerance of the coarsest class is exceeded.
    Beyond,
}

/// Which tolerances decide the class.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = ToleranceRounding)
)]
pub enum Rounding {
    /// Those of the standard's tables.
    #[default]
    Rounded,
    /// As the formulas give them.
    Unrounded,
}

/// Quantity that limits the scope of the standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Quantity {
    /// z.
    Teeth,
    /// d.
    #[cfg_attr(feature = "contract", serde(rename = "reference_diameter_mm"))]
    ReferenceDiameter,
    /// m_n.
    #[cfg_attr(feature = "contract", serde(rename = "normal_module_mm"))]
    NormalModule,
    /// β.
    #[cfg_attr(feature = "contract", serde(rename = "helix_angle_deg"))]
    HelixAngle,
    /// b.
    #[cfg_attr(feature = "contract", serde(rename = "face_width_mm"))]
    FaceWidth,
}

/// A quantity for which the standard does not speak.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize))]
pub struct Excess {
    /// Which one.
    pub quantity: Quantity,
    /// Its value on this gear: a count, mm or degrees.
    pub value: f64,
    /// Range that the standard covers, both ends included.
    pub scope: [f64; 2],
}

/// The gear lies outside the scope of the standard.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "contract", derive(serde::Serialize))]
#[error("{}", not_covered(.outside))]
pub struct OutOfScope {
    /// Every quantity outside of it.
    pub outside: Vec<Excess>,
}

impl Quantity {
    /// Returns the field of a gear that has it.
    fn name(self) -> &'static str {
        match self {
            Quantity::Teeth => "teeth",
            Quantity::ReferenceDiameter => "reference_diameter_mm",
            Quantity::NormalModule => "normal_module_mm",
            Quantity::HelixAngle => "helix_angle_deg",
            Quantity::FaceWidth => "face_width_mm",
        }
    }
}

fn not_covered(outside: &[Excess]) -> String {
    let one = |e: &Excess| {
        let (name, [least, most]) = (e.quantity.name(), e.scope.map(Shown));
        format!("{name} = {} is not within {least} and {most}", Shown(e.value))
    };
    let each: Vec<String> = outside.iter().map(one).collect();
    format!("ISO 1328-1:2013 does not cover this gear: {}", each.join("; "))
}

/// Tolerances of a gear within the scope.
#[derive(Clone, Debug, PartialEq)]
pub struct Tolerances {
    /// Class 5, unrounded, in the order of [`Characteristic::ALL`]; those of the helix only where
    /// the face width is known.
    fifth: [Option<f64>; 9],
}

impl Tolerances {
    /// The tolerances of a gear. Without a face width there are none of the helix.
    pub fn new(gear: &Gear) -> Result<Self, OutOfScope> {
        let data = gear.data();
        let (d, m) = (2.0 * gear.reference_radius(), data.normal_module);
        let mut quantities = vec![
            (Quantity::Teeth, gear.teeth(), [5.0, 1000.0]),
            (Quantity::ReferenceDiameter, d, [5.0, 15_000.0]),
            (Quantity::NormalModule, m, [0.5, 70.0]),
            // 45° in radians and back is not always 45
            (Quantity::HelixAngle, (data.helix_angle.to_degrees() * 1e12).round() / 1e12, [0.0, 45.0]),
        ];
        quantities.extend(data.face_width.map(|b| (Quantity::FaceWidth, b, [4.0, 1200.0])));
        let excesses: Vec<Excess> = quantities
            .into_iter()
            .filter(|(_, value, [least, most])| !(value >= least && value <= most))
            .map(|(quantity, value, scope)| Excess { quantity, value, scope })
            .collect();
        if !excesses.is_empty() {
            return Err(OutOfScope { outside: excesses });
        }
        let cumulative = 0.002 * d + 0.55 * d.sqrt() + 0.7 * m + 12.0;
        let (profile_slope, profile_form) = (0.4 * m + 0.001 * d + 4.0, 0.55 * m + 5.0);
        let helix = data.face_width.map(|b| {
            let slope = 0.05 * d.sqrt() + 0.35 * b.sqrt() + 4.0;
            let form = 0.07 * d.sqrt() + 0.45 * b.sqrt() + 4.0;
            (slope, form)
        });
        let fifth = [
            Some(0.001 * d + 0.4 * m + 5.0),
            Some(cumulative),
            Some(0.9 * cumulative),
            Some(profile_slope),
            Some(profile_form),
            Some(profile_slope.hypot(profile_form)),
            helix.map(|(slope, _)| slope),
            helix.map(|(_, form)| form),
            helix.map(|(slope, form)| slope.hypot(form)),
        ];
        Ok(Tolerances { fifth })
    }

    /// The unrounded tolerance of a class, µm; `None` for classes that there are not and for the
    /// helix without a face width.
    ///
    /// ```
    /// use flankfit_gear::{Gear, GearData, tolerance::{Characteristic, Tolerances}};
    ///
    /// // f_p of class 5 is 0.001 d + 0.4 m_n + 5; each class further is wider by √2.
    /// let tolerances = Tolerances::new(&Gear::new(GearData::spur(50, 2.0))?)?;
    /// let pitch = |class| tolerances.unrounded(Characteristic::SinglePitch, class).unwrap();
    /// assert!((pitch(5) - 5.9).abs() < 1e-12);
    /// assert!((pitch(7) - 2.0 * pitch(5)).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn unrounded(&self, characteristic: Characteristic, class: u8) -> Option<f64> {
        (FINEST..=COARSEST).contains(&class).then_some(())?;
        self.fifth[characteristic as usize].map(|fifth| fifth * step(class))
    }

    /// The same as the standard's tables round it.
    pub fn rounded(&self, characteristic: Characteristic, class: u8) -> Option<f64> {
        self.unrounded(characteristic, class).map(rounded)
    }

    /// Rounded or not, as is asked for.
    pub fn tolerance(&self, characteristic: Characteristic, class: u8, rounding: Rounding) -> Option<f64> {
        match rounding {
            Rounding::Rounded => self.rounded(characteristic, class),
            Rounding::Unrounded => self.unrounded(characteristic, class),
        }
    }

    /// The class that a measured value (of either sign) reaches: the finest one whose tolerance it
    /// does not exceed. `None` where there is no tolerance or no number.
    pub fn class(&self, characteristic: Characteristic, value: f64, rounding: Rounding) -> Option<Class> {
        if value.is_nan() || self.fifth[characteristic as usize].is_none() {
            return None;
        }
        let tolerance = |class| self.tolerance(characteristic, class, rounding);
        let class = (FINEST..=COARSEST).find(|&class| tolerance(class).is_some_and(|t| value.abs() <= t));
        Some(class.map_or(Class::Beyond, Class::Within))
    }
}

/// (√2)^(class − 5), exact where it is a power of 2.
fn step(class: u8) -> f64 {
    let steps = i32::from(class) - 5;
    let whole = 2f64.powi(steps.div_euclid(2));
    if steps.rem_euclid(2) == 1 { whole * SQRT_2 } else { whole }
}

/// A tolerance in µm as the tables print it: above 10 to whole ones, from 5 to 10 to halves, below
/// 5 to tenths; halves away from 0.
///
/// ```
/// use flankfit_gear::tolerance::rounded;
///
/// assert_eq!([12.5, 7.3, 3.14].map(rounded), [13.0, 7.5, 3.1]);
/// ```
pub fn rounded(tolerance: f64) -> f64 {
    if tolerance > 10.0 {
        tolerance.round()
    } else if tolerance >= 5.0 {
        (2.0 * tolerance).round() / 2.0
    } else {
        (10.0 * tolerance).round() / 10.0
    }
}

/// Returns the classes up to the coarsest one, and the names of those that exceed it.
pub(crate) fn numbered<const N: usize>(named: [(&str, Option<Class>); N]) -> ([Option<u8>; N], Vec<String>) {
    let beyond = named.iter().filter(|(_, class)| *class == Some(Class::Beyond));
    let beyond = beyond.map(|(name, _)| (*name).to_owned()).collect();
    (named.map(|(_, class)| class.and_then(Class::number)), beyond)
}

impl Class {
    /// Returns the number of the class; `None` above the coarsest one.
    pub fn number(self) -> Option<u8> {
        match self {
            Class::Within(number) => Some(number),
            Class::Beyond => None,
        }
    }
}

/// The coarsest of several classes; `None` when there are none.
pub fn overall(classes: impl IntoIterator<Item = Class>) -> Option<Class> {
    classes.into_iter().max()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_those_of_the_standard() {
        assert_eq!(step(5), 1.0);
        assert_eq!(step(7), 2.0);
        assert_eq!(step(3), 0.5);
        assert_eq!(step(1), 0.25);
        assert_eq!(step(11), 8.0);
        assert!((step(6) - SQRT_2).abs() < 1e-15);
        assert!((step(4) - 1.0 / SQRT_2).abs() < 1e-15);
    }

    #[test]
    fn rounding_follows_the_size() {
        for (raw, printed) in [
            (17.19, 17.0),
            (10.4, 10.0),
            (10.0, 10.0),
            (9.76, 10.0),
            (7.824, 8.0),
            (5.0, 5.0),
            (4.94, 4.9),
            (0.55, 0.6),
        ] {
            assert_eq!(rounded(raw), printed, "{raw}");
        }
    }

    #[test]
    fn the_coarsest_class_is_the_overall_class() {
        assert_eq!(overall([Class::Within(3), Class::Within(7), Class::Within(1)]), Some(Class::Within(7)));
        assert_eq!(overall([Class::Beyond, Class::Within(11)]), Some(Class::Beyond));
        assert_eq!(overall([]), None);
    }
}
