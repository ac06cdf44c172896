//! Lists of points: what is read is written and read again to the same points.
#![no_main]

use flankfit_engine::formats::points::{ListedPoint, read, write};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok(points) = read(bytes) else { return };
    let text = write(&points).expect("what was read is finite");
    if !points.is_empty() {
        let places = |points: &[ListedPoint]| points.iter().map(|p| (p.point, p.direction)).collect::<Vec<_>>();
        assert_eq!(places(&read(text.as_bytes()).expect("what was written")), places(&points));
    }
});
