//! Numbers and counts as messages say them.
//!
//! A caller's number may be 1e-300 or 1e300, which `{}` writes with three hundred zeros.

use std::fmt;

/// Words of a message for a number above the range of double.
const BEYOND: &str = "more than 1.8e308";

/// A number in a message: in plain digits where that is short, else with an exponent. Nothing is
/// rounded away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown(pub f64);

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if size == f64::INFINITY {
            f.write_str(if self.0 > 0.0 { BEYOND } else { "less than -1.8e308" })
        } else if size == 0.0 || (1e-5..1e15).contains(&size) {
            self.0.fmt(f)
        } else {
            fmt::LowerExp::fmt(&self.0, f)
        }
    }
}

/// A figure in a message of which only the size matters: to three digits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size(pub f64);

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        rounded(self.0, 3).fmt(f)
    }
}

/// A number of things with their name: `1 entry`, `2 entries`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counted {
    /// Their number.
    pub count: usize,
    /// Name of one of them.
    pub one: &'static str,
    /// Name of several of them.
    pub many: &'static str,
}

/// `count` of what is called `one` or `many`.
pub fn counted(count: usize, one: &'static str, many: &'static str) -> Counted {
    Counted { count, one, many }
}

/// Entries of a list.
pub fn entries(count: usize) -> Counted {
    counted(count, "entry", "entries")
}

impl fmt::Display for Counted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.count, if self.count == 1 { self.one } else { self.many })
    }
}

/// `is` of one thing, `are` of any other number.
pub fn are(count: usize) -> &'static str {
    if count == 1 { "is" } else { "are" }
}

/// A number to so many significant digits.
pub fn rounded(x: f64, digits: usize) -> Shown {
    let places = digits.saturating_sub(1);
    Shown(format!("{x:.places$e}").parse().unwrap_or(x))
}

/// Things in a row, with commas between them.
pub fn listed<T: fmt::Display>(things: impl IntoIterator<Item = T> + Clone) -> impl fmt::Display {
    fmt::from_fn(move |f| {
        for (k, thing) in things.clone().into_iter().enumerate() {
            let between = if k == 0 { "" } else { ", " };
            write!(f, "{between}{thing}")?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_whole() {
        for (value, text) in [
            (0.0, "0"),
            (-2.5, "-2.5"),
            (0.1, "0.1"),
            (1e-5, "0.00001"),
            (999_999_999_999_999.0, "999999999999999"),
            (1e15, "1e15"),
            (-1e-300, "-1e-300"),
            (1.797_693_134_862_315_7e308, "1.7976931348623157e308"),
            (5e-324, "5e-324"),
        ] {
            assert_eq!(Shown(value).to_string(), text);
            assert_eq!(text.parse::<f64>(), Ok(value));
        }
        assert_eq!(Shown(f64::NAN).to_string(), "NaN");
        for (value, text) in [(0.799_66, "0.7997"), (123_456.7, "123500"), (-3.2e-7, "-3.2e-7"), (0.0, "0")] {
            assert_eq!(rounded(value, 4).to_string(), text);
        }
        assert_eq!([f64::NAN, f64::INFINITY].map(|x| rounded(x, 4).to_string()), ["NaN", "more than 1.8e308"]);
        assert_eq!(Shown(f64::NEG_INFINITY).to_string(), "less than -1.8e308");
        assert_eq!(
            [12.345_6, 4.966e298, f64::INFINITY].map(|x| Size(x).to_string()),
            ["12.3", "4.97e298", "more than 1.8e308"]
        );
    }

    #[test]
    fn one_is_not_many() {
        assert_eq!(entries(1).to_string(), "1 entry");
        assert_eq!(entries(0).to_string(), "0 entries");
        assert_eq!(counted(2, "weight", "weights").to_string(), "2 weights");
        assert_eq!([0, 1, 2].map(are), ["are", "is", "are"]);
        assert_eq!(listed([""; 0]).to_string(), "");
        assert_eq!(listed([1, 2, 3]).to_string(), "1, 2, 3");
    }
}
