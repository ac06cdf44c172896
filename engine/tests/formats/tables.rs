//! Tables of nodes and points: what their headers say, every spelling of the same list, the way out
//! and back, and refusals with their places.

use flankfit_engine::{
    estimation::Nodes,
    formats::{
        FileError, Table,
        table::{
            self, ColumnSpec, Decimal, Layout, ListedPoint, Mapping, Meaning, Separator, Shape, Unit, write_points,
        },
    },
    gear::Side,
    geometry::space::Vector,
};
use proptest::prelude::*;

fn read(text: &[u8]) -> Result<Table, FileError> {
    table::read(text, &Mapping::default())
}

fn points(text: &[u8]) -> Result<Vec<ListedPoint>, FileError> {
    read(text)?.points()
}

fn point(id: Option<&str>, point: [f64; 3], direction: Option<[f64; 3]>, line: usize) -> ListedPoint {
    ListedPoint { id: id.map(String::from), point: Vector::from(point), direction: direction.map(Vector::from), line }
}

/// The nodes of a table with one flank.
fn nodes(table: &Table) -> Nodes {
    let sets = table.node_sets().expect("nodes");
    assert_eq!(sets.len(), 1);
    sets[0].nodes.clone().expect("sound nodes")
}

#[test]
fn spellings_of_a_list_of_points() {
    let wanted = [
        point(Some("a1"), [1.5, -2.0, 0.25], Some([0.0, 0.6, -0.8]), 0),
        point(Some("a2"), [1e-3, 0.0, 12.0], Some([1.0, 0.0, 0.0]), 0),
    ];
    for text in [
        "id,x,y,z,i,j,k\na1,1.5,-2,.25,0,0.6,-0.8\na2,1e-3,0,12.,1,0,0\n",
        "\u{feff}a1,1.5,-2,.25,0,0.6,-0.8\r\na2,1e-3,0,12.,1,0,0\r\n",
        "# made by hand\n\nID; X; Y; Z; I; J; K\n a1 ; 1.5 ; -2 ; .25 ; 0 ; 0.6 ; -0.8\n# more\na2;1e-3;0;12;1;0;0",
        "a1;1,5;-2;,25;0;0,6;-0,8\na2;0,001;0;12;1;0;0\n",
        "a1\t1.5\t-2\t.25\t0\t.6\t-.8\na2\t1e-3\t0\t12\t1\t0\t0\n",
        "a1 1.5 -2 .25  0 .6 -.8\na2 1e-3 0 12 1 0 0",
        "k,j,i,z,y,x,id\n-0.8,0.6,0,0.25,-2,1.5,\"a1\"\n0,0,1,12,0,1e-3,a2\n",
        "id,x [um],y [mm],z [mm],nx,ny,nz,\na1,1500,-2,.25,0,0.6,-0.8,\na2,1,0,12.,1,0,0,\n",
    ] {
        let mut list = points(text.as_bytes()).unwrap_or_else(|fault| panic!("{text}: {fault}"));
        list.iter_mut().for_each(|point| point.line = 0);
        assert_eq!(list, wanted, "{text}");
    }
    assert_eq!(points(b"1,2,3\n4,5,6\n").unwrap()[1], point(None, [4.0, 5.0, 6.0], None, 2));
    assert_eq!(points(b"7,1,2,3\n").unwrap()[0], point(Some("7"), [1.0, 2.0, 3.0], None, 1));
    assert_eq!(points(b"1,2,3,0,0,1\n").unwrap()[0], point(None, [1.0, 2.0, 3.0], Some([0.0, 0.0, 1.0]), 1));
    // a direction that was not measured
    assert_eq!(points(b"p,1,2,3,,,\nq,1,2,3,1,0,0\n").unwrap()[0], point(Some("p"), [1.0, 2.0, 3.0], None, 1));
    assert_eq!(points("\"Z\u{e4}hne, \"\"1\"\"\",1,2,3".as_bytes()).unwrap()[0].id.as_deref(), Some("Zähne, \"1\""));
    assert_eq!(points(b"x,y,z\n").unwrap(), []);
    // as a coordinate measuring machine writes them
    let text = b"[A]\r\n   1;     3.562;    26.947;    85.954; \r\n   2;     3.552;    26.949;    85.954; \r\n";
    assert_eq!(points(text).unwrap()[1], point(Some("A 2"), [3.552, 26.949, 85.954], None, 3));
}

