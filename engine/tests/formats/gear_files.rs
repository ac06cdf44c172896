//! One entry point for all files, and damaged files: no panic, no more memory than the input
//! allows, errors with a place within the file.

use flankfit_engine::formats::{
    FileError, FilePosition, GearFile,
    gear_file::read,
    klingelnberg::{Curves, Header},
};

use super::{
    klingelnberg_file::{Gear, Layout, Lines, Style, Trace},
    rexs_file::{Model, array, matrix},
};

fn curves(style: &Style) -> Vec<u8> {
    let values = |seed: usize| (0..24).map(|i| (i % 7 != 3).then_some((seed * i) as f64 * 0.125 - 1.0)).collect();
    let trace = |tooth: &str, profile, seed| Trace {
        tooth: tooth.into(),
        left: seed % 2 == 0,
        profile,
        index: 1,
        section: 7.5,
        values: values(seed),
    };
    let mut lines = Lines::new(style, "MK");
    lines.gear(&Gear::spur(), true).traces(&[trace("1", false, 1), trace("1k", true, 2), trace("2", true, 3)]);
    lines.line("Fußkreisdurchmesser / Höhe :     7.500").line("   49.4891   49.5206").line("linke Zahnflanke");
    lines
        .line("   Zahn-Nr.  fp  Fp   Fr")
        .line(" 1  0.662 0.662 0.778")
        .line("Teilung: ")
        .line("Z-Nr. Seite PHI X Y Z");
    lines.line("  1   R     0.0000  .1192    25.9468    86.1877");
    lines.bytes()
}

fn values() -> Vec<u8> {
    let mut lines = Lines::new(&Style::default(), "MW");
    lines.gear(&Gear::spur(), false);
    lines
        .line("10111 : fHb links 1          :   -2.9")
        .line("26450 : V Fuß                : 8999.0")
        .line("31610 : Fr : 30.1");
    lines.bytes()
}

fn model() -> Vec<u8> {
    let mut model = Model::default();
    let text = |value: &str| value.to_owned();
    model.component(
        15,
        "cylindrical_gear",
        "G&amp;1",
        &[("number_of_teeth", "none", text("27")), ("normal_module", "mm", text("4.5"))],
    );
    let lists = [
        ("normal_pressure_angle", "deg", text("20")),
        ("topographical_deviation_amounts", "mm", matrix(3, &[0.001, 0.002, 0.003, 0.004, 0.005, 0.006])),
        ("diameters_of_topographical_deviation", "mm", array(&[120.0, 130.0])),
        ("coordinates_of_topographical_deviation", "mm", array(&[0.0, 25.0, 50.0])),
    ];
    model
        .component(48, "cylindrical_gear_flank", "l", &lists)
        .component(49, "cylindrical_gear_flank", "r", &[])
        .flanks(15, 48, 49);
    model.text("1.2").into_bytes()
}

const POINTS: &[u8] = b"# points\nid;x;y;z;i;j;k\n\"a;1\";1,5;2;3;0;0;1\nb;-1;0,25;1e3;;;\n";

fn seeds() -> Vec<Vec<u8>> {
    let plain = Style::default();
    vec![
        curves(&plain),
        curves(&Style { latin1: true, line_end: "\n", separator: ';', ..plain.clone() }),
        curves(&Style { layout: Layout::Topography, english: true, by_diameter: true, per_line: 5, ..plain }),
        values(),
        model(),
        POINTS.to_vec(),
    ]
}

#[test]
fn the_content_determines_the_kind_of_file() {
    for name in [None, Some("a.csv"), Some("b.mka"), Some("c")] {
        let kinds: Vec<&str> = seeds()
            .iter()
            .map(|seed| match read(seed, name, None).unwrap() {
                GearFile::Curves(_) => "curves",
                GearFile::Values(_) => "values",
                GearFile::Model(_) => "model",
                GearFile::Table(_) => "points",
            })
            .collect();
        assert_eq!(kinds, ["curves", "curves", "curves", "values", "model", "points"]);
    }
    let start = Some(FilePosition { line: 1, column: 1 });
    for (bytes, name, wanted) in [
        (&b"hello"[..], None, "unknown format"),
        (b"hello", Some("x.mka"), "expected HEADER KS.MK.FILE, found “hello”"),
        (b"hello", Some("X.MEW"), "expected HEADER KS.MW.FILE"),
        (b"a,b,c,d", Some("x.csv"), "no line of the table has two numbers"),
        (b"<a/>", None, "a document of “a”"),
        (b"{\"id\":1}", Some("x.rexsj"), "a JSON file without a `model`"),
        (b"PK\x03\x04..", Some("x.rexsz"), "a ZIP archive without a list of its files"),
        (b"\xFF\xFEH\0", None, "unknown format"),
    ] {
        let fault = read(bytes, name, None).unwrap_err();
        assert!(fault.to_string().contains(wanted), "{fault}");
        if name != Some("x.csv") {
            assert_eq!(fault.place(), start, "{fault}");
        }
    }
    assert_eq!(read(b" \n\t", Some("x.mka"), None), Err(FileError::Empty));
}

