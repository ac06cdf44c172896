//! A near dependency in words.

use std::fmt::Write as _;

use super::explained::pair_index;

/// Number of terms that a sentence names; `terms` has all of them.
const NAMED: usize = 4;

/// Returns the sentence for the reader. `pair` is the cosine of the two leading terms, if they are
/// nearly parallel without the others; `consolation` names the basis and the consequence if the
/// basis is the cause.
#[inline(never)]
pub(super) fn sentence(
    names: &[String],
    cosine: Option<f64>,
    r_squared: Option<f64>,
    index: Option<f64>,
    pair: Option<f64>,
    consolation: Option<(&str, &str)>,
) -> String {
    // as many digits as it takes to see the difference from 1
    let near_one = |x: f64| {
        let digits = (-(1.0 - x.abs()).max(1e-12).log10()).ceil().clamp(3.0, 12.0) as i32;
        let unit = 10f64.powi(digits);
        (x * unit).round() / unit
    };
    let mut text = String::with_capacity(192);
    let place = consolation.map_or(" at these nodes", |(place, _)| place);
    let ends = match (names, cosine, r_squared) {
        ([a, b], Some(cosine), _) => {
            let parallel = if cosine < 0.0 { "opposite" } else { "parallel" };
            for part in [a, " and ", b, " are nearly ", parallel, place, " (cos = "] {
                text.push_str(part);
            }
            append(&mut text, near_one(cosine));
            text.push_str(", ");
            "): only a combination of them is well determined"
        }
        ([a, others @ ..], _, Some(r_squared)) => {
            text.push_str(a);
            let (named, more) = others.split_at(others.len().min(NAMED - 1));
            for (k, name) in named.iter().enumerate() {
                text.push_str(if k == 0 { " is nearly a linear combination of " } else { ", " });
                text.push_str(name);
            }
            if !more.is_empty() {
                text.push_str(" and ");
                append(&mut text, more.len());
                text.push_str(" more");
            }
            text.push_str(place);
            text.push_str(" (R² = ");
            append(&mut text, near_one(r_squared));
            text.push_str(", ");
            "): their coefficients cannot be separated"
        }
        ([a, ..], _, _) => {
            for part in ["the column ", a, " is nearly 0", place, " ("] {
                text.push_str(part);
            }
            ")"
        }
        ([], _, _) => return text,
    };
    append_index(&mut text, index);
    text.push_str(consolation.map_or(ends, |(_, follows)| follows));
    if let (Some(cosine), [a, b, ..]) = (pair, names) {
        for part in ["; of them ", a, " and ", b, " alone have cos = "] {
            text.push_str(part);
        }
        append(&mut text, near_one(cosine));
        text.push_str(", ");
        append_index(&mut text, Some(pair_index(cosine)));
    }
    text
}

fn append_index(text: &mut String, index: Option<f64>) {
    text.push_str("condition index ");
    match index.filter(|index| index.is_finite()) {
        None => text.push_str("infinite"),
        // condition indices are read by their order of magnitude
        Some(index) if index < 1e15 => append(text, index.round() as u64),
        Some(index) => append(text, format_args!("{index:.1e}")),
    }
}

fn append(text: &mut String, value: impl std::fmt::Display) {
    // writing to a String does not fail
    let _written = write!(text, "{value}");
}
