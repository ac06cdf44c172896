//! Dialect of a table: found from the lines that hold numbers.

use std::{borrow::Cow, cmp::Reverse, collections::BTreeMap};

use super::{
    Decimal, Separator,
    rows::{Row, split, value},
};

/// Every pair, the likelier one first where both read the same numbers.
const ALL: [(Separator, Decimal); 8] = [
    (Separator::Tab, Decimal::Point),
    (Separator::Semicolon, Decimal::Point),
    (Separator::Comma, Decimal::Point),
    (Separator::Spaces, Decimal::Point),
    (Separator::Tab, Decimal::Comma),
    (Separator::Semicolon, Decimal::Comma),
    (Separator::Comma, Decimal::Comma),
    (Separator::Spaces, Decimal::Comma),
];

/// The pairs that agree with what is given.
pub(super) fn candidates(
    separator: Option<Separator>,
    decimal: Option<Decimal>,
) -> impl Iterator<Item = (Separator, Decimal)> {
    ALL.into_iter().filter(move |(own_separator, own_decimal)| {
        separator.is_none_or(|given| given == *own_separator) && decimal.is_none_or(|given| given == *own_decimal)
    })
}

/// The pair by which the most cells are numbers in rows of equal length. Blanks separate nothing in
/// a table with tabs: its cells may have several words.
pub(super) fn detect(
    sample: &[Row<'_>],
    separator: Option<Separator>,
    decimal: Option<Decimal>,
) -> (Separator, Decimal) {
    let mut best = None;
    for (separator, decimal) in candidates(separator, decimal) {
        let score = score(sample, separator, decimal);
        let has_tabs = |(most, (found, _)): (Score, _)| found == Separator::Tab && most.0 >= score.0;
        if separator == Separator::Spaces && best.is_some_and(has_tabs) {
            continue;
        }
        if best.is_none_or(|(most, _)| score > most) {
            best = Some((score, (separator, decimal)));
        }
    }
    best.map_or((Separator::Comma, Decimal::Point), |(_, found)| found)
}

/// Score of a separator over rows of equal length with at least two numbers: the number of rows,
/// their numbers, and the bytes of their texts. Fewer bytes are better: a wrong separator leaves
/// digits in texts. Lines of text before a table have other lengths.
type Score = (usize, usize, Reverse<usize>);

fn score(sample: &[Row<'_>], separator: Separator, decimal: Decimal) -> Score {
    let mut cells: Vec<Cow<'_, str>> = Vec::new();
    let mut by_length: BTreeMap<usize, Score> = BTreeMap::new();
    for row in sample {
        split(row.text, separator, &mut cells);
        let texts = cells.iter().filter(|cell| value(cell, decimal).is_none());
        let (count, length) = texts.fold((0, 0), |(count, length), text| (count + 1, length + text.len()));
        let numbers = cells.len() - count;
        if numbers >= 2 {
            let (rows, all, Reverse(bytes)) = by_length.entry(cells.len()).or_default();
            *rows += 1;
            *all += numbers;
            *bytes += length;
        }
    }
    by_length.into_values().max().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separator_and_decimal_sign_are_detected_from_the_numbers() {
        for (lines, separator, decimal) in [
            (&["1,2,3"][..], Separator::Comma, Decimal::Point),
            (&["1.5;2;3"], Separator::Semicolon, Decimal::Point),
            (&["u,v,z", "5,97;0,75;-10,28"], Separator::Semicolon, Decimal::Comma),
            (&["id;x;y;z", "P1;1,5;-2;0,25"], Separator::Semicolon, Decimal::Comma),
            (&["1,5\t2\t3"], Separator::Tab, Decimal::Comma),
            (&[" 1.5   2 3 "], Separator::Spaces, Decimal::Point),
            (&["left flank\tTooth 1\t1.5\t2\t3"], Separator::Tab, Decimal::Point),
            (&["linke Flanke\tZahn 1\t1,5\t2\t3,5"], Separator::Tab, Decimal::Comma),
            (&["a line\twith tabs", "1.5 2 3"], Separator::Spaces, Decimal::Point),
            (&["1,5 2,5 3"], Separator::Spaces, Decimal::Comma),
            (&["\"1,5\",\"2,5\""], Separator::Comma, Decimal::Comma),
            (&["1, 2, 3"], Separator::Comma, Decimal::Point),
            (&["left,1,lead,0,51.898,8.74,0.0,,"], Separator::Comma, Decimal::Point),
            (&["T1;links;P;5,9;1,2"], Separator::Semicolon, Decimal::Comma),
            (&["on 12 11 2026 at 10 30 in room 4", "a;1,5;2,5", "b;1,5;3"], Separator::Semicolon, Decimal::Comma),
        ] {
            let rows: Vec<Row> = lines.iter().enumerate().map(|(k, text)| Row { line: k + 1, text }).collect();
            assert_eq!(detect(&rows, None, None), (separator, decimal), "{lines:?}");
        }
    }
}