/// A generator with a fixed sequence (xorshift*).
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() % count.max(1) as u64) as usize
    }
}

/// Pieces that mean something to one reader or another.
const PIECES: [&[u8]; 20] = [
    b"Zahn-Nr.: 1 links / 99999999999 Werte x= 1\n",
    b"Zahn-Nr.: 1 links / 480 Werte z= 1\n",
    b"/ 0 Werte",
    b"Profil:\n",
    b"SEPARATOR ;\n",
    b"UNDEFINED nan\n",
    b"1e308 1e309 -.",
    b"\n  41  : : 7\n",
    b"\xEF\xBB\xBF",
    b"\xC3\xA4\xFF",
    b"\r\n\r\n",
    b"10111 : a : 1\n",
    b"<matrix rows=\"2\" columns=\"0\"><r><c>1</c></r></matrix>",
    b"<array code=\"float64\">AAAA</array>",
    b"<!DOCTYPE a [<!ENTITY b \"&b;&b;\">]>",
    b"&#0;&b;",
    b"</component>",
    b"\"",
    b"1,2;3\t4",
    b"fp Fp Fr\n1 2 3\n",
];

fn damaged(seed: &[u8], other: &[u8], draws: &mut Draws) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..1 + draws.below(6) {
        let at = draws.below(bytes.len() + 1);
        match draws.below(8) {
            0 => bytes.truncate(at),
            1 => {
                let end = at + draws.below(bytes.len() - at + 1).min(60);
                bytes.drain(at..end);
            }
            2 => {
                bytes.splice(at..at, PIECES[draws.below(PIECES.len())].iter().copied());
            }
            3 => {
                let end = (at + draws.below(400)).min(bytes.len());
                let piece = bytes[at..end].to_vec();
                let to = draws.below(bytes.len() + 1);
                bytes.splice(to..to, piece);
            }
            4 => {
                let from = draws.below(other.len());
                let end = (from + draws.below(200)).min(other.len());
                bytes.splice(at..at, other[from..end].iter().copied());
            }
            5 => {
                for _ in 0..draws.below(20) {
                    let to = draws.below(bytes.len() + 1);
                    bytes.insert(to, draws.next() as u8);
                }
            }
            _ => {
                if at < bytes.len() {
                    bytes[at] = b"0123456789.-+:;/=<>&\"' \n,eE"[draws.below(27)];
                }
            }
        }
    }
    bytes
}

/// Memory that a file's content takes, near enough.
fn size(file: &GearFile) -> usize {
    let header = |header: &Header| {
        let lines = header
            .lines
            .iter()
            .map(|line| 80 + line.label.len() + line.fields.iter().map(|f| 24 + f.len()).sum::<usize>());
        lines.sum::<usize>() + header.preamble.iter().map(|s| 56 + s.key.len() + s.value.len()).sum::<usize>()
    };
    match file {
        GearFile::Curves(file) => {
            let Curves { curves, pitch, contacts, diameters, .. } = &**file;
            let curves = curves.iter().map(|curve| 160 + curve.tooth.len() + 8 * curve.values.capacity());
            let pitch = pitch.iter().map(|table| 48 + 32 * table.rows.len());
            let diameters = diameters.iter().map(|table| 48 + 8 * table.values.len());
            header(&file.header)
                + curves.sum::<usize>()
                + pitch.sum::<usize>()
                + diameters.sum::<usize>()
                + 48 * contacts.len()
        }
        GearFile::Values(file) => header(&file.header) + file.results.iter().map(|r| 120 + r.name.len()).sum::<usize>(),
        GearFile::Model(model) => {
            let flanks = model.gears.iter().flat_map(|gear| &gear.flanks);
            let lists = flanks.map(|flank| {
                200 + 24 * flank.scattered.len() + flank.topography.as_ref().map_or(0, |t| 8 * t.deviation.len())
            });
            300 * model.gears.len() + lists.sum::<usize>()
        }
        GearFile::Table(table) => {
            let columns = table.columns.iter().enumerate();
            columns
                .map(|(k, column)| 40 + column.name.len() + table.numbers_at(k).map_or(0, |list| 8 * list.len()))
                .sum()
        }
    }
}

