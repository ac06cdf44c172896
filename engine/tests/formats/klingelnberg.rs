//! Curve files: every shape of the format is read to the same traces, and what cannot be read has a
//! line and a column.

use flankfit_engine::{
    formats::{
        Datum, FileError, FilePosition,
        klingelnberg::{Block, Curves, ProfileAxis, Section, SectionPlane, SignConvention, WhichDiameter, read_curves},
    },
    gear::{self, Hand, Kind, Side},
    words::Shown,
};

use super::klingelnberg_file::{Gear, Layout, Lines, Style, Trace};

fn wave(count: usize, seed: f64) -> Vec<Option<f64>> {
    let value = |i: usize| ((i as f64 * 0.37 + seed).sin() * 20_000.0).round() / 1000.0;
    (0..count).map(|i| (i >= 2 && i + 3 < count).then(|| value(i))).collect()
}

fn traces(by_diameter: bool) -> Vec<Trace> {
    let circle = |d: f64, x: f64| if by_diameter { d } else { x };
    let trace = |tooth: &str, left, profile, index, section, count| Trace {
        tooth: tooth.into(),
        left,
        profile,
        index,
        section,
        values: wave(count, section + f64::from(index)),
    };
    vec![
        trace("44", true, false, 2, circle(51.898, 8.742), 480),
        trace("1", false, false, 2, circle(51.898, 8.742), 480),
        trace("1", true, true, 2, 7.5, 480),
        trace("1", false, true, 2, 7.5, 480),
        trace("1k", true, false, 3, circle(53.0, 10.263), 480),
        trace("1f", true, false, 1, circle(51.0, 7.303), 480),
        trace("1u", true, true, 1, 1.0, 480),
        trace("1o", true, true, 3, 14.0, 480),
    ]
}

fn styles() -> Vec<Style> {
    let plain = Style::default();
    vec![
        plain.clone(),
        Style { byte_order_mark: false, line_end: "\n", ..plain.clone() },
        Style { latin1: true, ..plain.clone() },
        Style { separator: ';', ..plain.clone() },
        Style { separator: '|', english: true, ..plain.clone() },
        Style { english: true, per_line: 7, leading_zero: true, ..plain.clone() },
        Style { undefined: "-9999999.000", blank_lines: 0, ..plain.clone() },
        Style { undefined: "-2147483.65", per_line: 1, ..plain.clone() },
        Style { layout: Layout::OneLine, by_diameter: true, ..plain.clone() },
        Style { layout: Layout::Topography, by_diameter: true, blank_lines: 6, ..plain.clone() },
        Style { per_line: 480, by_diameter: true, ..plain },
    ]
}

fn written(style: &Style, gear: &Gear, separate: bool, traces: &[Trace]) -> Vec<u8> {
    let mut lines = Lines::new(style, "MK");
    lines.gear(gear, separate).traces(traces);
    lines.bytes()
}

fn check_traces(file: &Curves, wanted: &[Trace]) {
    assert_eq!(file.curves.len(), wanted.len());
    for (curve, trace) in file.curves.iter().zip(wanted) {
        assert_eq!(curve.tooth, trace.tooth);
        assert_eq!(curve.side == Side::Left, trace.left);
        assert_eq!(curve.kind == Kind::Profile, trace.profile);
        assert_eq!(curve.values.len(), trace.values.len());
        assert_eq!(curve.undefined, trace.values.iter().filter(|value| value.is_none()).count());
        for (read, value) in curve.values.iter().zip(&trace.values) {
            assert!(value.map_or(read.is_nan(), |value| value == *read), "{read} {value:?}");
        }
        let section = match curve.section {
            Section::RollLength(at) | Section::Diameter(at) | Section::Z(at) => at,
            Section::NotGiven => f64::NAN,
        };
        assert_eq!(section, trace.section);
    }
}

