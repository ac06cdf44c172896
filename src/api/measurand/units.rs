//! Units as they are read and written: the one place that knows their names.

/// Names by which units are written, with the other spellings that are read.
const UNITS: [(&str, &[&str]); 6] = [
    ("nm", &["nanometer", "nanometre"]),
    // the micro sign and the Greek letter
    ("um", &["µm", "μm", "micron", "microns", "micrometer", "micrometre"]),
    ("mm", &["millimeter", "millimetre"]),
    ("in", &["inch", "inches"]),
    ("deg", &["°", "degree", "degrees"]),
    ("arcmin", &["′", "'", "minute of arc", "minutes of arc"]),
];

/// Units of length, and what of a millimetre each is.
pub const LENGTHS: [(&str, f64); 4] = [("nm", 1e-6), ("um", 1e-3), ("mm", 1.0), ("in", 25.4)];

/// The name by which a unit is written; a word of the caller's own stays as it is.
pub fn canonical(unit: &str) -> &str {
    UNITS.iter().find(|(_, others)| others.contains(&unit)).map_or(unit, |(name, _)| name)
}

/// Millimetres in a unit of length.
pub fn millimetres(unit: &str) -> Option<f64> {
    LENGTHS.iter().find(|(name, _)| *name == unit).map(|(_, mm)| *mm)
}

/// Micrometres in a unit of length.
pub fn micrometres(unit: &str) -> Option<f64> {
    Some(match unit {
        // 1e-6 and 1e-3 of a millimetre are rounded
        "nm" => 1e-3,
        "um" => 1.0,
        other => 1e3 * millimetres(other)?,
    })
}

/// A unit as texts write it.
pub fn sign(unit: &str) -> &str {
    match unit {
        "um" => "µm",
        "deg" => "°",
        "arcmin" => "′",
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_has_one_name_and_one_sign() {
        for (read, written, shown) in [
            ("µm", "um", "µm"),
            ("\u{3bc}m", "um", "µm"),
            ("um", "um", "µm"),
            ("inch", "in", "in"),
            ("′", "arcmin", "′"),
            ("°", "deg", "°"),
            ("furlong", "furlong", "furlong"),
        ] {
            assert_eq!((canonical(read), sign(canonical(read))), (written, shown), "{read}");
        }
        let lengths = ["nm", "um", "mm", "in", "deg"].map(|unit| (millimetres(unit), micrometres(unit)));
        let known = [(1e-6, 1e-3), (1e-3, 1.0), (1.0, 1e3), (25.4, 25_400.0)].map(|(mm, um)| (Some(mm), Some(um)));
        assert_eq!((&lengths[..4], lengths[4]), (&known[..], (None, None)));
    }
}