#[test]
fn headers_in_any_words() {
    let of = |text: &str| {
        let table = read(text.as_bytes()).unwrap_or_else(|fault| panic!("{text}: {fault}"));
        let columns: Vec<(&str, Option<&str>)> =
            table.columns.iter().map(|column| (column.meaning.name(), column.unit.map(Unit::name))).collect();
        (columns, table.layout())
    };
    let rows = "1;2;3\n1;3;4\n2;2;5\n2;3;6\n";
    for (header, wanted) in [
        (
            "Rollweg [mm];Breite;Abweichung in µm\n",
            [("roll_length", Some("mm")), ("face_width", Some("mm")), ("deviation", Some("um"))],
        ),
        ("d;z_mm;Abw [nm]\n", [("diameter", Some("mm")), ("face_width", Some("mm")), ("deviation", Some("nm"))]),
        (
            "wälzwinkel (rad);breite (in);fehler (in)\n",
            [("roll_angle", Some("rad")), ("face_width", Some("in")), ("deviation", Some("in"))],
        ),
        (
            "Rollweg;Breite;Abweichung\n[mm];[mm];[mm]\n",
            [("roll_length", Some("mm")), ("face_width", Some("mm")), ("deviation", Some("mm"))],
        ),
        (
            "Messprotokoll\nTeil;4711\nRollweg;Breite;Ergebnis\n",
            [("roll_length", Some("mm")), ("face_width", Some("mm")), ("deviation", Some("um"))],
        ),
        ("# u v z\n", [("u", None), ("v", None), ("z", None)]),
        ("foo;bar;baz\n", [("u", None), ("v", None), ("z", None)]),
        ("u,v,z\n", [("u", None), ("v", None), ("z", None)]),
        ("", [("u", None), ("v", None), ("z", None)]),
    ] {
        assert_eq!(of(&format!("{header}{rows}")), (wanted.to_vec(), Some(Layout::Grid)), "{header}");
    }
    let (columns, layout) = of("x,y,weight\n0,1,1\n1,,1\n");
    assert_eq!((columns[2].0, layout), ("weight", Some(Layout::Curve)));
    assert_eq!(of("a,b\n1,2\n3,4\n").1, Some(Layout::Curve));
    assert_eq!(of("rubbish,roll length,rest\n1,1,2\n2,2,c\n").1, None);
}

#[test]
fn a_grid_may_have_holes_and_any_order() {
    let whole = "u,v,z\n2,10,5\n1,20,4\n1,10,3\n2,20,\n3,10,7\n";
    let Nodes::Grid(grid) = nodes(&read(whole.as_bytes()).unwrap()) else { panic!("no grid") };
    assert_eq!((grid.u(), grid.v()), (&[1.0, 2.0, 3.0][..], &[10.0, 20.0][..]));
    assert_eq!(grid.z().iter().map(|z| z.is_nan()).collect::<Vec<_>>(), [false, false, false, true, false, true]);
    let sets = read(whole.as_bytes()).unwrap().node_sets().unwrap();
    assert_eq!((sets[0].count, sets[0].missing), (4, 2));
    for scattered in ["u,v,z\n1,1,1\n1,1,2\n1,2,1\n2,1,1\n2,2,1\n", "u,v,z\n1,1.1,1\n2,1.2,2\n3,1.3,1\n4,1.4,1\n"] {
        assert_eq!(read(scattered.as_bytes()).unwrap().layout(), Some(Layout::Scattered), "{scattered}");
    }
    let as_scattered = Mapping { layout: Some(Layout::Scattered), ..Mapping::default() };
    let Nodes::Scattered(list) = nodes(&table::read(whole.as_bytes(), &as_scattered).unwrap()) else { panic!() };
    assert_eq!(list.z(), [5.0, 4.0, 3.0, 7.0]);
    let weighted = "u,v,z,weight\n1,1,1,2\n1,2,,\n2,1,1,1\n2,2,1,3\n";
    let Nodes::Grid(grid) = nodes(&read(weighted.as_bytes()).unwrap()) else { panic!("no grid") };
    assert_eq!(grid.weight(), Some(&[2.0, 1.0, 1.0, 3.0][..]));
}

#[test]
fn teeth_and_flanks_are_separate_node_sets() {
    let mut text = "Zahn;Flanke;Rollweg;Breite;Abweichung\n".to_owned();
    for (tooth, flank) in [("1", "links"), ("2f", "L"), ("1", "R")] {
        for k in 0..4 {
            text += &format!("{tooth};{flank};{};{};0,{k}\n", k / 2, k % 2);
        }
    }
    let sets = read(text.as_bytes()).unwrap().node_sets().unwrap();
    let of: Vec<_> = sets.iter().map(|set| (set.tooth.as_deref(), set.flank, set.layout)).collect();
    let grid = Layout::Grid;
    assert_eq!(
        of,
        [
            (Some("1"), Some(Side::Left), grid),
            (Some("1"), Some(Side::Right), grid),
            (Some("2"), Some(Side::Left), grid)
        ]
    );
    let misspelt = read(text.replacen("links", "linkss", 1).as_bytes()).unwrap();
    let wanted = "line 2: `linkss` is not a flank; write left, l, links, linke, lf for left and right, r, rechts, \
                  rechte, rf for right";
    assert_eq!(misspelt.node_sets().unwrap_err().to_string(), wanted);
    assert_eq!(misspelt.layout(), None);
}

