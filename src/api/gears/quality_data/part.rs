//! Names of a part in quality data.

use super::kept::Kept;
use flankfit_engine::{
    formats::qdas::{Part, one_line},
    gear::{Gear, Hand},
    words::Shown,
};

/// The part: by its number, or by the job's name where it has none, or by the gear.
pub fn part(gear: Option<&Gear>, kept: Option<&Kept>) -> Part {
    let job = kept.map(|kept| &kept.job);
    let details = kept.map(|kept| &kept.details);
    let own = job.and_then(|job| job.part_number.as_ref().or(Some(&job.name))).filter(|name| !is_blank(name));
    let named = gear.map_or_else(|| "Gear".to_owned(), name);
    Part {
        number: own.cloned().unwrap_or_else(|| gear.map_or_else(|| "Gear".to_owned(), short)),
        name: job.map(|job| job.name.clone()).filter(|name| !is_blank(name)).unwrap_or(named),
        machine: job.and_then(|job| job.machine.clone()),
        instrument: details.and_then(|details| details.instrument.clone()),
        operator: details.and_then(|details| details.operator.clone()),
    }
}

/// Whether nothing of a name can be written.
fn is_blank(name: &str) -> bool {
    one_line(name, 1).is_empty()
}

fn short(gear: &Gear) -> String {
    format!("Gear z {} m {}", gear.data().teeth, Shown(gear.data().normal_module))
}

fn name(gear: &Gear) -> String {
    let data = gear.data();
    let mut name = format!("Gear, {} teeth, normal module {} mm", data.teeth, Shown(data.normal_module));
    if data.helix_angle > 0.0 {
        let hand = match data.hand {
            Hand::Right => "right",
            Hand::Left => "left",
        };
        // a name needs no more digits than a drawing has
        let angle = (data.helix_angle.to_degrees() * 1e4).round() / 1e4;
        name.push_str(&format!(", helix {}° {hand}", Shown(angle)));
    }
    name
}
