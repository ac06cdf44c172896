//! Corrections under the names of OPC UA for Geometrical Measuring Systems.

use flankfit_engine::formats::gms::{COLUMNS, Correction, Unit, check, write_csv};

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
fn invalid_corrections_are_refused() {
    let one = |change: fn(&mut Correction)| {
        let mut it = correction("c");
        change(&mut it);
        check(&[correction("first"), it])
    };
    assert_eq!(one(|_| ()), Ok(()));
    let refused = |change: fn(&mut Correction)| one(change).unwrap_err().to_string();
    assert_eq!(refused(|it| it.relative = None), "[1]: correction 1 has neither an absolute nor a relative value");
    assert!(refused(|it| it.absolute = Some(f64::NAN)).contains("the absolute value is NaN, not a finite number"));
    let limits = refused(|it| it.lower_limit = Some(0.75));
    assert!(limits.contains("the lower limit 0.75 lies above the upper one, 0.5"), "{limits}");
    assert_eq!(refused(|it| it.characteristic.clear()), "[1].characteristic: correction 1 has no characteristic");
    let repeated = refused(|it| it.identifier = "first".into());
    assert!(repeated.contains("corrections 0 and 1 have the same identifier first"), "{repeated}");
}
