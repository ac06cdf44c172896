//! Any grid in any dialect is read back to the same numbers; the example files and their variants;
//! bytes of any kind.

use std::path::Path;

use flankfit_engine::{
    estimation::Nodes,
    formats::{
        GearFile, gear_file,
        table::{self, Decimal, Layout, Mapping, Meaning, Separator, Unit},
    },
};
use proptest::prelude::*;

/// Dialect of a table.
#[derive(Clone, Debug)]
struct Dialect {
    separator: Separator,
    decimal: Decimal,
    quoted: bool,
    encoding: Encoding,
    line_end: &'static str,
    header: Option<[&'static str; 3]>,
    matrix: bool,
    trailing: bool,
    comments: bool,
}

#[derive(Clone, Copy, Debug)]
enum Encoding {
    Utf8,
    Utf8WithMark,
    Utf16Little { mark: bool },
    Utf16Big { mark: bool },
}

impl Encoding {
    fn bytes(self, text: &str) -> Vec<u8> {
        let units = |mark: bool| mark.then_some(0xFEFF).into_iter().chain(text.encode_utf16());
        match self {
            Encoding::Utf8 => text.as_bytes().to_vec(),
            Encoding::Utf8WithMark => [b"\xEF\xBB\xBF", text.as_bytes()].concat(),
            Encoding::Utf16Little { mark } => units(mark).flat_map(u16::to_le_bytes).collect(),
            Encoding::Utf16Big { mark } => units(mark).flat_map(u16::to_be_bytes).collect(),
        }
    }
}

impl Dialect {
    fn cell(&self, text: &str) -> String {
        if self.quoted { format!("\"{text}\"") } else { text.to_owned() }
    }

    fn number(&self, x: f64) -> String {
        let text = if x.is_nan() { String::new() } else { format!("{x:?}") };
        self.cell(&if self.decimal == Decimal::Comma { text.replace('.', ",") } else { text })
    }