/// A helix at roll length 7 with the height 2 + z, and a profile at z = 2 with the height 4, of
/// which one file counts the helix the other way.
#[test]
fn helices_are_turned_where_they_contradict_the_profiles() {
    let file = |sign: f64| {
        let mut text = "flank,tooth_tag,trace,roll_length_mm,z_mm,deviation_um\n".to_owned();
        // from the far end
        for k in (0..5).rev() {
            text += &format!("right,1,lead,7,{k},{}\n", sign * f64::from(2 + k));
            for z in 0..4 {
                text += &format!("right,1,profile,{},{z},{}\n", 5 + k, 2 + z);
            }
        }
        text + &format!("right,1k,lead,7,9,\nright,12,lead,7,0,{sign}\n")
    };
    let of = |sign: f64| read(file(sign).as_bytes()).unwrap().node_sets().unwrap();
    let (given, opposite) = (of(1.0), of(-1.0));
    assert_eq!((given[0].count, given[0].missing, given[1].tooth.as_deref()), (25, 1, Some("12")));
    // at the four crossings both have 2, 3, 4 and 5
    let apart = 54.0_f64.sqrt();
    let crossings = given[0].crossings.expect("they cross");
    assert_eq!((crossings.as_given, crossings.turned, crossings.helices_are_turned()), (0.0, apart, false));
    let crossings = opposite[0].crossings.expect("they cross");
    assert_eq!((crossings.as_given, crossings.turned, crossings.helices_are_turned()), (apart, 0.0, true));
    assert_eq!(given[0].nodes, opposite[0].nodes);
    // a helix that crosses nothing goes by those of the other teeth
    assert_eq!((opposite[1].crossings, &opposite[1].nodes), (opposite[0].crossings, &given[1].nodes));
}

#[test]
fn names_of_columns_are_bounded_and_those_of_the_table() {
    let long = "é".repeat(1000);
    let table = read(format!("{long};Breite;Rest {long}\n1;2;3\n2;2;3\n").as_bytes()).unwrap();
    assert_eq!(table.columns[0].name, "é".repeat(200));
    assert!(table.notes.iter().all(|note| note.to_string().chars().count() < 400), "{:?}", table.notes);
    let other = ColumnSpec { name: "of the caller".to_owned(), meaning: Meaning::U, unit: None };
    let columns = [Meaning::U, Meaning::V, Meaning::Z].map(|meaning| ColumnSpec { meaning, ..other.clone() });
    let mapping = Mapping { columns: Some(columns.to_vec()), ..Mapping::default() };
    let names = |text: &str| {
        let columns = table::read(text.as_bytes(), &mapping).unwrap().columns;
        columns.into_iter().map(|column| column.name).collect::<Vec<_>>()
    };
    assert_eq!(names("a;b;c\n1;2;3\n"), ["a", "b", "c"]);
    assert_eq!(names("1;2;3\n"), ["", "", ""]);
    assert_eq!(names("a \\ b;1;2\n1;2;3\n2;2;3\n"), ["a", "b", ""]);
}

#[test]
fn the_form_of_a_table() {
    let of = |text: &str| table::shape(text.as_bytes());
    let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    let shape = Shape {
        separator: Separator::Semicolon,
        decimal: Decimal::Comma,
        columns: 3,
        names: names(&["Tiefe", "Ort", "Wert"]),
    };
    assert_eq!(of("Tiefe;Ort;Wert\n1,5;2;3\n").as_ref(), Some(&shape));
    assert_eq!(of("1,5;2;3\n"), Some(Shape { names: Vec::new(), ..shape.clone() }));
    assert_eq!(of("u;1,5;2;3\n1;2;3;4\n2;3;4;5\n"), Some(Shape { names: names(&["u"]), ..shape }));
    assert_eq!(of("no numbers\n"), None);
}

