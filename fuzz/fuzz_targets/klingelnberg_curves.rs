//! Curve files: no panic on the way from bytes to traces with positions.
#![no_main]

use flankfit_engine::{formats::klingelnberg::{SignConvention, read_curves}, gear::Gear};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    // beginning with the first line, the mutations reach what is behind it
    let Ok(file) = read_curves(&[b"HEADER KS.MK.FILE\n", bytes].concat()) else { return };
    let facts = file.header.gear(&mut Default::default());
    let _ = (file.header.profile_setup(), file.header.helix_setup(), file.header.rules());
    assert!(file.curves.iter().map(|curve| curve.values.len()).sum::<usize>() <= bytes.len());
    if let Ok(gear) = facts.gear_data().map_err(drop).and_then(|data| Gear::new(data).map_err(drop)) {
        let placed = file.place(&gear).with_sense(file.signs(), SignConvention::Material);
        assert_eq!(placed.traces.len() + placed.unplaced.len(), file.curves.len());
    }
});
