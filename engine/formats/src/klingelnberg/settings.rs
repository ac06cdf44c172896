//! Meaning of the header's codes: the gear, the measuring and evaluation ranges, the probe, the
//! rules of the evaluation.

use super::{
    super::{
        file_error::shown,
        gear_facts::{GearFacts, radians, teeth},
        note::{Notes, Remark},
    },
    Header, HeaderLine,
};
use flankfit_gear::{Hand, Side, evaluation::runout::Counting};

/// Codes whose fields are numbers.
const NUMBERS: [u32; 27] =
    [21, 22, 23, 24, 25, 26, 27, 272, 28, 281, 41, 42, 43, 431, 432, 44, 45, 46, 48, 49, 61, 62, 63, 64, 65, 68, 69];

/// One of something for each flank.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sides<T> {
    /// Value for left flanks.
    pub left: T,
    /// Value for right flanks.
    pub right: T,
}

impl<T> Sides<T> {
    /// The one of this flank.
    pub fn of(&self, side: Side) -> &T {
        match side {
            Side::Left => &self.left,
            Side::Right => &self.right,
        }
    }
}

/// A stretch as the file gives it, start first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Start of the range.
    pub start: f64,
    /// End of the range.
    pub end: f64,
}

/// Quantity in which the places of a profile are given (the key `PROFILE`).
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ProfileAxis {
    /// mm.
    Diameter,
    /// mm.
    RollLength,
    /// Degrees.
    RollAngle,
    /// A word of no known meaning.
    Unknown(String),
}

/// Codes 41 to 45, 431, 432 and 65, 68, 69.
#[derive(Clone, Debug, PartialEq)]
pub struct ProfileSetup {
    /// Coordinate of the profiles.
    pub axis: ProfileAxis,
    /// Measuring range.
    pub measured: Sides<Option<Range>>,
    /// Evaluation range.
    pub evaluated: Sides<Option<Range>>,
    /// Tip relief.
    pub tip_relief: Sides<Option<Range>>,
    /// L_α, mm.
    pub length: Sides<Option<f64>>,
    /// Places on the face width, mm: in the middle, `<u>` and `<o>`.
    pub middle: Sides<Option<f64>>,
    /// Lower place on the face width, `<u>`.
    pub lower: Sides<Option<f64>>,
    /// Upper place on the face width, `<o>`.
    pub upper: Sides<Option<f64>>,
}

/// Codes 61 to 64 and 46, 48, 49. Lengths mm from the start of the face width.
#[derive(Clone, Debug, PartialEq)]
pub struct HelixSetup {
    /// Measuring range.
    pub measured: Sides<Option<Range>>,
    /// Evaluation range.
    pub evaluated: Sides<Option<Range>>,
    /// Measuring circles, diameters in mm: in the middle, `<f>` and `<k>`.
    pub middle: Sides<Option<f64>>,
    /// Inner measuring circle, `<f>`.
    pub inner: Sides<Option<f64>>,
    /// Outer measuring circle, `<k>`.
    pub outer: Sides<Option<f64>>,
}

/// A reference length: the instrument's choice, its word for it, and the length to which the
/// tolerances refer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Length {
    /// Number of the instrument's choice.
    pub setting: Option<i64>,
    /// `Z`, `M1-M2`
    pub word: Option<String>,
    /// mm.
    pub length: Sides<Option<f64>>,
}

/// The three numbers of a plus-material rule, as stored: the rule, total and form.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PlusMaterial {
    /// Number of the rule.
    pub rule: Option<i64>,
    /// Number that belongs to the total deviation.
    pub total: Option<i64>,
    /// Number that belongs to the form deviation.
    pub form: Option<i64>,
}

/// The section that deviations are taken in (code 183).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SectionPlane {
    /// Plane at right angles to the axis.
    Transverse,
    /// Plane at right angles to the tooth.
    Normal,
    /// Plane through the axis.
    Axial,
}

