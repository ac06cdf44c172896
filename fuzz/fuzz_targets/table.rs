//! Tables of nodes and points: bytes of any kind are read or refused; what is read of points is
//! written and read again to the same points.
#![no_main]

use flankfit_engine::formats::table::{ListedPoint, Mapping, read, write_points};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok(table) = read(bytes, &Mapping::default()) else { return };
    let _ = table.node_sets();
    let Ok(points) = table.points() else { return };
    let text = write_points(&points).expect("what was read is finite");
    if !points.is_empty() {
        let places = |points: &[ListedPoint]| points.iter().map(|p| (p.point, p.direction)).collect::<Vec<_>>();
        let again = read(text.as_bytes(), &Mapping::default()).and_then(|table| table.points());
        assert_eq!(places(&again.expect("what was written")), places(&points));
    }
});
