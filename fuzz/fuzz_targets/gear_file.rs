//! The door for all files: every fault lies within the file.
#![no_main]

use flankfit_engine::formats::gear_file::read;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    for name in [None, Some("a.mka"), Some("a.mew"), Some("a.csv"), Some("a.rexs")] {
        if let Err(fault) = read(bytes, name, None)
            && let Some(place) = fault.place()
        {
            let lines = bytes.iter().filter(|b| **b == b'\n').count() + 1;
            assert!((1..=lines).contains(&place.line) && (1..=bytes.len() + 1).contains(&place.column), "{fault}");
        }
    }
});
