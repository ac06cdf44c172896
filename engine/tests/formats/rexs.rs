//! Gear models: attributes of gear and flanks with their units, topographies of every layout,
//! several gears, errors with places.

use flankfit_engine::{
    formats::{
        Datum, FileError, FilePosition,
        gear_file::{self, GearFile},
        rexs::{RexsModel, TracePlaces, read},
    },
    gear::{Hand, Kind, Side},
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
    assert_eq!(read.notes.list()[0].remark.code(), "flanks_differ");
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
        assert_eq!(read.notes.list().first().map(|note| note.remark.code()), assumed.then_some("order_assumed"));
    }
    let scattered = topography(array(&[0.001, 0.002, 0.003]), &[120.0, 121.0, 125.0], &[0.0, 10.0, 5.0]);
    let read = parsed(&model(flank(0.0, scattered), flank(0.0, vec![])));
    let points = &read.gear(None).unwrap().flanks[0].scattered;
    assert_eq!((points.len(), points[2].diameter, points[2].z, points[2].deviation), (3, 125.0, 5.0, 3.0));
    assert_eq!(read.notes.list()[0].remark.code(), "not_a_grid");
}

#[test]
fn xml_errors_have_line_and_column() {
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
        (of("version=\"1.4\"", "version=\"3.0\""), at(3, 1), "REXS version “3.0”"),
        (of("<model", "<!DOCTYPE model [<!ENTITY a \"b\">]>\n<model"), at(3, 1), "a document type definition"),
        (of(">4.5<", ">&lol;<"), at(module, 47), "the entity “lol”"),
        (of("  </components>", "  </component>"), None, ""),
        (of("</model>", ""), at(text.lines().count() + 1, 1), "the end of the element model"),
        (of("<model", "<modell"), at(3, 1), "a document of “modell”"),
        (of("<model", "<QIFDocument"), at(3, 1), "a QIF document, which is not read"),
        (of("<model", "<GearDataExchange"), at(3, 1), "a GDE document (VDI/VDE 2610), which is not read"),
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

/// A gear whose left flank has a measured profile and a measured helix.
fn measured(flank_kind: &'static str) -> Model {
    let mut model = Model::default();
    model.component(15, "cylindrical_gear", "Gear [27]", &gear("deg"));
    model.component(48, flank_kind, "left", &flank(0.25, vec![]));
    model.component(49, flank_kind, "right", &flank(0.25, vec![])).flanks(15, 48, 49);
    let profile = [
        attribute("profile_deviation_amounts", "mm", array(&[0.001, -0.002, 0.003])),
        attribute("diameters_of_profile_deviation", "mm", array(&[122.0, 126.0, 130.0])),
        attribute("position_of_profile_deviation", "mm", 25),
    ];
    let helix = [
        attribute("helix_deviation_amounts", "mum", array(&[4.0, f64::NAN])),
        attribute("coordinates_of_helix_deviation", "mm", array(&[5.0, 45.0])),
        attribute("diameter_of_helix_deviation", "mm", 127.5),
    ];
    model.component(60, "profile_deviation", "", &profile).reference(48, 60);
    model.component(61, "helix_deviation", "", &helix).reference(48, 61);
    model
}

#[test]
fn flanks_and_traces_of_every_version() {
    for (version, flank_kind) in [
        ("1.0", "flank_geometry"),
        ("1.1", "flank_geometry"),
        ("1.2", "flank_geometry"),
        ("1.3", "cylindrical_gear_flank"),
        ("1.4", "cylindrical_gear_flank"),
        ("1.5", "cylindrical_gear_flank"),
        ("1.6", "cylindrical_gear_flank"),
        ("1.7", "cylindrical_gear_flank"),
        ("2.0.0", "cylindrical_gear_flank"),
    ] {
        let model = read(measured(flank_kind).text(version).as_bytes()).unwrap();
        assert_eq!((model.version.as_str(), model.notes.count()), (version, 0));
        let gear = model.gear(None).unwrap();
        assert_eq!((gear.facts.profile_shift, gear.facts.teeth, gear.flanks.len()), (Some(0.25), Some(27), 2));
        assert!((gear.facts.pressure_angle.unwrap().to_degrees() - 20.0).abs() < 1e-12);
        let [profile, helix] = &gear.flanks[0].traces[..] else { panic!("{:?}", gear.flanks[0].traces) };
        assert_eq!((profile.kind(), profile.section, &profile.id[..]), (Kind::Profile, Some(25.0), "60"));
        assert_eq!(profile.places, TracePlaces::Diameters(vec![122.0, 126.0, 130.0]));
        assert_eq!(profile.deviation, [1.0, -2.0, 3.0]);
        assert_eq!((helix.kind(), helix.section, helix.deviation[0]), (Kind::Helix, Some(127.5), 4.0));
        assert!(helix.deviation[1].is_nan() && helix.places == TracePlaces::Z(vec![5.0, 45.0]));
        assert!(gear.flanks[1].traces.is_empty());
    }
}

#[test]
fn omitted_parts_have_a_note() {
    let unknown = read(measured("gear_flank_of_tomorrow").text("2.1").as_bytes()).unwrap();
    let codes: Vec<&str> = unknown.notes.list().iter().map(|note| note.remark.code()).collect();
    assert_eq!(codes, ["flank_not_read", "flank_not_read"]);
    assert_eq!(unknown.gear(None).unwrap().facts.teeth, Some(27));
    let mut bare = Model::default();
    bare.component(1, "bevel_gear", "bevel", &[]);
    let none = read(bare.text("1.4").as_bytes()).unwrap();
    assert_eq!((none.gears.len(), none.notes.list()[0].remark.code()), (0, "no_cylindrical_gear"));
}

#[test]
fn json_and_archives_hold_the_same_model() {
    let xml = measured("cylindrical_gear_flank").text("1.4");
    let same = |model: RexsModel| {
        let of_xml = read(xml.as_bytes()).unwrap();
        assert_eq!((&model.version, model.notes.count()), (&of_xml.version, 0));
        let [gear, wanted] = [&model.gears[0], &of_xml.gears[0]];
        assert_eq!((&gear.id, &gear.name, &gear.facts), (&wanted.id, &wanted.name, &wanted.facts));
        for (flank, wanted) in gear.flanks.iter().zip(&wanted.flanks) {
            assert_eq!((&flank.id, flank.side, flank.traces.len()), (&wanted.id, wanted.side, wanted.traces.len()));
            for (trace, wanted) in flank.traces.iter().zip(&wanted.traces) {
                assert_eq!((&trace.places, trace.section), (&wanted.places, wanted.section));
                assert_eq!(format!("{:?}", trace.deviation), format!("{:?}", wanted.deviation));
            }
        }
    };
    same(read(json().as_bytes()).unwrap());
    for (name, text) in [("model.rexs", xml.as_bytes()), ("model.rexsj", json().as_bytes())] {
        for deflated in [false, true] {
            match gear_file::read(&packed(name, text, deflated), Some("a.rexsz"), None).unwrap() {
                GearFile::Model(model) => same(model),
                other => panic!("{other:?}"),
            }
        }
    }
    // truncated, without a model, and one that would exhaust the memory
    let whole = packed("model.rexs", xml.as_bytes(), true);
    for cut in [5, whole.len() / 2, whole.len() - 1] {
        let fault = gear_file::read(&whole[..cut], None, None).unwrap_err();
        assert!(matches!(fault, FileError::Unsupported { .. }), "{fault}");
    }
    assert!(gear_file::read(&packed("hello.txt", b"hello", false), None, None).is_err());
    let bomb = packed("model.rexs", &vec![b' '; 80 << 20], true);
    assert!(bomb.len() < 1 << 20);
    assert!(matches!(gear_file::read(&bomb, None, None), Err(FileError::TooLarge { .. })));
    // a wrong size
    let mut lies = bomb;
    let end = lies.len() - 22;
    let entry = lies[..end].windows(4).rposition(|four| four == b"PK\x01\x02").unwrap();
    lies[entry + 24..entry + 28].copy_from_slice(&1000u32.to_le_bytes());
    assert!(matches!(gear_file::read(&lies, None, None), Err(FileError::TooLarge { .. })));
}

#[test]
fn json_errors_have_line_and_column() {
    let text = json();
    for (from, to, wanted) in [
        ("4.5", "4.5.1", "a value"),
        ("\"refs\"", "refs", "a name in quotes"),
        ("20.0}", "20.0", "a comma or the end of the object"),
        ("[122.0", "[\"a\"", "a list of numbers"),
        ("\"version\": \"1.4\"", "\"version\": \"4.0\"", "REXS version “4.0”"),
    ] {
        assert!(text.contains(from), "{from}");
        let fault = read(text.replacen(from, to, 1).as_bytes()).expect_err(to);
        assert!(fault.to_string().contains(wanted) && fault.place().is_some(), "{from}: {fault}");
    }
    let deep = format!("{{\"model\": {}1{}}}", "[".repeat(1000), "]".repeat(1000));
    assert!(matches!(read(deep.as_bytes()), Err(FileError::TooMany { .. })));
    for end in 1..text.len() - 3 {
        if text.is_char_boundary(end) && end % 37 == 0 {
            assert!(read(&text.as_bytes()[..end]).is_err());
        }
    }
    let escaped = text.replacen("Gear [27]", "Zahn\\u00e4 \\ud83d\\ude00 \\\"x\\\"", 1);
    assert_eq!(read(escaped.as_bytes()).unwrap().gears[0].name.as_deref(), Some("Zahnä 😀 \"x\""));
}

/// A model of a gear of 27 teeth with measured traces of its left flank, as JSON.
fn json() -> String {
    let component = |id: u32, kind: &str, name: &str, attributes: &str| {
        format!("{{\"id\": {id}, \"type\": \"{kind}\"{name}, \"attributes\": [{attributes}]}}")
    };
    let attribute = |id: &str, unit: &str, kind: &str, value: &str| {
        format!("{{\"id\": \"{id}\", \"unit\": \"{unit}\", \"{kind}\": {value}}}")
    };
    let number = |id: &str, unit: &str, value: &str| attribute(id, unit, "floating_point", value);
    let list = |id: &str, unit: &str, values: &str| attribute(id, unit, "floating_point_array", values);
    let gear = [
        attribute("number_of_teeth", "none", "integer", "27"),
        number("normal_module", "mm", "4.5"),
        number("helix_angle_reference_diameter", "deg", "-21"),
        number("face_width", "mm", "50"),
        number("tip_diameter", "m", "0.1415"),
        number("root_diameter", "", "120.25"),
        attribute("u_axis_vector", "mm", "boolean", "false"),
    ]
    .join(", ");
    let flank = format!(
        "{}, {}",
        number("addendum_modification_coefficient", "none", "0.25"),
        number("normal_pressure_angle", "deg", "20.0")
    );
    // 4.0 and NaN as little-endian doubles in base64
    let coded = "{\"code\": \"float64\", \"value\": \"AAAAAAAAEEAAAAAAAAD4fw==\"}";
    let profile = [
        list("profile_deviation_amounts", "mm", "[0.001, -0.002, 0.003]"),
        list("diameters_of_profile_deviation", "mm", "[122.0, 126.0, 130.0]"),
        number("position_of_profile_deviation", "mm", "25"),
    ]
    .join(", ");
    let helix = [
        attribute("helix_deviation_amounts", "mum", "floating_point_array_coded", coded),
        list("coordinates_of_helix_deviation", "mm", "[5.0, 45.0]"),
        number("diameter_of_helix_deviation", "mm", "127.5"),
    ]
    .join(", ");
    let components = [
        component(15, "cylindrical_gear", ", \"name\": \"Gear [27]\"", &gear),
        component(48, "cylindrical_gear_flank", "", &flank),
        component(49, "cylindrical_gear_flank", "", &flank),
        component(60, "profile_deviation", "", &profile),
        component(61, "helix_deviation", "", &helix),
    ]
    .join(",\n    ");
    let relation = |kind: &str, refs: &str| format!("{{\"id\": 1, \"type\": \"{kind}\", \"refs\": [{refs}]}}");
    let part = |id: u32, role: &str| format!("{{\"id\": {id}, \"role\": \"{role}\"}}");
    let relations = [
        relation("flank", &[part(15, "gear"), part(48, "left"), part(49, "right")].join(", ")),
        relation("reference", &[part(48, "origin"), part(60, "referenced")].join(", ")),
        relation("reference", &[part(48, "origin"), part(61, "referenced")].join(", ")),
    ]
    .join(",\n    ");
    format!(
        "{{\"model\": {{\"version\": \"1.4\", \"applicationId\": \"test\",\n  \"relations\": [{relations}],\n  \
         \"components\": [{components}]}}}}\n"
    )
}

/// A ZIP archive of one file.
fn packed(name: &str, text: &[u8], deflated: bool) -> Vec<u8> {
    let body = if deflated { miniz_oxide::deflate::compress_to_vec(text, 6) } else { text.to_vec() };
    let short = |out: &mut Vec<u8>, value: usize| out.extend((value as u16).to_le_bytes());
    let long = |out: &mut Vec<u8>, value: usize| out.extend((value as u32).to_le_bytes());
    // the fields from the version up to the lengths of name and extra field
    let common = |out: &mut Vec<u8>| {
        short(out, 20);
        short(out, 0);
        short(out, if deflated { 8 } else { 0 });
        long(out, 0);
        long(out, 0);
        long(out, body.len());
        long(out, text.len());
        short(out, name.len());
        short(out, 0);
    };
    let mut out = b"PK\x03\x04".to_vec();
    common(&mut out);
    out.extend(name.as_bytes());
    out.extend(&body);
    let directory = out.len();
    out.extend(b"PK\x01\x02");
    short(&mut out, 20);
    common(&mut out);
    for _ in 0..3 {
        short(&mut out, 0);
    }
    long(&mut out, 0);
    long(&mut out, 0);
    out.extend(name.as_bytes());
    let size = out.len() - directory;
    out.extend(b"PK\x05\x06\0\0\0\0\x01\0\x01\0");
    long(&mut out, size);
    long(&mut out, directory);
    short(&mut out, 0);
    out
}