#[test]
fn refusals_say_one_thing_of_the_file() {
    let many = |row: &str| format!("u,v,z\n{}", format!("{row}\n").repeat(135));
    for (text, mapping, wanted, places) in [
        (
            many("5,9;7;-1,0"),
            Mapping { separator: Some(Separator::Comma), ..Mapping::default() },
            "135 cells are not finite numbers; with decimal commas they are",
            5,
        ),
        (
            many("5,97;0,75;-10,28"),
            Mapping { separator: Some(Separator::Comma), ..Mapping::default() },
            "135 rows have 4 cells for 3 columns; with decimal commas they have 3: send `decimal: \",\"`",
            5,
        ),
        (many("5,97,0,75,-10,28"), Mapping::default(), "a comma cannot be both", 5),
        ("x,y,z\n1,zwei,3\n".into(), Mapping::default(), "1 cell is not a finite number", 1),
        ("x,y,z\n1,,3\n".into(), Mapping::default(), "line 2, column 2 (y): empty", 1),
        ("x,y,z\n1,nan,3\n".into(), Mapping::default(), "`nan`", 1),
        ("1,2,3\n4,5,6\n7,8,9,10\n".into(), Mapping::default(), "1 row has 4 cells for 3 columns", 1),
        ("1.5;2;3\n1,5;2;3\n1.5;2;4\n".into(), Mapping::default(), "line 2, column 1: `1,5`", 1),
        ("hello\nworld\n".into(), Mapping::default(), "no line of the table has two numbers", 0),
        ("# nothing\n".into(), Mapping::default(), "the file is empty", 0),
    ] {
        let fault = match table::read(text.as_bytes(), &mapping) {
            Err(fault) => fault,
            Ok(_) if places == 0 => continue,
            Ok(table) => panic!("{text}: {table:?}"),
        };
        assert!(fault.to_string().contains(wanted), "{text:.40}: {fault}");
        if let FileError::Table(fault) = &fault {
            assert_eq!(fault.places.len(), places, "{text:.40}: {fault}");
        }
    }
    for (text, wanted) in [
        ("id,x,y\n1,2,3\n4,5,6\n", "OTHER"),
        ("x,y,z,i\n1,2,3,1\n", "give all of i, j and k or none"),
        ("p,1,2,3,0,0,0\n", "not a direction"),
        ("roll length,rest,more\n1,2,3\n", "none of them has heights"),
        ("u,v,z\n1,2,3\n", "the table holds scattered nodes"),
    ] {
        let fault = points(text.as_bytes()).expect_err(text);
        assert!(wanted == "OTHER" || fault.to_string().contains(wanted), "{text}: {fault}");
    }
    let bad = [point(None, [1.0, 2.0, 3.0], None, 0), point(None, [f64::NAN, 2.0, 3.0], None, 0)];
    assert_eq!(write_points(&bad).unwrap_err().to_string(), "node 1 exceeds the range of the file's numbers");
}

#[test]
fn a_mapping_takes_precedence_over_detection() {
    let column = |meaning, unit| ColumnSpec { name: String::new(), meaning, unit };
    let swapped = Mapping {
        columns: Some(vec![
            column(Meaning::FaceWidth, None),
            column(Meaning::Deviation, Some(Unit::Millimetre)),
            column(Meaning::Diameter, Some(Unit::Inch)),
        ]),
        ..Mapping::default()
    };
    let read = |mapping: &Mapping| table::read(b"u,v,z\n1,2,3\n2,2.5,3\n", mapping);
    let table = read(&swapped).unwrap();
    assert_eq!(table.columns[0].unit, Some(Unit::Millimetre));
    let Nodes::Scattered(list) = nodes(&table) else { panic!("no list") };
    assert_eq!((list.u(), list.v(), list.z()), (&[3.0, 3.0][..], &[1.0, 2.0][..], &[2.0, 2.5][..]));
    let columns = |columns| Mapping { columns: Some(columns), ..Mapping::default() };
    for (mapping, wanted) in [
        (columns(vec![column(Meaning::U, None)]), "the mapping has 1 column for 3 columns"),
        (columns(vec![column(Meaning::U, None); 3]), "two columns are `u`"),
        (
            columns(vec![
                column(Meaning::Diameter, Some(Unit::Degree)),
                column(Meaning::Ignore, None),
                column(Meaning::Ignore, None),
            ]),
            "`diameter` is not in `deg`",
        ),
        (Mapping { layout: Some(Layout::Grid), ..Mapping::default() }, "not nodes on a grid"),
        (Mapping { decimal: Some(Decimal::Comma), ..Mapping::default() }, "not a finite number"),
    ] {
        let fault = read(&mapping).expect_err(wanted);
        assert!(fault.to_string().contains(wanted), "{fault}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn out_and_back(
        rows in prop::collection::vec(
            (prop::option::of("[ -~äß]{0,8}"), [-1e9f64..1e9, -1.0..1.0, 1e-300..1e-290],
                prop::option::of([-1.0f64..1.0, 0.5..1.0, -1.0..1.0])),
            1..20,
        )
    ) {
        let points: Vec<ListedPoint> = rows.iter().map(|(id, at, direction)| {
            // blanks at the ends and an empty name are lost in a file
            point(id.as_deref().map(str::trim).filter(|id| !id.is_empty()), *at, *direction, 0)
        }).collect();
        let text = write_points(&points).unwrap();
        let mut back = self::points(text.as_bytes()).unwrap();
        back.iter_mut().for_each(|point| point.line = 0);
        prop_assert_eq!(back, points);
    }
}
