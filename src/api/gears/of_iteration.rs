//! Checks that data stored with an iteration are of its flank and tooth.

use crate::api::faults::Faults;
use crate::jobs::Measurand;
use flankfit_engine::gear::{
    Side,
    tooth::{Position, canonical},
};

/// The tooth that something is said to be of.
#[derive(Clone, Copy, Debug)]
pub enum ToothOf<'a> {
    Named(&'a str),
    Counted(u32),
    /// Nobody can say, as of a part that lies turned by any number of pitches.
    Unknown,
}

/// The number of the measured tooth, where it has one.
pub fn tooth_number(of: &Measurand) -> Option<u32> {
    Position::number(of.tooth.as_deref()?).and_then(|number| u32::try_from(number).ok())
}

/// Refuses data that are entirely of other flanks or teeth than the iteration: a record may hold
/// more than its iteration, not something else. The error is at the first place for flanks, at the
/// second for teeth.
pub fn refuse_others<'a>(
    of: &Measurand,
    flanks: impl Iterator<Item = (ToothOf<'a>, Side)>,
    [flank_at, tooth_at]: [&str; 2],
) -> Result<(), Faults> {
    let own = of.tooth.as_deref().map(own_name);
    let number = tooth_number(of);
    let same_tooth = |tooth: ToothOf<'_>| match (tooth, &own) {
        (ToothOf::Unknown, _) | (_, None) => true,
        (ToothOf::Named(name), Some(own)) => own_name(name) == *own,
        // a tooth that has a name may be any of those counted
        (ToothOf::Counted(tooth), Some(_)) => number.is_none_or(|number| number == tooth),
    };
    let (mut first, mut on_flank) = (None, None);
    for (tooth, side) in flanks {
        let same_flank = of.flank.is_none_or(|flank| flank == side);
        if same_flank && same_tooth(tooth) {
            return Ok(());
        }
        first = first.or(Some((tooth, side)));
        on_flank = on_flank.or(Some((tooth, side)).filter(|_| same_flank));
    }
    let Some((tooth, side)) = on_flank.or(first) else { return Ok(()) };
    let tooth = match tooth {
        ToothOf::Named(name) => Some(name.chars().take(20).collect()),
        ToothOf::Counted(tooth) => Some(tooth.to_string()),
        ToothOf::Unknown => None,
    };
    let other =
        Measurand { flank: Some(side), tooth: tooth.filter(|_| own.is_some()), axes: None, accept_units: false };
    let detail = format!("the iteration is of {}, not of {}", of.words(), other.words());
    Err(Faults::one(if on_flank.is_some() { tooth_at } else { flank_at }, detail))
}

/// Returns the name of the tooth without the letter of a trace off its middle.
fn own_name(tooth: &str) -> String {
    let tooth = canonical(tooth).unwrap_or_else(|_| tooth.to_owned());
    Position::split(&tooth).0.to_owned()
}