#[test]
fn every_shape_holds_the_same_traces() {
    for style in styles() {
        for separate in [false, true] {
            let wanted = traces(style.by_diameter);
            let file = read_curves(&written(&style, &Gear::spur(), separate, &wanted))
                .unwrap_or_else(|e| panic!("{style:?}: {e}"));
            check_traces(&file, &wanted);
            assert_eq!(file.notes.list(), [], "{style:?}");
            let undefined = |values: &[f64]| values.iter().filter(|value| value.is_nan()).count();
            assert_eq!(file.curves.iter().map(|curve| undefined(&curve.values)).sum::<usize>(), 8 * 5);
            let blocks: Vec<&Block> = file.curves.iter().map(|curve| &curve.block).collect();
            match style.layout {
                Layout::Blocks => {
                    assert_eq!(blocks[..4], [&Block::Helix, &Block::Helix, &Block::Profile, &Block::Profile]);
                    assert!(blocks[4..].iter().all(|block| **block == Block::Twist));
                    assert_eq!(file.curves[4].index, Some(3));
                }
                Layout::OneLine => assert!(!blocks.contains(&&Block::Untitled)),
                Layout::Topography => assert!(blocks.iter().all(|block| **block == Block::Topography)),
            }
        }
    }
}

#[test]
fn the_header_describes_gear_and_measurement() {
    for style in styles() {
        let file = read_curves(&written(&style, &Gear::spur(), true, &traces(style.by_diameter))).unwrap();
        let mut notes = Default::default();
        let facts = file.header.gear(&mut notes);
        assert_eq!((notes.count(), facts.internal), (0, Some(false)));
        let data = facts.gear_data().unwrap();
        assert_eq!((data.teeth, data.normal_module, data.profile_shift), (52, 1.0, 0.011));
        assert_eq!((data.pressure_angle, data.helix_angle), (20f64.to_radians(), 0.0));
        assert_eq!(
            (data.face_width, data.tip_diameter, data.root_diameter),
            (Some(15.0), Some(54.0219), Some(49.5219))
        );
        let profile = file.header.profile_setup();
        assert_eq!(profile.axis, ProfileAxis::Diameter);
        for side in [Side::Left, Side::Right] {
            let measured = profile.measured.of(side).unwrap();
            let evaluated = profile.evaluated.of(side).unwrap();
            assert_eq!([measured.start, evaluated.start, evaluated.end, measured.end], [50.156, 50.3, 54.022, 54.2]);
        }
        assert_eq!(
            (profile.length.right, profile.middle.left, profile.lower.left, profile.upper.left),
            (Some(5.552), Some(7.5), Some(1.0), Some(14.0))
        );
        let helix = file.header.helix_setup();
        let (measured, evaluated) = (helix.measured.right.unwrap(), helix.evaluated.left.unwrap());
        assert_eq!([measured.start, evaluated.start, evaluated.end, measured.end], [0.0, 0.75, 14.25, 15.0]);
        assert_eq!([helix.middle.left, helix.inner.left, helix.outer.right], [Some(51.898), Some(51.0), Some(53.0)]);
        let rules = file.header.rules();
        assert_eq!(
            (rules.helix_slope_reference, rules.helix_sign, rules.section),
            (Some(1), Some(1), Some(SectionPlane::Normal))
        );
        assert_eq!((rules.helix_slope_signs.left, rules.helix_slope_signs.right), (Some(true), Some(false)));
        assert_eq!((rules.helix_length.setting, rules.helix_length.word.as_deref()), (Some(1), Some("Z")));
        assert_eq!((rules.helix_length.length.left, rules.helix_length.length.right), (Some(15.0), None));
        assert_eq!(
            (rules.profile_length.word.as_deref(), rules.profile_length.length.left),
            (Some("M1-M2"), Some(5.5516))
        );
        assert_eq!((rules.helix_plus_material.rule, rules.helix_plus_material.form), (Some(0), Some(1)));
        assert_eq!((rules.profile_plus_material.rule, rules.profile_plus_material.total), (Some(0), Some(1)));
        assert!(file.signs().is_known(Kind::Helix) && file.signs().is_known(Kind::Profile));
        // codes of no known meaning are kept
        assert_eq!(file.header.get(9001).unwrap().fields, ["was", "immer"]);
        assert_eq!(file.header.preamble("FILTER LEAD"), Some("F:S 2"));
    }
}

