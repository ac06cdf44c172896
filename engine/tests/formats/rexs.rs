//! Gear models: attributes of gear and flanks with their units, topographies of every layout,
//! several gears, faults with places.

use flankfit_engine::{
    formats::{
        Datum, FileError, FilePosition, NoteCode,
        rexs::{RexsModel, read},
    },
    gear::{Hand, Side},
};

use super::rexs_file::{Attribute, Model, array, coded, matrix};

fn attribute(id: &'static str, unit: &'static str, value: impl ToString) -> Attribute {
    (id, unit, value.to_string())
}

fn gear(degrees: &'static str) -> Vec<Attribute> {
    vec![
        attribute("number_of_teeth", "none", 27),
        attribute("normal_module", "mm", 4.5),
        attribute("helix_angle_reference_diameter", degrees, -21),
        attribute("face_width", "mm", 50),
        attribute("tip_diameter", "m", 0.1415),
        attribute("root_diameter", "", 120.25),
        attribute("u_axis_vector", "mm", array(&[1.0, 0.0, 0.0])),
        attribute("custom_remark", "none", "one &amp; two &#x41;"),
    ]
}

fn flank(x: f64, more: Vec<Attribute>) -> Vec<Attribute> {
    let mut all =
        vec![attribute("normal_pressure_angle", "deg", "2.0E1"), attribute("addendum_modification_coefficient", "", x)];
    all.extend(more);
    all
}

const DIAMETERS: [f64; 2] = [120.0, 130.0];
const COORDINATES: [f64; 3] = [0.0, 25.0, 50.0];
/// mm, rows of diameters.
const AMOUNTS: [f64; 6] = [0.001, 0.002, 0.003, -0.004, -0.005, -0.006];

fn topography(amounts: String, diameters: &[f64], coordinates: &[f64]) -> Vec<Attribute> {
    vec![
        ("topographical_deviation_amounts", "mm", amounts),
        ("diameters_of_topographical_deviation", "mm", array(diameters)),
        ("coordinates_of_topographical_deviation", "mm", coded(coordinates)),
    ]
}

fn model(left: Vec<Attribute>, right: Vec<Attribute>) -> Model {
    let mut model = Model::default();
    model.component(15, "cylindrical_gear", "Gear [27]", &gear("deg"));
    model.component(48, "cylindrical_gear_flank", "left", &left);
    model.component(49, "cylindrical_gear_flank", "right", &right).flanks(15, 48, 49);
    model
}

fn parsed(model: &Model) -> RexsModel {
    read(model.text("1.4").as_bytes()).unwrap()
}

#[test]
fn a_gear_with_its_flanks() {
    for degrees in ["deg", "°"] {
        for (namespace, single_quotes) in [(false, false), (true, false), (false, true)] {
            let mut model = Model { namespace, single_quotes, ..Model::default() };
            model.component(1, "shaft", "Shaft", &[attribute("normal_module", "mm", 1)]);
            model.component(15, "cylindrical_gear", "Gear [27]", &gear(degrees));
            model.component(48, "cylindrical_gear_flank", "left", &flank(0.25, vec![]));
            model.component(49, "cylindrical_gear_flank", "right", &flank(0.25, vec![])).flanks(15, 48, 49);
            let read = parsed(&model);
            assert_eq!((read.version.as_str(), read.gears.len(), read.notes.list()), ("1.4", 1, &[][..]));
            let gear = read.gear(None).unwrap();
            assert_eq!((gear.id.as_str(), gear.name.as_deref()), ("15", Some("Gear [27]")));
            let data = gear.facts.gear_data().unwrap();
            assert_eq!((data.teeth, data.normal_module, data.profile_shift, data.hand), (27, 4.5, 0.25, Hand::Left));
            assert_eq!((data.pressure_angle, data.helix_angle), (20f64.to_radians(), 21f64.to_radians()));
            assert_eq!(
                (data.face_width, data.tip_diameter, data.root_diameter),
                (Some(50.0), Some(141.5), Some(120.25))
            );
            assert!(!data.internal);
        }
    }
}

#[test]
fn ring_gears_and_attributes_on_the_gear() {
    let mut model = Model::default();
    let mut ring = gear("deg");
    ring[2] = attribute("helix_angle", "rad", 0.3);
    ring.extend([attribute("normal_pressure_angle", "deg", 25), attribute("profile_shift_coefficient", "none", -0.5)]);
    model.component(7, "ring_gear", "Ring", &ring);
    model.component(8, "cylindrical_gear", "Sun", &gear("deg"));
    let read = parsed(&model);
    let data = read.gear(Some("7")).unwrap().facts.gear_data().unwrap();
    assert_eq!((data.internal, data.hand, data.helix_angle, data.profile_shift), (true, Hand::Right, 0.3, -0.5));
    let missing = read.gear(Some("8")).unwrap().facts.missing();
    assert_eq!(missing, [Datum::PressureAngle, Datum::ProfileShift]);
    assert_eq!(read.gear(None).unwrap_err(), FileError::SeveralGears { ids: vec!["7".into(), "8".into()] });
    let fault = read.gear(Some("9")).unwrap_err();
    assert_eq!(fault.to_string(), "the model has no gear 9; it has 7, 8");
    assert_eq!(parsed(&Model::default()).gear(None).unwrap_err(), FileError::NoGear);
}

