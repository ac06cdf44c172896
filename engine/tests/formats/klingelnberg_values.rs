//! Value files: codes, labels, what was not measured and what could not be formed.

use flankfit_engine::{
    formats::{
        FilePosition,
        klingelnberg::{Characteristic, MeasuringPosition, ResultValue, Statistic, Values, read_values},
    },
    gear::Side,
};

use super::klingelnberg_file::{Gear, Lines, Style};

/// Results as an instrument prints them: code, German and English label, printed value.
const RESULTS: [(u32, &str, &str, &str); 12] = [
    (10111, "fHb links 1", "fHb left 1", "-2.9"),
    (10122, "fHb rechts 12", "fHb right 12", "-17.0"),
    (10130, "fHbm links", "fHbm left", "7.2"),
    (10160, "fHb Var rechts", "fHb Var right", "74.4"),
    (10211, "fHb links f 1f", "fHb left f 1f", ".8"),
    (20311, "fHa links o 1o", "fHa left o 1o", "0.0"),
    (26412, "Fuß  12", "Root  12", "49.5"),
    (26450, "V Fuß", "V root", "8999.0"),
    (26511, "Fuß  u 1u", "Root  u 1u", "-9999.0"),
    (30120, "fp max rechts", "fp max right", "7.8"),
    (31610, "Fr", "Fr", "30.1"),
    (21611, "fKo links 1", "fKo left 1", "-23.2"),
];

fn file(style: &Style) -> Vec<u8> {
    let mut lines = Lines::new(style, "MW");
    lines.gear(&Gear::spur(), false);
    for (code, german, english, value) in RESULTS {
        let label = if style.english { english } else { german };
        let separator = style.separator;
        lines.line(&format!("{code} {separator} {label:<20} {separator}{value:>7}"));
    }
    lines.line("").bytes()
}

fn check(values: &Values) {
    assert_eq!(values.notes.list(), []);
    assert_eq!(values.results.len(), RESULTS.len());
    let of = |code: u32| {
        let result = values.results.iter().find(|result| result.code == code).unwrap();
        (result.characteristic, result.place, result.statistic, result.side, result.tooth.as_deref(), result.reading)
    };
    use Characteristic::*;
    let (left, right) = (Some(Side::Left), Some(Side::Right));
    let middle = MeasuringPosition::Middle;
    assert_eq!(of(10111), (Some(HelixSlope), middle, Statistic::Tooth, left, Some("1"), ResultValue::Value(-2.9)));
    assert_eq!(of(10122), (Some(HelixSlope), middle, Statistic::Tooth, right, Some("12"), ResultValue::Value(-17.0)));
    assert_eq!(of(10130), (Some(HelixSlope), middle, Statistic::Mean, left, None, ResultValue::Value(7.2)));
    assert_eq!(of(10160), (Some(HelixSlope), middle, Statistic::Variation, right, None, ResultValue::Value(74.4)));
    assert_eq!(
        of(10211),
        (Some(HelixSlope), MeasuringPosition::First, Statistic::Tooth, left, Some("1f"), ResultValue::Value(0.8))
    );
    assert_eq!(
        of(20311),
        (Some(ProfileSlope), MeasuringPosition::Second, Statistic::Tooth, left, Some("1o"), ResultValue::Value(0.0))
    );
    assert_eq!(of(26412), (Some(RootDiameter), middle, Statistic::Tooth, None, Some("12"), ResultValue::Value(49.5)));
    assert_eq!(of(26450), (Some(RootDiameter), middle, Statistic::Variation, None, None, ResultValue::NotAvailable));
    assert_eq!(of(26511).5, ResultValue::NotMeasured);
    assert_eq!(of(26511).5.value(), None);
    assert_eq!(of(30120), (Some(SinglePitch), middle, Statistic::Max, right, None, ResultValue::Value(7.8)));
    assert_eq!(of(31610), (Some(Runout), middle, Statistic::Gear, None, None, ResultValue::Value(30.1)));
    // a code of no known meaning keeps what its label says
    assert_eq!(of(21611), (None, middle, Statistic::Unknown, left, Some("1"), ResultValue::Value(-23.2)));
}

#[test]
fn every_shape_holds_the_same_results() {
    let plain = Style::default();
    for style in [
        plain.clone(),
        Style { byte_order_mark: false, line_end: "\n", ..plain.clone() },
        Style { latin1: true, ..plain.clone() },
        Style { separator: ';', english: true, ..plain },
    ] {
        let values = read_values(&file(&style)).unwrap();
        check(&values);
        assert_eq!(values.header.gear(&mut Default::default()).teeth, Some(52));
    }
    let values = read_values(&file(&Style::default())).unwrap();
    assert!(values.results.iter().any(|result| result.code == 26412 && result.name == "Fuß 12"));
}

#[test]
fn syntax_errors_have_line_and_column() {
    let head = "HEADER KS.MW.FILE\nTYPE STI\n  7 :ME: 1\n";
    let read = |rest: &str| read_values(format!("{head}{rest}\n").as_bytes());
    for (line, column, text) in [
        ("10111 : fHb links 1 : 1,0", 23, "expected a value, found “1,0”"),
        ("10111 : fHb links 1 :", 22, "expected a value, found nothing"),
        ("10111 : fHb links 1", 8, "expected a label, the separator and a value"),
        ("99999999999 : fHb : 1", 1, "expected the code of a result"),
    ] {
        let fault = read(line).unwrap_err();
        assert_eq!(fault.place(), Some(FilePosition { line: 4, column }), "{fault}");
        assert!(fault.to_string().contains(text), "{fault}");
    }
    let values = read("10111 : fHb rechts 1 : 1.0\nsomething else\n10111 : fHb links 1 : 2.0").unwrap();
    let notes: Vec<_> = values.notes.list().iter().map(|note| (note.remark.code(), note.line)).collect();
    assert_eq!(notes, [("side_disagrees", 4), ("unknown_block", 5), ("repeated_result", 6)]);
    assert_eq!((values.results.len(), values.results[0].side), (2, Some(Side::Left)));
}

/// M_dK over balls of 1.75 mm is 54.531 mm for x = 0.011 (z = 52, m_n = 1 mm) and 55.377 mm for x =
/// 0.5, from inv α_K = inv α + D_M / (z m cos α) − π / 2z + 2 x tan α / z and M_dK = z m cos α /
/// cos α_K + D_M.
#[test]
fn a_dimension_over_balls_that_contradicts_the_profile_shift_is_noted() {
    let noted = |dimension: &str| {
        let mut lines = Lines::new(&Style::default(), "MW");
        lines.gear(&Gear::spur(), false).code(28, "Kugeldurchmesser", "Ball", "1.75");
        lines.line(&format!("32810 : MdK                  :   {dimension}"));
        let values = read_values(&lines.line("").bytes()).unwrap();
        let mut notes = Default::default();
        values.gear(&mut notes);
        let found: Vec<String> = notes.list().iter().map(|note| note.remark.to_string()).collect();
        found.into_iter().filter(|note| note.contains("M_dK")).collect::<Vec<_>>()
    };
    assert_eq!(noted("54.531"), Vec::<String>::new());
    let [note] = &noted("55.377")[..] else { panic!("no note") };
    assert!(note.contains("coefficient 0.011 (code 25)") && note.contains("M_dK = 55.377 mm"), "{note}");
    let (_, given) = note.split_once("x_E = ").unwrap();
    assert!((given[..6].parse::<f64>().unwrap() - 0.5).abs() < 0.001, "{note}");
}
