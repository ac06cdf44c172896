//! Evaluates a profile and a helix trace by ISO 1328-1.
//!
//! Run: `cargo run -p flankfit-engine --example evaluate_traces`

use std::error::Error;

use flankfit_engine::gear::{
    Gear, GearData, Kind, Side, Trace,
    evaluation::{
        Posted, evaluate,
        settings::{HelixSettings, ProfileSettings, Settings},
    },
};

fn main() -> Result<(), Box<dyn Error>> {
    let gear = Gear::new(GearData { face_width: Some(20.0), ..GearData::spur(52, 1.0) })?;
    let range = [50.5, 53.5];
    let [from, to] = range.map(|diameter| gear.roll_length(diameter).expect("above the base circle"));

    // 480 samples each: a slope and a ripple along the profile, a crowning along the helix. µm over
    // roll length and over z, in mm.
    let samples = |from: f64, to: f64| (0..480).map(move |k| from + (to - from) * f64::from(k) / 479.0);
    let trace = |kind, at: Vec<f64>, deviation: &dyn Fn(f64) -> f64| Trace {
        tooth: "1".into(),
        side: Side::Left,
        kind,
        deviation: at.iter().map(|&at| deviation(at)).collect(),
        at,
        section: None,
    };
    let profile = trace(Kind::Profile, samples(from, to).collect(), &|l| 2.0 * (l - from) + 0.4 * (9.0 * l).sin());
    let helix = trace(Kind::Helix, samples(1.0, 19.0).collect(), &|z| -5.0 * ((z - 10.0) / 9.0).powi(2));

    let settings = Settings {
        profile: Some(ProfileSettings::on(range)),
        helix: Some(HelixSettings::on([1.0, 19.0])),
        ..Settings::default()
    };
    let posted = [&profile, &helix].map(|trace| Posted { trace, design: None });
    let evaluation = evaluate(&gear, &posted, &settings)?;
    for trace in &evaluation.traces {
        let Some(values) = trace.values else { continue };
        println!(
            "{:?}: slope {:6.2}, form {:5.2}, total {:5.2}, crowning {:5.2} µm",
            trace.kind, values.slope_um, values.form_um, values.total_um, values.crowning_um
        );
    }
    println!("class: {:?}", evaluation.class);
    for warning in &evaluation.warnings {
        println!("{}: {}", warning.code(), warning);
    }
    Ok(())
}
