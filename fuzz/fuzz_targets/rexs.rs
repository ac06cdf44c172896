//! Gear models in XML.
#![no_main]

use flankfit_engine::formats::rexs::read;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(model) = read(bytes) {
        let _ = model.gear(None);
        for gear in &model.gears {
            let _ = gear.facts.gear_data();
        }
    }
});