#[test]
fn hands_and_internal_gears() {
    for english in [false, true] {
        let style = Style { english, ..Style::default() };
        for (right_hand, hand) in [(true, Hand::Right), (false, Hand::Left)] {
            let gear = Gear { beta: 21.5, right_hand, teeth: -80, internal: true, ..Gear::spur() };
            let data = read_curves(&written(&style, &gear, false, &[]))
                .unwrap()
                .header
                .gear(&mut Default::default())
                .gear_data()
                .unwrap();
            assert_eq!((data.hand, data.internal, data.teeth), (hand, true, 80));
            assert!((data.helix_angle.to_degrees() - 21.5).abs() < 1e-12);
        }
    }
    // neither word nor sign: the hand is missing, and nothing else
    let mut lines = Lines::new(&Style::default(), "MK");
    lines.gear(&Gear { beta: -12.0, ..Gear::spur() }, false);
    let text = String::from_utf8(lines.bytes()).unwrap().replace("-12   rechts", "12");
    let facts = read_curves(text.as_bytes()).unwrap().header.gear(&mut Default::default());
    assert_eq!(facts.missing(), [Datum::Hand]);
    let left = text.replace(": 12 ", ": -12 ");
    let facts = read_curves(left.as_bytes()).unwrap().header.gear(&mut Default::default());
    assert_eq!(facts.gear_data().unwrap().hand, Hand::Left);
    let sexagesimal = text.replace("ANGLE     decimal", "ANGLE     sexagezimal");
    let mut notes = Default::default();
    let facts = read_curves(sexagesimal.as_bytes()).unwrap().header.gear(&mut notes);
    assert_eq!(notes.list()[0].remark.code(), "angles_not_decimal");
    assert_eq!((facts.pressure_angle, facts.helix_angle), (None, None));
}

#[test]
fn samples_are_equidistant_in_roll_length_and_face_width() {
    let style = Style::default();
    let file = read_curves(&written(&style, &Gear::spur(), false, &traces(false))).unwrap();
    let data = file.header.gear(&mut Default::default()).gear_data().unwrap();
    let gear = gear::Gear::new(data).unwrap();
    let placed = file.place(&gear);
    assert_eq!((placed.traces.len(), placed.unplaced.len()), (8, 0));
    let roll = |d: f64| (0.25 * d * d - (26.0 * 20f64.to_radians().cos()).powi(2)).sqrt();
    for placed in &placed.traces {
        let trace = &placed.trace;
        let (start, end) = if trace.kind == Kind::Profile { (roll(50.156), roll(54.2)) } else { (0.0, 15.0) };
        for (i, at) in trace.at.iter().enumerate() {
            assert!((at - (start + (end - start) * i as f64 / 479.0)).abs() < 1e-12);
        }
    }
    let sections: Vec<_> = placed.traces.iter().map(|placed| placed.trace.section.unwrap()).collect();
    assert_eq!(sections, [51.898, 51.898, 7.5, 7.5, 53.0, 51.0, 1.0, 14.0]);
    // signs of DIN: leads and left profiles turn
    let turned = placed.clone().with_sense(file.signs(), SignConvention::Din);
    for (before, after) in placed.traces.iter().zip(&turned.traces) {
        let factor = if before.trace.kind == Kind::Profile && before.trace.side == Side::Right { 1.0 } else { -1.0 };
        assert!(
            before
                .trace
                .deviation
                .iter()
                .zip(&after.trace.deviation)
                .all(|(a, b)| a.is_nan() && b.is_nan() || factor * a == *b)
        );
    }
}

#[test]
fn profile_places_in_roll_length_and_angle() {
    let wanted =
        [Trace { tooth: "1".into(), left: true, profile: true, index: 1, section: 7.5, values: wave(20, 0.0) }];
    let gear_file = Gear { profile: [3.0, 4.0, 8.0, 9.0, 4.0], ..Gear::spur() };
    let text = String::from_utf8(written(&Style::default(), &gear_file, false, &wanted)).unwrap();
    let read = |axis: &str| {
        let file = read_curves(text.replace("PROFILE   diameter", &format!("PROFILE   {axis}")).as_bytes()).unwrap();
        let gear = gear::Gear::new(file.header.gear(&mut Default::default()).gear_data().unwrap()).unwrap();
        (file.place(&gear), gear)
    };
    let ends = |axis: &str| {
        let (placed, _) = read(axis);
        let at = &placed.traces[0].trace.at;
        [at[0], at[19]]
    };
    assert_eq!(ends("length"), [3.0, 9.0]);
    let (_, gear) = read("roll angle");
    assert_eq!(ends("roll angle"), [3.0, 9.0].map(|a| gear.base_radius() * f64::to_radians(a)));
    let why = |axis: &str| read(axis).0.unplaced[0].why.clone();
    assert_eq!(why("parsec"), "profile places are given in “parsec”, which has no known meaning");
    assert!(why("diameter").starts_with("the measuring range reaches 3 mm, which is below the base circle"));
}

