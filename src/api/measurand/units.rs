//! Names of units, as read and written.

/// Canonical names of units, with the other spellings that are read.
const UNITS: [(&str, &[&str]); 6] = [
    ("nm", &["nanometer", "nanometre"]),
    // the micro sign and the Greek letter
    ("um", &["µm", "μm", "micron", "microns", "micrometer", "micrometre"]),
    ("mm", &["millimeter", "millimetre"]),
    ("in", &["inch", "inches"]),
    ("deg", &["°", "degree", "degrees"]),
    ("arcmin", &["′", "'", "minute of arc", "minutes of arc"]),
];

/// Units of length, and their size in millimetres.
pub const LENGTHS: [(&str, f64); 4] = [("nm", 1e-6), ("um", 1e-3), ("mm", 1.0), ("in", 25.4)];

/// Returns the canonical name of a unit; an unknown word is returned unchanged.
pub fn canonical(unit: &str) -> &str {
    UNITS.iter().find(|(_, others)| others.contains(&unit)).map_or(unit, |(name, _)| name)
}

/// Returns the size of a unit of length in millimetres.
pub fn millimetres(unit: &str) -> Option<f64> {
    LENGTHS.iter().find(|(name, _)| *name == unit).map(|(_, mm)| *mm)
}

/// Returns the size of a unit of length in micrometres.
pub fn micrometres(unit: &str) -> Option<f64> {
    Some(match unit {
        // 1e-6 and 1e-3 mm are not exact in binary
        "nm" => 1e-3,
        "um" => 1.0,
        other => 1e3 * millimetres(other)?,
    })
}

/// Returns the symbol of a unit, for texts.
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