    fn write(&self, u: &[f64], v: &[f64], z: &[f64]) -> Vec<u8> {
        let mark = self.separator.mark().unwrap_or(' ').to_string();
        let mut rows: Vec<Vec<String>> = Vec::new();
        let name = |name: &str| self.cell(&if mark == " " { name.replace(' ', "_") } else { name.to_owned() });
        if self.matrix {
            // blanks leave the corner out
            let corner = if mark == " " && !self.quoted { Vec::new() } else { vec![self.cell("")] };
            let corner = self.header.map_or(corner, |[u, v, z]| vec![name(&format!("{u}\\{v}\\{z}"))]);
            rows.push(corner.into_iter().chain(v.iter().map(|v| self.number(*v))).collect());
            for (i, u) in u.iter().enumerate() {
                let heights = z[i * v.len()..][..v.len()].iter();
                rows.push(std::iter::once(u).chain(heights).map(|x| self.number(*x)).collect());
            }
        } else {
            rows.extend(self.header.map(|names| names.map(name).to_vec()));
            let places = u.iter().flat_map(|u| v.iter().map(move |v| (*u, *v)));
            rows.extend(places.zip(z).map(|((u, v), z)| [u, v, *z].map(|x| self.number(x)).to_vec()));
        }
        let end = if self.trailing && mark != " " { &mark } else { "" };
        let mut text = if self.comments { format!("# measured{0}{0}", self.line_end) } else { String::new() };
        for row in rows {
            text += &format!("{}{end}{}", row.join(&mark), self.line_end);
        }
        self.encoding.bytes(&text)
    }
}

fn dialects() -> impl Strategy<Value = Dialect> {
    let separators = [Separator::Comma, Separator::Semicolon, Separator::Tab, Separator::Spaces];
    let encodings = [
        Encoding::Utf8,
        Encoding::Utf8WithMark,
        Encoding::Utf16Little { mark: true },
        Encoding::Utf16Little { mark: false },
        Encoding::Utf16Big { mark: true },
        Encoding::Utf16Big { mark: false },
    ];
    let headers = [
        None,
        Some(["u", "v", "z"]),
        Some(["roll_length [mm]", "face_width [mm]", "deviation [um]"]),
        Some(["Rollweg (mm)", "Breite (mm)", "Abweichung (µm)"]),
    ];
    let flags = (any::<bool>(), any::<bool>(), any::<bool>(), any::<bool>());
    (
        prop::sample::select(separators.to_vec()),
        prop::sample::select(vec![Decimal::Point, Decimal::Comma]),
        prop::sample::select(encodings.to_vec()),
        prop::sample::select(vec!["\n", "\r\n", "\r"]),
        prop::sample::select(headers.to_vec()),
        flags,
    )
        .prop_map(|(separator, decimal, encoding, line_end, header, (quoted, matrix, trailing, comments))| {
            // without quotes a decimal comma cannot be distinguished from a separator
            let quoted = quoted || (separator, decimal) == (Separator::Comma, Decimal::Comma);
            Dialect { separator, decimal, quoted, encoding, line_end, header, matrix, trailing, comments }
        })
}

/// Numbers from a start on, strictly ascending.
fn ascending() -> impl Strategy<Value = Vec<f64>> {
    (-50.0f64..50.0, prop::collection::vec(1e-3f64..3.0, 1..6)).prop_map(|(start, steps)| {
        let mut at = start;
        std::iter::once(start)
            .chain(steps.into_iter().map(|step| {
                at += step;
                at
            }))
            .collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn any_grid_in_any_dialect(
        dialect in dialects(), u in ascending(), v in ascending(),
        heights in prop::collection::vec(prop::option::weighted(0.85, -300.0f64..300.0), 36),
    ) {
        // with blanks a missing cell cannot be recognised
        let blanks = dialect.separator == Separator::Spaces && !dialect.quoted;
        let mut z: Vec<f64> = heights.iter().take(u.len() * v.len())
            .map(|height| height.unwrap_or(if blanks { 1.25 } else { f64::NAN })).collect();
        z[0] = 0.5;
        let bytes = dialect.write(&u, &v, &z);
        let read = table::read(&bytes, &Mapping::default())
            .map_err(|fault| TestCaseError::fail(format!("{fault}: {:?}", String::from_utf8_lossy(&bytes))))?;
        prop_assert_eq!((read.layout(), read.matrix), (Some(Layout::Grid), dialect.matrix), "{:?}",
            String::from_utf8_lossy(&bytes));
        let sets = read.node_sets().expect("nodes");
        let Ok(Nodes::Grid(grid)) = &sets[0].nodes else { panic!("no grid") };
        let bits = |list: &[f64]| list.iter().map(|x| (x + 0.0).to_bits()).collect::<Vec<_>>();
        prop_assert_eq!((bits(grid.u()), bits(grid.v()), bits(grid.z())), (bits(&u), bits(&v), bits(&z)));
    }

    /// Columns of words, as many as there may be next to two numbers, do not hide the format of a
    /// table.
    #[test]
    fn words_in_other_columns_do_not_hide_the_numbers(
        (separator, decimal) in (
            prop::sample::select(vec![Separator::Comma, Separator::Semicolon, Separator::Tab, Separator::Spaces]),
            prop::sample::select(vec![Decimal::Point, Decimal::Comma]),
        ).prop_filter("a comma is one thing", |pair| *pair != (Separator::Comma, Decimal::Comma)),
        words in prop::collection::vec(prop::sample::select(vec!["links", "T1", "P-7", "Müller", "1k", "ok."]), 0..8),
        places in [0_usize..9, 0_usize..9], rows in prop::collection::vec([-50_i32..50, -300_i32..300], 1..6),
        header in any::<bool>(), protocol in any::<bool>(),
    ) {
        let mark = separator.mark().unwrap_or(' ').to_string();
        let row = |numbers: [String; 2]| {
            let mut cells: Vec<String> = words.iter().map(|word| (*word).to_owned()).collect();
            for (place, number) in places.iter().zip(numbers) {
                cells.insert((*place).min(cells.len()), number);
            }
            cells.join(&mark)
        };
        let number = |x: i32| {
            let text = format!("{:.1}", f64::from(x) + 0.5);
            if decimal == Decimal::Comma { text.replace('.', ",") } else { text }
        };
        let mut text = if protocol { "Messung am 12 11 2026 um 10 30 in Raum 4 b\n".to_owned() } else { String::new() };
        if header {
            text += &(row(["roll_length".into(), "deviation".into()]) + "\n");
        }
        rows.iter().chain(&rows).for_each(|numbers| text += &(row(numbers.map(number)) + "\n"));
        let table = table::read(text.as_bytes(), &Mapping::default())
            .map_err(|fault| TestCaseError::fail(format!("{fault}: {text}")))?;
        prop_assert_eq!((table.separator, table.decimal), (separator, decimal), "{}", text);
        if header {
            let of = |meaning| table.numbers(meaning).map(<[f64]>::to_vec);
            let wanted = |k: usize| Some(rows.iter().chain(&rows).map(|row| f64::from(row[k]) + 0.5).collect());
            prop_assert_eq!((of(Meaning::RollLength), of(Meaning::Deviation)), (wanted(0), wanted(1)), "{}", text);
        }
    }

    #[test]
    fn bytes_of_any_kind_are_read_or_refused(
        pieces in prop::collection::vec(prop_oneof![
            Just(b"1".to_vec()), Just(b",".to_vec()), Just(b";".to_vec()), Just(b"\t".to_vec()), Just(b" ".to_vec()),
            Just(b"\n".to_vec()), Just(b"\r".to_vec()), Just(b"\"".to_vec()), Just(b"u,v,z\n".to_vec()),
            Just(b"[A]\n".to_vec()), Just(b"x;y;z;i;j;k\n".to_vec()), Just(b"-2.5".to_vec()), Just(b"1,5".to_vec()),
            Just(b"\xFF\xFE".to_vec()), Just(b"\xC3\xA4".to_vec()), Just(b"\0".to_vec()), Just(b"#".to_vec()),
            Just(b"sep=;\n".to_vec()), Just(b"tooth,flank,deviation\n".to_vec()), prop::collection::vec(any::<u8>(), 0..6),
        ], 0..60),
        header in prop::option::of(any::<bool>()), matrix in prop::option::of(any::<bool>()),
    ) {
        let bytes = pieces.concat();
        let mapping = Mapping { header, matrix, ..Mapping::default() };
        match table::read(&bytes, &mapping) {
            Ok(table) => {
                // a matrix of n cells has 3 n numbers
                prop_assert!(table.rows() <= bytes.len() && table.columns.len() <= bytes.len() + 3);
                let _ = (table.points(), table.node_sets(), table.layout());
            }
            Err(fault) => prop_assert!(fault.to_string().len() < 2000, "{}", fault),
        }
    }
}

fn example(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join("examples/files").join(name);
    std::fs::read(path).expect("an example file")
}

/// u, v, heights row by row and the units of the columns.
type ReadGrid = (Vec<f64>, Vec<f64>, Vec<Option<f64>>, Vec<Option<Unit>>);

fn grid_of(bytes: &[u8]) -> ReadGrid {
    let Ok(GearFile::Table(table)) = gear_file::read(bytes, None, None) else { panic!("no table") };
    let units = table.columns.iter().map(|column| column.unit).collect();
    let sets = table.node_sets().expect("nodes");
    let Ok(Nodes::Grid(grid)) = &sets[0].nodes else { panic!("no grid") };
    let heights = grid.z().iter().map(|z| Some(*z).filter(|z| !z.is_nan())).collect();
    (grid.u().to_vec(), grid.v().to_vec(), heights, units)
}

/// The examples hold the same flank, and so do all variants of them.
#[test]
fn example_files_and_their_variants() {
    let wanted = grid_of(&example("flank_grid.csv"));
    assert_eq!((wanted.0.len(), wanted.1.len(), wanted.2.iter().flatten().count()), (9, 15, 132));
    let (mm, um) = (Some(Unit::Millimetre), Some(Unit::Micrometre));
    assert_eq!(wanted.3, [mm, mm, um]);
    for name in ["flank_grid.csv", "flank_german.csv", "flank_matrix.csv"] {
        let bytes = example(name);
        let text = String::from_utf8(bytes.clone()).expect("UTF-8").trim_start_matches('\u{feff}').to_owned();
        assert_eq!(grid_of(&bytes), wanted, "{name}");
        let lines: Vec<&str> = text.lines().collect();
        let mark = if name.contains("german") { ";" } else { "," };
        for (what, variant) in [
            ("UTF-16", Encoding::Utf16Little { mark: true }.bytes(&text)),
            ("UTF-16, big end first", Encoding::Utf16Big { mark: true }.bytes(&text)),
            ("a byte order mark", Encoding::Utf8WithMark.bytes(&text)),
            ("CRLF", lines.join("\r\n").into_bytes()),
            (
                "trailing separators",
                lines.iter().map(|line| format!("{line}{mark}{mark}\n")).collect::<String>().into(),
            ),
            ("tabs", text.replace(mark, "\t").into_bytes()),
            ("comments and blank lines", format!("# one\n\n{}\n% two\n", lines.join("\n\n")).into_bytes()),
            ("a block", format!("[Flank 1]\n{text}").into_bytes()),
            ("Latin-1", text.chars().map(|c| u8::try_from(u32::from(c)).unwrap_or(b'?')).collect()),
        ] {
            assert_eq!(grid_of(&variant), wanted, "{name}: {what}");
        }
        // heights in mm stay the numbers of the file
        let heights_in_mm = text.replace("deviation_um", "deviation_mm").replace("[µm]", "[mm]");
        let found = grid_of(heights_in_mm.as_bytes());
        assert_eq!((found.2, found.3), (wanted.2.clone(), vec![mm, mm, mm]), "{name}");
    }
    let Ok(GearFile::Table(table)) = gear_file::read(&example("points.txt"), None, None) else { panic!("no table") };
    assert_eq!((table.separator, table.layout()), (Separator::Spaces, Some(Layout::Points)));
    let points = table.points().expect("points");
    assert_eq!(points.len(), 30);
    assert!(points.iter().all(|point| point.direction.is_some_and(|direction| (direction.norm() - 1.0).abs() < 1e-4)));
}

/// The nodes of a gear tester with two columns of deviations, of which the one by DIN is read.
#[test]
fn nodes_of_a_gear_tester() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/p40/97340-neu_nodes.csv");
    let table = table::read(&std::fs::read(path).expect("a file"), &Mapping::default()).expect("a table");
    let meanings: Vec<Meaning> = table.columns.iter().map(|column| column.meaning).collect();
    assert_eq!(
        meanings,
        [
            Meaning::Flank,
            Meaning::Tooth,
            Meaning::Trace,
            Meaning::Id,
            Meaning::Ignore,
            Meaning::RollLength,
            Meaning::FaceWidth,
            Meaning::Ignore,
            Meaning::Deviation,
        ]
    );
    let sets = table.node_sets().expect("nodes");
    assert_eq!((sets[0].tooth.as_deref(), sets[0].layout), (Some("1"), Layout::Scattered));
}