#[test]
fn tables_behind_the_traces() {
    for english in [false, true] {
        let style = Style { english, ..Style::default() };
        let mut lines = Lines::new(&style, "MK");
        lines.gear(&Gear::spur(), false).traces(&traces(false));
        let words = if english {
            ["Root diameter / height", "left tooth flank", "right tooth flank", "Pitch"]
        } else {
            ["Fußkreisdurchmesser / Höhe", "linke Zahnflanke", "rechte Zahnflanke", "Teilung"]
        };
        lines.line(&format!("{} :     7.500", words[0])).line("   49.4891   49.5206").line("");
        for title in &words[1..3] {
            lines
                .line(&format!("        {title}     "))
                .line("        Zahn-Nr.          fp           Fp           Fr   ")
                .line("");
            lines
                .line("       1                 0.662        0.662       0.778   ")
                .line("       2                -1.273       -0.611      -1.776 ")
                .line("");
        }
        lines.line(&format!("{}: ", words[3])).line("Z-Nr. Seite       PHI        X          Y          Z          ");
        lines
            .line("  1   R           0.0000      .1192    25.9468    86.1877")
            .line("  2   L          -2.7212     -.1201    25.9471    86.1855");
        let file = read_curves(&lines.bytes()).unwrap();
        assert_eq!(file.notes.list(), []);
        assert_eq!(
            file.pitch.iter().map(|table| table.side).collect::<Vec<_>>(),
            [Some(Side::Left), Some(Side::Right)]
        );
        let row = file.pitch[1].rows[1];
        assert_eq!((row.tooth, row.single, row.cumulative, row.runout), (2, -1.273, -0.611, -1.776));
        assert_eq!((file.diameters[0].which, file.diameters[0].z), (WhichDiameter::Root, 7.5));
        assert_eq!(file.diameters[0].values, [49.4891, 49.5206]);
        assert_eq!(file.contacts.len(), 2);
        assert_eq!(
            (file.contacts[1].side, file.contacts[1].phi, file.contacts[1].point),
            (Side::Left, -2.7212, [-0.1201, 25.9471, 86.1855])
        );
    }
}

/// A small file with something put in the place of a line.
fn small(from: &str, to: &str) -> Result<Curves, FileError> {
    let text = "HEADER KS.MK.FILE\nUNITS mm\n  22 :Zähnezahl z....: 52\nProfil:\nZahn-Nr.: 3 links / 4 Werte z= 7.5\n \
        1.0 2.0 .5\n -.25\n\nZahn-Nr.: 4 links / 1 Werte z= 7.5\n 9\n";
    assert!(text.contains(from), "{from}");
    read_curves(text.replacen(from, to, 1).as_bytes())
}

#[test]
fn syntax_errors_have_line_and_column() {
    let place = |line, column| Some(FilePosition { line, column });
    let cases = [
        (" -.25\n", "", place(8, 1), "announces 4 values, found 3"),
        (" -.25\n", " -.25 7\n", place(7, 7), "announces 4 values, found 5"),
        (" -.25\n", " -.25\n 8 9\n", place(8, 2), "announces 4 values, found 6"),
        ("2.0", "2,0", place(6, 6), "expected a number, found “2,0”"),
        ("2.0", "zwei", place(6, 6), "expected a number, found “zwei”"),
        ("2.0", "1e999", place(6, 6), "expected a number"),
        ("/ 4 Werte", "/ vier Werte", place(5, 21), "expected the number of values, found “vier”"),
        ("/ 4 Werte", "/ 4x Werte", place(5, 21), "expected the number of values, found “4x”"),
        ("/ 4 Werte", "/ 4000000000 Werte", place(9, 1), "announces 4000000000 values, found 4"),
        ("z= 7.5", "z= hoch", place(5, 32), "expected the place of the section"),
        ("z= 7.5", "x= 7.5", place(5, 1), "z= of a profile"),
        ("UNITS mm", "UNITS inch", place(2, 1), "lengths in inch"),
        ("HEADER KS.MK.FILE", "HEADER KS.MW.FILE", place(1, 1), "expected HEADER KS.MK.FILE"),
    ];
    for (from, to, place, text) in cases {
        let fault = small(from, to).expect_err(to);
        assert_eq!(fault.place(), place, "{from} → {to}: {fault}");
        assert!(fault.to_string().contains(text), "{fault}");
    }
    assert_eq!(read_curves(b""), Err(FileError::Empty));
}

