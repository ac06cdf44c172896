//! Corrections under the names of OPC UA for Geometrical Measuring Systems.

use flankfit_engine::formats::gms::{COLUMNS, Correction, CorrectionFault, Unit, check, write_csv};

fn correction(identifier: &str) -> Correction {
    Correction {
        identifier: identifier.into(),
        characteristic: "f_Halpha left".into(),
        relative: Some(-0.1),
        absolute: None,
        upper_limit: Some(0.5),
        lower_limit: Some(-0.5),
        unit: Unit::Degree,
        description: Some("profile angle, \"left\"".into()),
        program: Some("O1234".into()),
    }
}

#[test]
fn names_and_values() {
    let other = Correction {
        absolute: Some(12.5),
        relative: None,
        upper_limit: None,
        lower_limit: None,
        unit: Unit::Micrometre,
        description: None,
        program: None,
        ..correction("c2")
    };
    let text = write_csv(&[correction("c1"), other], &[]).unwrap();
    let lines: Vec<&str> = text.split("\r\n").collect();
    assert_eq!(lines[0], COLUMNS.join(","));
    for name in [
        "CharacteristicIdentifier",
        "CorrectionValueAbsolute",
        "CorrectionValueRelative",
        "LowerControlLimit",
        "UpperControlLimit",
        "ProgramName",
    ] {
        assert!(COLUMNS.contains(&name));
    }
    assert_eq!(lines[1], "c1,f_Halpha left,-0.1,,0.5,-0.5,°,17476,\"profile angle, \"\"left\"\"\",O1234");
    assert_eq!(lines[2], "c2,f_Halpha left,,12.5,,,µm,13384,,");
    assert_eq!(lines[3..], [""]);
    // identifiers as UN/CEFACT and OPC UA pair them
    assert_eq!([Unit::Millimetre.id(), Unit::Radian.id(), Unit::One.id()], [5_066_068, 4_405_297, 4_404_786]);
}

#[test]
fn what_is_no_correction() {
    let one = |change: fn(&mut Correction)| {
        let mut it = correction("c");
        change(&mut it);
        check(&[correction("first"), it])
    };
    assert_eq!(one(|_| ()), Ok(()));
    assert_eq!(one(|it| it.relative = None), Err(CorrectionFault::NoValue { index: 1 }));
    assert!(matches!(
        one(|it| it.absolute = Some(f64::NAN)),
        Err(CorrectionFault::NotFinite { index: 1, name: "the absolute value", .. })
    ));
    assert_eq!(
        one(|it| it.lower_limit = Some(0.75)),
        Err(CorrectionFault::Limits { index: 1, lower: 0.75, upper: 0.5 })
    );
    assert_eq!(one(|it| it.characteristic.clear()), Err(CorrectionFault::Unnamed { index: 1, name: "characteristic" }));
    let repeated = CorrectionFault::Repeated { first: 0, second: 1, identifier: "first".into() };
    assert_eq!(one(|it| it.identifier = "first".into()), Err(repeated));
}
