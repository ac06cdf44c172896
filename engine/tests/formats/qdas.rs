//! Quality data, read back by a parser of the key fields that knows nothing of the writer.

use flankfit_engine::formats::{
    UtcTime,
    qdas::{Characteristic, Charset, DECIMALS, Measurement, Part, encode, one_line, write},
};
use proptest::prelude::*;

use super::qdas_file::File;

fn part() -> Part {
    Part { number: "A 4711".into(), name: "Sun gear".into(), ..Part::default() }
}

fn slope(number: &str) -> Characteristic {
    Characteristic {
        number: number.into(),
        name: "f_Halpha, left".into(),
        unit: "µm",
        lower_limit: Some(-6.5),
        upper_limit: Some(6.5),
        value: Some(-1.2346),
    }
}

fn measured() -> Measurement {
    let at = UtcTime::new([2026, 3, 4], [5, 6, 7]).unwrap();
    Measurement { at, batch: None, remark: None, serial_number: None }
}

#[test]
fn a_file_contains_all_values_given() {
    let part = Part {
        machine: Some("RZ 260".into()),
        instrument: Some("P 40".into()),
        operator: Some("Müller".into()),
        ..part()
    };
    let total = Characteristic { lower_limit: None, value: None, ..slope("2") };
    let about = Measurement {
        batch: Some("B7".into()),
        serial_number: Some("S 12".into()),
        remark: Some("iteration 3".into()),
        ..measured()
    };
    let text = write(&part, &[slope("1"), total], &about).unwrap();
    let bytes = encode(&text);
    assert_eq!(Charset::of(&bytes), Charset::Windows1252);
    let file = File::read(&bytes);
    assert_eq!(file.declared, 2);
    for (key, index, content) in [
        ("K1001", 1, "A 4711"),
        ("K1002", 1, "Sun gear"),
        ("K1082", 1, "RZ 260"),
        ("K1202", 1, "P 40"),
        ("K1222", 1, "Müller"),
        ("K2001", 1, "1"),
        ("K2002", 2, "f_Halpha, left"),
        ("K2004", 1, "0"),
        ("K2022", 2, "3"),
        ("K2110", 1, "-6.500"),
        ("K2111", 2, "6.500"),
        ("K2142", 2, "µm"),
        ("K0001", 1, "-1.235"),
        ("K0002", 1, "0"),
        ("K0001", 2, "0.000"),
        ("K0002", 2, "255"),
        ("K0004", 2, "04.03.2026/05:06:07"),
        ("K0006", 1, "B7"),
        ("K0009", 2, "iteration 3"),
        ("K0014", 2, "S 12"),
    ] {
        assert_eq!(file.one(key, index), Some(content), "{key}/{index}");
    }
    assert_eq!(file.one("K2110", 2), None);
}

#[test]
fn letters_that_the_code_page_lacks_make_a_file_of_utf_8() {
    for (name, charset) in [
        ("Zahnrad – größer als 5 €", Charset::Windows1252),
        ("齿轮", Charset::Utf8),
        ("α", Charset::Utf8),
        ("\u{fffd}", Charset::Utf8),
        ("ï»¿ what the mark looks like", Charset::Windows1252),
    ] {
        let bytes = encode(&write(&Part { name: name.into(), ..part() }, &[slope("1")], &measured()).unwrap());
        assert_eq!((Charset::of(&bytes), File::read(&bytes).one("K1002", 1)), (charset, Some(name)));
    }
    // at the very beginning those letters would be the mark
    assert_eq!(Charset::of(&encode("ï»¿")), Charset::Utf8);
}

#[test]
fn invalid_characteristics_are_refused() {
    let refused =
        |characteristics: &[Characteristic]| write(&part(), characteristics, &measured()).unwrap_err().to_string();
    assert_eq!(refused(&[]), "characteristics: there is no characteristic");
    let again = "characteristics[1].number: characteristics 0 and 1 have the same number 1";
    assert_eq!(refused(&[slope("1"), slope(" 1\n")]), again);
    let lower = Characteristic { lower_limit: Some(7.0), ..slope("2") };
    let limits = refused(&[slope("1"), lower]);
    assert!(limits.ends_with("characteristic 1: the lower limit 7 lies above the upper one, 6.5"), "{limits}");
    let infinite = Characteristic { value: Some(f64::INFINITY), ..slope("1") };
    assert!(refused(&[infinite]).contains("characteristic 0: its value is inf, not a finite number"));
    let nameless = Characteristic { name: "\r\n\t".into(), ..slope("1") };
    assert_eq!(refused(&[nameless]), "characteristics[0].name: characteristic 0 has no name");
    let part = Part { number: " \u{14}".into(), ..part() };
    let fault = write(&part, &[slope("1")], &measured()).unwrap_err();
    assert_eq!(fault.to_string(), "part.number: the part's number is empty");
}

#[test]
fn numbers_fit_their_fields() {
    for (value, printed) in [
        (-0.0, "0.000"),
        (-0.0004, "0.000"),
        (-0.0006, "-0.001"),
        (123456789012345678.0, "123456789012345680.000"),
        (1.5e300, "1.5E300"),
        (5e-324, "0.000"),
    ] {
        let one = Characteristic { value: Some(value), ..slope("1") };
        let file = File::read(&encode(&write(&part(), &[one], &measured()).unwrap()));
        assert_eq!(file.one("K0001", 1), Some(printed), "{value}");
    }
}

proptest! {
    /// Whatever names hold, every line is one field, and every value comes back to its digits.
    #[test]
    fn no_name_breaks_a_file(
        name in "\\PC*|(\\PC|[\r\n\t\u{f}\u{14}¤\u{0}\u{85}\u{2028}]){0,120}",
        values in prop::collection::vec(prop::option::of(-1e6..1e6f64), 1..20),
        huge in proptest::num::f64::NORMAL,
    ) {
        let named = format!("x{name}");
        let characteristics: Vec<Characteristic> = values
            .iter()
            .chain([&Some(huge)])
            .enumerate()
            .map(|(k, value)| Characteristic {
                number: k.to_string(), name: named.clone(), value: *value, lower_limit: None, upper_limit: None,
                unit: "µm",
            })
            .collect();
        let part = Part { number: named.clone(), name: named.clone(), machine: Some(name.clone()), ..part() };
        let about = Measurement { remark: Some(name.clone()), batch: Some(name.clone()), ..measured() };
        let bytes = encode(&write(&part, &characteristics, &about).unwrap());
        let file = File::read(&bytes);
        prop_assert_eq!(file.declared, characteristics.len());
        for (k, one) in characteristics.iter().enumerate() {
            let value: f64 = file.one("K0001", k + 1).unwrap().parse().unwrap();
            let away = (value - one.value.unwrap_or(0.0)).abs();
            prop_assert!(away <= 0.5 * 10f64.powi(-(DECIMALS as i32)) * (1.0 + 1e-9) || away <= 1e-12 * huge.abs());
            prop_assert_eq!(file.one("K0002", k + 1), Some(if one.value.is_some() { "0" } else { "255" }));
            let shown = file.one("K2002", k + 1).unwrap();
            prop_assert!(shown.chars().count() <= 80 && shown == one_line(&named, 80));
        }
        prop_assert!(file.one("K1001", 1).unwrap().chars().count() <= 30);
        prop_assert_eq!(file.one("K1082", 1).map(str::to_owned), Some(one_line(&name, 40)).filter(|t| !t.is_empty()));
    }
}