#[test]
fn unknown_blocks_are_named() {
    let file = small("Zahn-Nr.: 4", "Geheimnis:\n 1 2 3\n 4 5 6\nmehr davon\nZahn-Nr.: 4").unwrap();
    assert_eq!((file.curves.len(), file.notes.count()), (2, 1));
    let note = &file.notes.list()[0];
    assert_eq!((note.remark.code(), note.line), ("unknown_block", 10));
    assert_eq!(note.remark.to_string(), "the line “1 2 3” and 2 more fits no known block");
    // the letter of the section says what the trace under the unknown title is
    assert_eq!((&file.curves[1].block, file.curves[1].kind), (&Block::Other("Geheimnis".into()), Kind::Profile));
}

#[test]
fn repeated_codes_and_missing_counts_are_noted() {
    let file = small("UNITS mm\n", "UNITS mm\n  22 :Zähnezahl z....: 51\n").unwrap();
    assert_eq!((file.header.number(22), file.header.lines.len()), (Some(51.0), 2));
    assert_eq!((file.notes.list()[0].remark.code(), file.notes.list()[0].line), ("repeated_code", 4));
    let file = small("/ 4 Werte z= 7.5", "").unwrap();
    assert_eq!((file.notes.list()[0].remark.code(), file.notes.list()[0].line), ("count_not_given", 5));
    assert_eq!((file.curves[0].values.len(), file.curves[0].kind), (4, Kind::Profile));
    assert_eq!(Shown(file.curves[0].values[3]).to_string(), "-0.25");
}

/// Code 25 is x or x m_n, depending on its label; unreadable values are noted.
#[test]
fn values_have_the_unit_of_their_label() {
    let lines = "  21 :Normalmodul mn..[mm]....: 3\n  22 :Zähnezahl z....: 52\n  23 :Schrägungswinkel [Grad]: 0\n  \
        24 :Eingriffswinkel [Grad]: 20\n  25 :Profilverschiebung xm.........  [mm]....:   .6\n  \
        27 :Kopfkreisdurchmesser da [mm]: 162\n";
    let facts = |from: &str, to: &str| {
        assert!(lines.contains(from), "{from}");
        let file = small("  22 :Zähnezahl z....: 52\n", &lines.replacen(from, to, 1)).unwrap();
        let mut notes = Default::default();
        let facts = file.gear(&mut notes);
        (facts, notes.list().iter().map(|note| (note.remark.code(), note.line)).collect::<Vec<_>>())
    };
    let (found, notes) = facts("xm", "xm");
    assert!((found.profile_shift.unwrap() - 0.2).abs() < 1e-15 && notes.is_empty());
    let (found, notes) = facts("Profilverschiebung xm.........  [mm]", "Profilverschiebungsfaktor x ....");
    assert_eq!((found.profile_shift, notes), (Some(0.6), vec![]));
    let (found, notes) = facts("  .6", "0,203");
    assert_eq!((found.profile_shift, notes), (None, vec![("value_not_read", 7)]));
    let (found, notes) = facts("da [mm]: 162", "da [inch]: 6.38");
    assert_eq!((found.tip_diameter, notes), (None, vec![("unit_not_known", 8)]));
    let (found, notes) = facts("winkel [Grad]: 20", "winkel [rad]: .349");
    assert_eq!((found.pressure_angle, notes), (None, vec![("unit_not_known", 6)]));
    // W_6 of this gear is 51.23 mm with x = 0.2, and 53.02 with 1.07
    let span = |w: &str| format!("[mm]: 162\n  281 :Messzähnezahl: 6\n  115 :Zahnweitenmaß: WKT:{w} : 0 : 0");
    let (_, notes) = facts("[mm]: 162", &span("51.23"));
    assert_eq!(notes, []);
    let (_, notes) = facts("[mm]: 162", &span("53.02"));
    assert_eq!(notes, [("profile_shift_contradicted", 7)]);
}
