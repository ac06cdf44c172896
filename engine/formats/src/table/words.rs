//! Meanings and units of columns, and the words that name them, flanks and traces, in English and
//! German.

use flankfit_gear::{Kind, Side};

/// Meaning of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = TableMeaning)
)]
pub enum Meaning {
    /// Place along the profile by its roll length.
    RollLength,
    /// Place along the profile by its diameter.
    Diameter,
    /// Place along the profile by its roll angle.
    RollAngle,
    /// Place along the face width.
    FaceWidth,
    /// Height: the deviation of the flank.
    Deviation,
    /// First abscissa of a surface that is none of a flank.
    U,
    /// Second abscissa of such a surface.
    V,
    /// Coordinate of a point, or abscissa of a curve.
    X,
    /// Coordinate of a point, or height of a curve.
    Y,
    /// Coordinate of a point, or height of a surface.
    Z,
    /// Component of a direction along x.
    I,
    /// Component of a direction along y.
    J,
    /// Component of a direction along z.
    K,
    /// Weight of a node.
    Weight,
    /// Number or name of a tooth.
    Tooth,
    /// Left or right flank.
    Flank,
    /// Kind of a trace: profile or helix.
    Trace,
    /// Name or number of a point.
    Id,
    /// A column that is not read.
    Ignore,
}

impl Meaning {
    /// Every meaning with its name.
    pub const ALL: [(Meaning, &'static str); 19] = [
        (Meaning::RollLength, "roll_length"),
        (Meaning::Diameter, "diameter"),
        (Meaning::RollAngle, "roll_angle"),
        (Meaning::FaceWidth, "face_width"),
        (Meaning::Deviation, "deviation"),
        (Meaning::U, "u"),
        (Meaning::V, "v"),
        (Meaning::X, "x"),
        (Meaning::Y, "y"),
        (Meaning::Z, "z"),
        (Meaning::I, "i"),
        (Meaning::J, "j"),
        (Meaning::K, "k"),
        (Meaning::Weight, "weight"),
        (Meaning::Tooth, "tooth"),
        (Meaning::Flank, "flank"),
        (Meaning::Trace, "trace"),
        (Meaning::Id, "id"),
        (Meaning::Ignore, "ignore"),
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(meaning, _)| *meaning == self).map_or("ignore", |(_, name)| name)
    }

    /// True if its cells are numbers; those of others are texts.
    pub fn is_number(self) -> bool {
        !matches!(self, Meaning::Tooth | Meaning::Flank | Meaning::Trace | Meaning::Id | Meaning::Ignore)
    }

    /// True if a unit of that kind belongs to it.
    pub fn takes(self, unit: Unit) -> bool {
        let angle = matches!(unit, Unit::Degree | Unit::ArcMinute | Unit::Radian);
        match self {
            Meaning::RollAngle => angle,
            Meaning::U | Meaning::V => true,
            Meaning::RollLength | Meaning::Diameter | Meaning::FaceWidth | Meaning::Deviation => !angle,
            Meaning::X | Meaning::Y | Meaning::Z => !angle,
            _ => false,
        }
    }

    /// The unit that is assumed where none is given.
    pub fn usual_unit(self) -> Option<Unit> {
        match self {
            Meaning::RollLength | Meaning::Diameter | Meaning::FaceWidth => Some(Unit::Millimetre),
            Meaning::RollAngle => Some(Unit::Degree),
            Meaning::Deviation => Some(Unit::Micrometre),
            _ => None,
        }
    }
}

/// Unit of a column of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = TableUnit)
)]
pub enum Unit {
    /// nm
    #[cfg_attr(feature = "contract", serde(rename = "nm"))]
    Nanometre,
    /// µm
    #[cfg_attr(feature = "contract", serde(rename = "um", alias = "µm", alias = "μm"))]
    Micrometre,
    /// mm
    #[cfg_attr(feature = "contract", serde(rename = "mm"))]
    Millimetre,
    /// Inch.
    #[cfg_attr(feature = "contract", serde(rename = "in"))]
    Inch,
    /// Degree.
    #[cfg_attr(feature = "contract", serde(rename = "deg", alias = "°"))]
    Degree,
    /// Minute of arc.
    #[cfg_attr(feature = "contract", serde(rename = "arcmin", alias = "′"))]
    ArcMinute,
    /// rad
    #[cfg_attr(feature = "contract", serde(rename = "rad"))]
    Radian,
}

/// Spellings of units in headers, in lower case.
const UNITS: [(Unit, &[&str]); 7] = [
    (Unit::Nanometre, &["nm"]),
    (Unit::Micrometre, &["um", "µm", "μm", "mikrometer", "micrometer", "micron", "microns", "my"]),
    (Unit::Millimetre, &["mm", "millimeter", "millimetre"]),
    (Unit::Inch, &["in", "inch", "inches", "zoll", "\""]),
    (Unit::Degree, &["deg", "°", "grad", "degree", "degrees"]),
    (Unit::ArcMinute, &["arcmin", "′", "'", "min"]),
    (Unit::Radian, &["rad", "radian", "bogenmaß"]),
];