#[test]
fn flanks_that_differ_are_noted() {
    let read = parsed(&model(flank(0.25, vec![]), flank(0.3, vec![])));
    let gear = read.gear(None).unwrap();
    assert_eq!((gear.facts.profile_shift, gear.flanks[1].profile_shift), (None, Some(0.3)));
    assert_eq!(read.notes.list()[0].remark.code(), NoteCode::FlanksDiffer);
    assert!(gear.facts.pressure_angle.is_some());
}

#[test]
fn topographies_of_every_layout() {
    let turned: Vec<f64> = (0..6).map(|k| AMOUNTS[k % 2 * 3 + k / 2]).collect();
    let points: Vec<(f64, f64, f64)> =
        [4, 1, 5, 0, 3, 2].map(|k| (DIAMETERS[k / 3], COORDINATES[k % 3], AMOUNTS[k])).to_vec();
    let of = |part: fn(&(f64, f64, f64)) -> f64| points.iter().map(part).collect::<Vec<f64>>();
    let layouts = [
        (topography(matrix(3, &AMOUNTS), &DIAMETERS, &COORDINATES), false),
        (topography(matrix(2, &turned), &DIAMETERS, &COORDINATES), false),
        (topography(array(&AMOUNTS), &DIAMETERS, &COORDINATES), true),
        (topography(coded(&AMOUNTS), &DIAMETERS, &COORDINATES), true),
        (topography(array(&of(|p| p.2)), &of(|p| p.0), &of(|p| p.1)), false),
    ];
    for (lists, assumed) in layouts {
        let read = parsed(&model(flank(0.0, vec![]), flank(0.0, lists)));
        let gear = read.gear(None).unwrap();
        assert_eq!((gear.flanks[0].side, &gear.flanks[0].topography), (Side::Left, &None));
        let grid = gear.flanks[1].topography.as_ref().unwrap();
        assert_eq!((grid.side, &grid.diameter[..], &grid.z[..]), (Side::Right, &DIAMETERS[..], &COORDINATES[..]));
        let wanted = AMOUNTS.map(|amount| 1000.0 * amount);
        assert_eq!(grid.deviation, wanted);
        assert_eq!(read.notes.list().first().map(|note| note.remark.code()), assumed.then_some(NoteCode::OrderAssumed));
    }
    let scattered = topography(array(&[0.001, 0.002, 0.003]), &[120.0, 121.0, 125.0], &[0.0, 10.0, 5.0]);
    let read = parsed(&model(flank(0.0, scattered), flank(0.0, vec![])));
    let points = &read.gear(None).unwrap().flanks[0].scattered;
    assert_eq!((points.len(), points[2].diameter, points[2].z, points[2].deviation), (3, 125.0, 5.0, 3.0));
    assert_eq!(read.notes.list()[0].remark.code(), NoteCode::NotAGrid);
}

#[test]
fn faults_have_places() {
    let text = model(flank(0.25, vec![]), flank(0.25, vec![])).text("1.4");
    let of = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        read(text.replacen(from, to, 1).as_bytes()).expect_err(to)
    };
    let line = |part: &str| text.lines().position(|line| line.contains(part)).unwrap() + 1;
    let at = |line: usize, column: usize| Some(FilePosition { line, column });
    let module = line("normal_module");
    for (fault, place, wanted) in [
        (of(">4.5<", ">vier<"), at(module, 7), "expected a number, found “vier”"),
        (of("\"mm\">4.5", "\"furlong\">4.5"), at(module, 7), "the unit “furlong” of normal_module"),
        (of(">27</attribute>", ">27.5</attribute>"), at(line("number_of_teeth"), 7), "a whole number of teeth"),
        (of("version=\"1.4\"", "version=\"2.0\""), at(3, 1), "REXS version “2.0”"),
        (of("<model", "<!DOCTYPE model [<!ENTITY a \"b\">]>\n<model"), at(3, 1), "a document type definition"),
        (of(">4.5<", ">&lol;<"), at(module, 47), "the entity “lol”"),
        (of("  </components>", "  </component>"), None, ""),
        (of("</model>", ""), at(text.lines().count() + 1, 1), "the end of the element model"),
        (of("<model", "<modell"), at(3, 1), "one element model"),
        (of("</model>", "</model><model version=\"1.0\"/>"), None, "one element model"),
    ] {
        if place.is_some() {
            assert_eq!(fault.place(), place, "{fault}");
        }
        assert!(fault.to_string().contains(wanted) && fault.place().is_some(), "{fault}");
    }
    let deep = text.replacen(">4.5<", &format!(">{}4.5{}<", "<c>".repeat(40), "</c>".repeat(40)), 1);
    assert!(matches!(read(deep.as_bytes()), Err(FileError::TooMany { .. })));
    let lists = topography(array(&[1.0; 5]), &DIAMETERS, &COORDINATES);
    let fault = read(model(flank(0.0, lists), flank(0.0, vec![])).text("1.4").as_bytes()).unwrap_err();
    assert!(fault.to_string().contains("one amount for each diameter and coordinate"), "{fault}");
    let ragged = topography("<matrix><r><c>1</c><c>2</c></r><r><c>3</c></r></matrix>".into(), &DIAMETERS, &COORDINATES);
    let fault = read(model(flank(0.0, ragged), flank(0.0, vec![])).text("1.4").as_bytes()).unwrap_err();
    assert!(fault.to_string().contains("rows of the same number of columns"), "{fault}");
}