/// Signs, reference lengths and plus material: how the instrument evaluates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rules {
    /// Code 161: the direction in which teeth are counted.
    pub counting: Option<Counting>,
    /// Code 163: 0 where tables are by teeth, −1 by spaces.
    pub by_spaces: Option<i64>,
    /// Code 164: which flank is the left one, 0 by VDI and DIN, 1 by US custom.
    pub flank_names: Option<i64>,
    /// Code 165: 0 VDI, 1 DIN, others.
    pub helix_slope_reference: Option<i64>,
    /// The signs that code 165 prints for left and right, `+` as true.
    pub helix_slope_signs: Sides<Option<bool>>,
    /// Code 178: 0 VDI, 1 DIN.
    pub helix_sign: Option<i64>,
    /// Codes 179 and 89, 90.
    pub helix_length: Length,
    /// Codes 180 and 82, 83.
    pub profile_length: Length,
    /// Code 181.
    pub helix_plus_material: PlusMaterial,
    /// Code 182.
    pub profile_plus_material: PlusMaterial,
    /// Code 183.
    pub section: Option<SectionPlane>,
}

impl Header {
    /// The gear as far as the header describes it (codes 21 to 27 and 272). Hand and kind of teeth
    /// are words; German and English ones are known, and a negative helix angle is a left-hand one.
    pub fn gear(&self, notes: &mut Notes) -> GearFacts {
        for line in self.lines.iter().filter(|line| NUMBERS.contains(&line.code)) {
            if let Some(found) = line.unreadable() {
                notes.push(line.line, Remark::ValueNotRead { code: line.code, found: shown(found) });
            }
        }
        let mut length = |code| self.in_unit(code, &["mm"], notes);
        let normal_module = length(21);
        let mut facts = GearFacts {
            teeth: self.number(22).and_then(teeth),
            normal_module,
            face_width: length(26),
            tip_diameter: length(27),
            root_diameter: length(272),
            ..GearFacts::default()
        };
        // x, or x m_n where the label says that it is a length
        facts.profile_shift = match self.get(25).and_then(HeaderLine::unit) {
            Some(_) => length(25).zip(normal_module).map(|(shift, module)| shift / module),
            None => self.number(25),
        };
        if let Some(line) = self.get(22) {
            let words = line.words();
            let says = |list: &[&str]| list.iter().any(|word| words.contains(word));
            if says(&["innen", "intern"]) || line.numbers().next().is_some_and(|teeth| teeth < 0.0) {
                facts.internal = Some(true);
            } else if says(&["außen", "aussen", "extern"]) {
                facts.internal = Some(false);
            }
        }
        if let Some(setting) = self.preamble.iter().find(|setting| setting.key == "ANGLE")
            && !setting.value.to_lowercase().starts_with("dec")
        {
            notes.push(setting.line, Remark::AnglesNotDecimal(setting.value.clone()));
            return facts;
        }
        const DEGREES: [&str; 5] = ["grad", "deg", "degree", "degrees", "°"];
        facts.pressure_angle = self.in_unit(24, &DEGREES, notes).map(radians);
        if let Some(line) = self.get(23) {
            facts.hand = line.words().split_whitespace().find_map(hand);
            if let Some(angle) = self.in_unit(23, &DEGREES, notes) {
                facts.set_helix_angle(radians(angle));
            }
        }
        facts
    }

