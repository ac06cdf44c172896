//! Value files.
#![no_main]

use flankfit_engine::formats::klingelnberg::read_values;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(file) = read_values(&[b"HEADER KS.MW.FILE\n", bytes].concat()) {
        assert!(file.results.len() <= bytes.len());
        assert!(file.results.iter().all(|result| result.reading.value().is_none_or(f64::is_finite)));
    }
});