impl Unit {
    /// Every unit with its name.
    pub const ALL: [(Unit, &'static str); 7] = [
        (Unit::Nanometre, "nm"),
        (Unit::Micrometre, "um"),
        (Unit::Millimetre, "mm"),
        (Unit::Inch, "in"),
        (Unit::Degree, "deg"),
        (Unit::ArcMinute, "arcmin"),
        (Unit::Radian, "rad"),
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(unit, _)| *unit == self).map_or("mm", |(_, name)| name)
    }

    /// Millimetres in a unit of length.
    pub fn millimetres(self) -> Option<f64> {
        match self {
            Unit::Nanometre => Some(1e-6),
            Unit::Micrometre => Some(1e-3),
            Unit::Millimetre => Some(1.0),
            Unit::Inch => Some(25.4),
            Unit::Degree | Unit::ArcMinute | Unit::Radian => None,
        }
    }

    /// The unit that a word is, with or without brackets around it.
    pub fn of_word(word: &str) -> Option<Self> {
        let word = word.trim_matches(|c: char| c.is_whitespace() || matches!(c, '[' | ']' | '(' | ')')).to_lowercase();
        UNITS.iter().find(|(_, words)| words.contains(&word.as_str())).map(|(unit, _)| *unit)
    }

    /// The unit that a header names: in brackets, or as a word of its own.
    pub(super) fn of_header(header: &str) -> Option<Self> {
        let brackets = header.split(['[', '(']).skip(1).filter_map(|rest| rest.split([']', ')']).next());
        if let Some(unit) = brackets.filter_map(Unit::of_word).next() {
            return Some(unit);
        }
        let words: Vec<&str> = words(header).collect();
        let last = words.len().checked_sub(1)?;
        // `in` and `min` are also words of sentences
        let is_unit = |(k, word): (usize, &&str)| {
            let unit = Unit::of_word(word)?;
            (k == last || !["in", "min", "my"].contains(&word.to_lowercase().as_str())).then_some(unit)
        };
        words.iter().enumerate().skip(1).rev().find_map(is_unit)
    }

    /// The unit that a header names in brackets or by a word, where no such unit is known of the
    /// meaning.
    pub(super) fn unknown_in(header: &str, meaning: Meaning) -> Option<&str> {
        let brackets = header.split('[').skip(1).filter_map(|rest| rest.split(']').next()).map(str::trim);
        let known = |text: &&str| Unit::of_word(text).is_some_and(|unit| meaning.takes(unit));
        if brackets.clone().any(|text| known(&text)) {
            return None;
        }
        let named = |word: &&str| UNKNOWN.contains(&word.to_lowercase().as_str());
        brackets.filter(|text| !text.is_empty()).chain(words(header).skip(1).filter(named)).next()
    }
}

/// Units of length that are in use and not known here.
const UNKNOWN: [&str; 7] = ["mil", "mils", "thou", "cm", "µin", "uin", "microinch"];

/// The words of a header; letters, digits and signs of units belong to them.
fn words(header: &str) -> impl Iterator<Item = &str> {
    header.split(|c: char| !(c.is_alphanumeric() || matches!(c, '°' | '′' | 'µ'))).filter(|word| !word.is_empty())
}

/// Names that are a meaning as a whole, in lower case with single blanks.
const WHOLE: [(Meaning, &[&str]); 18] = [
    (Meaning::RollLength, &["rl", "roll"]),
    (Meaning::Diameter, &["d", "dia", "ø", "diam"]),
    (Meaning::RollAngle, &["ξ", "xi"]),
    (Meaning::FaceWidth, &["face", "width", "breite", "axial"]),
    (Meaning::Deviation, &["δ", "delta", "dev", "abw", "value", "wert", "height", "höhe", "hoehe", "dn"]),
    (Meaning::U, &["u"]),
    (Meaning::V, &["v"]),
    (Meaning::X, &["x"]),
    (Meaning::Y, &["y"]),
    (Meaning::Z, &["z"]),
    (Meaning::I, &["i", "nx"]),
    (Meaning::J, &["j", "ny"]),
    (Meaning::K, &["k", "nz"]),
    (Meaning::Weight, &["weight", "gewicht", "w"]),
    (Meaning::Tooth, &["tooth", "zahn"]),
    (Meaning::Flank, &["flank", "flanke", "side", "seite"]),
    (Meaning::Trace, &["trace", "kind", "spur"]),
    (Meaning::Id, &["id", "no", "nr", "point", "punkt", "name", "number", "nummer", "index"]),
];