    /// Returns the first number of a code, if its label has one of these units or no unit.
    fn in_unit(&self, code: u32, units: &[&'static str], notes: &mut Notes) -> Option<f64> {
        let line = self.get(code)?;
        let value = line.numbers().next()?;
        match line.unit().filter(|unit| !units.contains(&unit.to_lowercase().as_str())) {
            None => Some(value),
            Some(unit) => {
                notes.push(line.line, Remark::UnitNotKnown { code, unit: shown(unit), wanted: units[0] });
                None
            }
        }
    }

    /// The values of a code for left and right; a single one holds for both.
    pub fn pair(&self, code: u32) -> Sides<Option<f64>> {
        let Some(line) = self.get(code) else { return Sides::default() };
        let values = line.settings();
        let first = |field: &String| field.split_ascii_whitespace().find_map(super::super::source::number);
        if let [left, right, ..] = values
            && (first(right).is_some() || left.is_empty())
        {
            return Sides { left: first(left), right: first(right) };
        }
        let mut numbers = line.numbers();
        let left = numbers.next();
        Sides { left, right: numbers.next().or(left) }
    }

    fn range(&self, start: u32, end: u32) -> Sides<Option<Range>> {
        let (start, end) = (self.pair(start), self.pair(end));
        let range = |start: Option<f64>, end: Option<f64>| Some(Range { start: start?, end: end? });
        Sides { left: range(start.left, end.left), right: range(start.right, end.right) }
    }

    /// Quantity of profile places. Without a word for it they are diameters, which every known file
    /// has.
    pub fn profile_axis(&self) -> ProfileAxis {
        let Some(word) = self.preamble("PROFILE") else { return ProfileAxis::Diameter };
        let small = word.to_lowercase();
        let says = |list: &[&str]| list.iter().any(|word| small.contains(word));
        if says(&["diam", "durchm"]) {
            ProfileAxis::Diameter
        } else if says(&["angle", "winkel", "degree", "grad"]) {
            ProfileAxis::RollAngle
        } else if says(&["length", "länge", "laenge", "roll", "wälz", "waelz"]) {
            ProfileAxis::RollLength
        } else {
            ProfileAxis::Unknown(word.into())
        }
    }

    /// Settings with which profiles were measured and evaluated.
    pub fn profile_setup(&self) -> ProfileSetup {
        ProfileSetup {
            axis: self.profile_axis(),
            measured: self.range(41, 44),
            evaluated: self.range(42, 43),
            tip_relief: self.range(431, 432),
            length: self.pair(45),
            middle: self.pair(65),
            lower: self.pair(68),
            upper: self.pair(69),
        }
    }

    /// Settings with which leads were measured and evaluated.
    pub fn helix_setup(&self) -> HelixSetup {
        HelixSetup {
            measured: self.range(61, 64),
            evaluated: self.range(62, 63),
            middle: self.pair(46),
            inner: self.pair(48),
            outer: self.pair(49),
        }
    }

    /// Rules of the evaluation: reference lengths, plus material, section.
    pub fn rules(&self) -> Rules {
        let whole = |code: u32| self.get(code).and_then(|line| setting(line, 0));
        let length = |code: u32, tolerances: [u32; 2]| Length {
            setting: whole(code),
            word: self.get(code).and_then(|line| line.settings().get(1).cloned()).filter(|word| !word.is_empty()),
            length: Sides {
                left: self.get(tolerances[0]).and_then(|line| line.numbers().last()),
                right: self.get(tolerances[1]).and_then(|line| line.numbers().last()),
            },
        };
        let plus = |code: u32| {
            let value = |at: usize| self.get(code).and_then(|line| setting(line, at));
            PlusMaterial { rule: value(0), total: value(1), form: value(2) }
        };
        Rules {
            counting: whole(161).and_then(|counting| match counting {
                0 => Some(Counting::Clockwise),
                1 => Some(Counting::Counterclockwise),
                _ => None,
            }),
            by_spaces: whole(163),
            flank_names: whole(164),
            helix_slope_reference: whole(165),
            helix_slope_signs: self.get(165).map(signs).unwrap_or_default(),
            helix_sign: whole(178),
            helix_length: length(179, [89, 90]),
            profile_length: length(180, [82, 83]),
            helix_plus_material: plus(181),
            profile_plus_material: plus(182),
            section: whole(183).and_then(|section| match section {
                0 => Some(SectionPlane::Transverse),
                1 => Some(SectionPlane::Normal),
                2 => Some(SectionPlane::Axial),
                _ => None,
            }),
        }
    }
}

/// The whole number that is a line's setting at a place.
fn setting(line: &HeaderLine, at: usize) -> Option<i64> {
    line.settings().get(at)?.split_ascii_whitespace().next()?.parse().ok()
}

/// `L: + : R: -`
fn signs(line: &HeaderLine) -> Sides<Option<bool>> {
    let fields = line.settings();
    let of = |name: &str| {
        let at = fields.iter().position(|field| field == name)?;
        match fields.get(at + 1)?.as_str() {
            "+" => Some(true),
            "-" => Some(false),
            _ => None,
        }
    };
    Sides { left: of("L"), right: of("R") }
}

/// The hand that a word names.
fn hand(word: &str) -> Option<Hand> {
    if word.starts_with("recht") || word.starts_with("right") {
        Some(Hand::Right)
    } else if word.starts_with("link") || word.starts_with("left") {
        Some(Hand::Left)
    } else {
        None
    }
}