#[test]
fn damaged_files_are_read_or_refused_with_a_place() {
    let seeds = seeds();
    let mut draws = Draws(0x9E37_79B9_7F4A_7C15);
    let (mut whole, mut refused) = (0, 0);
    for round in 0..12_000 {
        let seed = &seeds[round % seeds.len()];
        let other = &seeds[draws.below(seeds.len())];
        let bytes = damaged(seed, other, &mut draws);
        let name = [None, Some("a.mka"), Some("a.mew"), Some("a.csv"), Some("a.rexs")][round % 5];
        let lines = bytes.iter().filter(|b| matches!(b, b'\n' | b'\r')).count() + 1;
        match read(&bytes, name, None) {
            Ok(file) => {
                whole += 1;
                let most = 50 * bytes.len() + 1000;
                assert!(size(&file) <= most, "{} bytes of {}", size(&file), bytes.len());
            }
            Err(fault) => {
                refused += 1;
                if let Some(place) = fault.place() {
                    assert!(
                        (1..=lines).contains(&place.line) && (1..=bytes.len() + 1).contains(&place.column),
                        "{fault}"
                    );
                }
                assert!(fault.to_string().len() < 1000, "{fault}");
            }
        }
    }
    assert!(whole > 1000 && refused > 1000, "{whole} {refused}");
}

#[test]
fn random_bytes_are_refused_or_read() {
    let mut draws = Draws(7);
    for length in 0..600 {
        let bytes: Vec<u8> = (0..length).map(|_| draws.next() as u8).collect();
        for name in [None, Some("a.mka"), Some("a.mew"), Some("a.csv"), Some("a.xml")] {
            let _ = read(&bytes, name, None);
        }
        for head in ["HEADER KS.MK.FILE\n", "HEADER KS.MW.FILE\n", "<model version=\"1.0\">", "x,y,z\n"] {
            let _ = read(&[head.as_bytes(), &bytes].concat(), None, None);
        }
    }
}

#[test]
fn promised_counts_take_no_memory() {
    // a thousand heads that each promise thousands of millions: the first one is refused, and
    // nothing was set aside for it
    let head = "Zahn-Nr.: 1 links / 4000000000 Werte x= 1\n";
    let text = format!("HEADER KS.MK.FILE\n{}", head.repeat(1000));
    let fault = read(text.as_bytes(), None, None).unwrap_err();
    assert!(matches!(fault, FileError::ValueCount { announced: 4_000_000_000, found: 0, .. }), "{fault}");
}

/// The files of `examples/files` are read without a note and contain complete gear data.
#[test]
fn the_example_files_are_read() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join("examples/files");
    let mut seen = Vec::new();
    for entry in std::fs::read_dir(folder).expect("the folder is there") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().and_then(|name| name.to_str()).expect("a name").to_owned();
        if ![".mka", ".rexs"].iter().any(|end| name.ends_with(end)) {
            continue;
        }
        match read(&std::fs::read(&path).expect("a file"), Some(&name), None).expect(&name) {
            GearFile::Curves(file) => {
                let mut notes = file.notes.clone();
                assert_eq!(file.gear(&mut notes).missing(), []);
                assert_eq!((file.curves.len(), file.pitch.len(), notes.list()), (12, 2, &[][..]), "{name}");
            }
            GearFile::Model(model) => {
                assert_eq!((model.gears.len(), model.notes.list()), (1, &[][..]), "{name}");
                let gear = &model.gears[0];
                assert_eq!(gear.facts.missing(), []);
                let measured = usize::from(gear.flanks[0].topography.is_some()) + gear.flanks[0].traces.len();
                assert_eq!(measured, if model.version == "1.4" { 1 } else { 2 }, "{name}");
            }
            other => panic!("{name}: {other:?}"),
        }
        seen.push(name);
    }
    seen.sort();
    assert_eq!(seen, ["curves.mka", "rexs_1.2.rexs", "rexs_1.4.rexs", "rexs_2.0.rexs"]);
}
