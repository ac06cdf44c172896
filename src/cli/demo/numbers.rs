//! Numbers for people: as many digits as mean something, one notation for one column.

/// Stands where there is no value.
pub const ABSENT: &str = "–";

/// Four significant digits; powers of ten where the number would be long.
pub fn short(x: f64) -> String {
    significant(x, 4)
}

/// Two significant digits, which is what an uncertainty or a bound is worth.
pub fn rough(x: f64) -> String {
    significant(x, 2)
}

/// [`rough`], or the mark of absence.
pub fn rough_or_absent(x: Option<f64>) -> String {
    x.map_or_else(|| ABSENT.to_owned(), rough)
}

/// [`short`], or the mark of absence.
pub fn short_or_absent(x: Option<f64>) -> String {
    x.map_or_else(|| ABSENT.to_owned(), short)
}

/// `digits` significant digits, fixed notation between 0.001 and 10 000.
pub fn significant(x: f64, digits: usize) -> String {
    let magnitude = x.abs();
    if x == 0.0 {
        "0".into()
    } else if (1e-3..1e4).contains(&magnitude) {
        fixed(x, decimals_of(magnitude, digits))
    } else {
        sign(format!("{x:.*e}", digits.saturating_sub(1)))
    }
}

/// Rounds `x` to the place of the second significant digit of its `uncertainty`; four digits when
/// there is none.
pub fn as_certain_as(x: f64, uncertainty: Option<f64>) -> String {
    match uncertainty {
        Some(u) if u > 0.0 && u.is_finite() => {
            let decimals = decimals_of(u, 2);
            if decimals <= 12 && x.abs() < 1e9 { fixed(x, decimals) } else { short(x) }
        }
        _ => short(x),
    }
}

/// Digits after the point so that `digits` significant ones are shown.
fn decimals_of(magnitude: f64, digits: usize) -> usize {
    let exponent = magnitude.log10().floor() as i32;
    usize::try_from(digits as i32 - 1 - exponent).unwrap_or(0)
}

fn fixed(x: f64, decimals: usize) -> String {
    let text = format!("{x:.decimals$}");
    // −0.00 says nothing that 0.00 does not.
    if text.trim_start_matches('-').bytes().all(|b| b == b'0' || b == b'.') {
        text.trim_start_matches('-').to_owned()
    } else {
        sign(text)
    }
}

fn sign(text: String) -> String {
    text.replace('-', "−")
}

/// The unit of the coefficient of a term of this degree, for heights in µm over positions in mm.
pub fn um_per_mm(degree: usize) -> String {
    const SUPERSCRIPTS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    match degree {
        0 => "µm".into(),
        1 => "µm/mm".into(),
        n => {
            let power: String =
                n.to_string().bytes().filter_map(|digit| SUPERSCRIPTS.get(usize::from(digit - b'0'))).collect();
            format!("µm/mm{power}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_follow_magnitude_and_uncertainty() {
        assert_eq!(short(0.0), "0");
        assert_eq!(short(12.3456), "12.35");
        assert_eq!(short(-0.012_345_6), "−0.01235");
        assert_eq!(short(1.234_56e-7), "1.235e−7");
        assert_eq!(short(9_876.54), "9877");
        assert_eq!(short(98_765.4), "9.877e4");
        assert_eq!(rough(0.047_74), "0.048");
        assert_eq!(as_certain_as(-12.3456, Some(0.034)), "−12.346");
        assert_eq!(as_certain_as(-0.000_4, Some(0.034)), "0.000");
        assert_eq!(as_certain_as(123_456.7, Some(2_000.0)), "123457");
        assert_eq!(um_per_mm(0), "µm");
        assert_eq!(um_per_mm(12), "µm/mm¹²");
    }
}