/// Parts of names, in lower case, that decide wherever they are.
const PARTS: [(Meaning, &[&str]); 8] = [
    (Meaning::RollAngle, &["roll angle", "rollwinkel", "wälzwinkel", "waelzwinkel", "angle of roll"]),
    (
        Meaning::RollLength,
        &[
            "roll length",
            "rolllength",
            "rollweg",
            "wälzweg",
            "waelzweg",
            "wälzlänge",
            "waelzlaenge",
            "length of roll",
            "rolllänge",
        ],
    ),
    (Meaning::Diameter, &["diameter", "durchmesser"]),
    (
        Meaning::FaceWidth,
        &[
            "face width",
            "facewidth",
            "zahnbreite",
            "flankenbreite",
            "axial position",
            "breitenposition",
            "flankenrichtung",
        ],
    ),
    (Meaning::Deviation, &["deviation", "abweichung", "error", "fehler", "messwert", "aufmaß", "aufmass"]),
    (Meaning::Tooth, &["tooth", "zahn nr", "zahnnr", "zahnnummer"]),
    (Meaning::Flank, &["flank side", "flankenseite"]),
    (Meaning::Id, &["punkt nr", "punktnr", "point number", "sample index"]),
];

/// The meaning that a header names.
pub(super) fn meaning_of(header: &str) -> Option<Meaning> {
    let plain = header.split(['[', '(']).next().unwrap_or_default().to_lowercase();
    let mut named: Vec<&str> = words(&plain).collect();
    // a unit behind a name is no part of it: `Breite in mm`
    while named.len() > 1 && named.last().is_some_and(|last| Unit::of_word(last).is_some()) {
        named.pop();
    }
    let name = named.join(" ");
    let whole = WHOLE.iter().find(|(_, names)| names.contains(&name.as_str()));
    let part = || PARTS.iter().find(|(_, parts)| parts.iter().any(|part| name.contains(part)));
    whole.map(|(meaning, _)| *meaning).or_else(|| part().map(|(meaning, _)| *meaning))
}

/// Words for flanks, in lower case.
const FLANKS: [(Side, &[&str]); 2] =
    [(Side::Left, &["left", "l", "links", "linke", "lf"]), (Side::Right, &["right", "r", "rechts", "rechte", "rf"])];

/// The flank that a text begins with.
pub(super) fn flank_of(text: &str) -> Option<Side> {
    let word = text.split_whitespace().next()?.to_lowercase();
    FLANKS.iter().find(|(_, words)| words.contains(&word.as_str())).map(|(side, _)| *side)
}

/// The words for a flank.
pub(super) fn words_of(side: Side) -> String {
    FLANKS.iter().find(|(own, _)| *own == side).map_or(String::new(), |(_, words)| words.join(", "))
}

/// The kind of a trace.
pub(super) fn kind_of(text: &str) -> Option<Kind> {
    match text.to_lowercase().as_str() {
        "lead" | "helix" | "flankenlinie" => Some(Kind::Helix),
        "profile" | "profil" => Some(Kind::Profile),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_name_meanings_and_units() {
        for (header, meaning, unit) in [
            ("u", Some(Meaning::U), None),
            ("Rollweg [mm]", Some(Meaning::RollLength), Some(Unit::Millimetre)),
            ("roll_length_mm", Some(Meaning::RollLength), Some(Unit::Millimetre)),
            ("Wälzwinkel (°)", Some(Meaning::RollAngle), Some(Unit::Degree)),
            ("roll angle/rad", Some(Meaning::RollAngle), Some(Unit::Radian)),
            ("Abweichung in µm", Some(Meaning::Deviation), Some(Unit::Micrometre)),
            ("deviation_um_DIN_sign", Some(Meaning::Deviation), Some(Unit::Micrometre)),
            ("Deviation (in)", Some(Meaning::Deviation), Some(Unit::Inch)),
            ("z_mm", Some(Meaning::Z), Some(Unit::Millimetre)),
            ("Zahnbreite", Some(Meaning::FaceWidth), None),
            ("Breite in mm", Some(Meaning::FaceWidth), Some(Unit::Millimetre)),
            ("d [mm]", Some(Meaning::Diameter), Some(Unit::Millimetre)),
            ("tooth_tag", Some(Meaning::Tooth), None),
            ("Flanke", Some(Meaning::Flank), None),
            ("sample_index_of_480", Some(Meaning::Id), None),
            ("temperature", None, None),
            ("mm", None, None),
        ] {
            assert_eq!((meaning_of(header), Unit::of_header(header)), (meaning, unit), "{header}");
        }
        for (header, meaning, unknown) in [
            ("deviation [mil]", Meaning::Deviation, Some("mil")),
            ("Abweichung [0.001 mm]", Meaning::Deviation, Some("0.001 mm")),
            ("deviation [deg]", Meaning::Deviation, Some("deg")),
            ("z in cm", Meaning::FaceWidth, Some("cm")),
            ("deviation [left] [µm]", Meaning::Deviation, None),
            ("deviation_um_DIN_sign", Meaning::Deviation, None),
            ("roll length (nominal)", Meaning::RollLength, None),
        ] {
            assert_eq!(Unit::unknown_in(header, meaning), unknown, "{header}");
        }
        for (meaning, name) in Meaning::ALL {
            assert_eq!(meaning.name(), name);
        }
        for (unit, name) in Unit::ALL {
            assert_eq!((unit.name(), Unit::of_word(name)), (name, Some(unit)));
        }
    }
}
