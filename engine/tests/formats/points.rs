//! Lists of points: every spelling of the same list, the way out and back, and faults with their
//! places.

use flankfit_engine::{
    formats::{
        ExportFault, FileError, FilePosition,
        points::{ListedPoint, read, write},
    },
    geometry::space::Vector,
};
use proptest::prelude::*;

fn point(id: Option<&str>, point: [f64; 3], direction: Option<[f64; 3]>, line: usize) -> ListedPoint {
    ListedPoint { id: id.map(String::from), point: Vector::from(point), direction: direction.map(Vector::from), line }
}

#[test]
fn spellings_of_a_list() {
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
        "k,j,i,z,y,x,id\n-0.8,0.6,0,0.25,-2,1.5,\"a1\"\n0,0,1,12,0,1e-3,a2\n",
    ] {
        let mut points = read(text.as_bytes()).unwrap_or_else(|fault| panic!("{text}: {fault}"));
        points.iter_mut().for_each(|point| point.line = 0);
        assert_eq!(points, wanted, "{text}");
    }
    assert_eq!(read(b"1,2,3\n4,5,6\n").unwrap()[1], point(None, [4.0, 5.0, 6.0], None, 2));
    assert_eq!(read(b"7,1,2,3\n").unwrap()[0], point(Some("7"), [1.0, 2.0, 3.0], None, 1));
    assert_eq!(read(b"1,2,3,0,0,1\n").unwrap()[0], point(None, [1.0, 2.0, 3.0], Some([0.0, 0.0, 1.0]), 1));
    // a direction that was not measured
    assert_eq!(read(b"p,1,2,3,,,\n").unwrap()[0], point(Some("p"), [1.0, 2.0, 3.0], None, 1));
    assert_eq!(read("\"Z\u{e4}hne, \"\"1\"\"\",1,2,3".as_bytes()).unwrap()[0].id.as_deref(), Some("Zähne, \"1\""));
    assert_eq!(read(b"x,y,z\n").unwrap(), []);
}

#[test]
fn faults_have_places() {
    for (text, line, column, wanted) in [
        ("1,2\n", 1, 1, "3, 4, 6 or 7 columns"),
        ("1,2,3\n4,5\n", 2, 4, "as many columns as the first line has"),
        ("1,2,3\n4,5,6,7\n", 2, 7, "as many columns as the first line has"),
        ("x,y,z\n1,zwei,3\n", 2, 3, "a number, found “zwei”"),
        ("x,y,z\n1,,3\n", 2, 3, "a number, found nothing"),
        ("x,y,z\n1,nan,3\n", 2, 3, "a number"),
        ("id,x,y\n1,2,3\n", 1, 6, "the columns x, y and z"),
        ("x,y,z,i\n1,2,3,1\n", 1, 7, "all of the columns i, j and k"),
        ("x,y,y,z\n", 1, 5, "each column once"),
        ("x,y,z,colour\n", 1, 7, "one of the columns"),
        ("1.5;2;3\n1,5;2;3\n", 2, 1, "the decimal mark that the numbers before it have"),
        ("1,500.2;2;3\n", 1, 1, "a number"),
        ("1,5;2.5;3\n", 1, 5, "the decimal mark"),
        ("p,1,2,3,0,0,0\n", 1, 9, "a direction that is not zero"),
        ("p,1,2,3,1,,0\n", 1, 11, "a number, found nothing"),
        ("\"p,1,2,3\n", 1, 1, "a closing quote"),
        ("\"p\"x,1,2,3\n", 1, 4, "the separator after a closing quote"),
        ("ä,1,2,x3\n", 1, 7, "a number"),
    ] {
        let fault = read(text.as_bytes()).expect_err(text);
        assert_eq!(fault.place(), Some(FilePosition { line, column }), "{text}: {fault}");
        assert!(fault.to_string().contains(wanted), "{text}: {fault}");
    }
    assert_eq!(read(b"# nothing\n"), Err(FileError::Empty));
    let bad = [point(None, [1.0, 2.0, 3.0], None, 0), point(None, [f64::NAN, 2.0, 3.0], None, 0)];
    assert_eq!(write(&bad), Err(ExportFault::NodeRange { index: 1 }));
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
            // blanks at the ends and no name at all are what a file cannot tell
            point(id.as_deref().map(str::trim).filter(|id| !id.is_empty()), *at, *direction, 0)
        }).collect();
        let text = write(&points).unwrap();
        let mut back = read(text.as_bytes()).unwrap();
        back.iter_mut().for_each(|point| point.line = 0);
        prop_assert_eq!(back, points);
    }
}
