//! A stored correction of the gear with the answer of the next round of measurements.

use super::{
    applied::AppliedChangesBody,
    blocks::How,
    chosen::{changed_by_fits, to_compare},
    figures::SidedBody,
    include::CorrectionInclude,
    request::Read,
    result::CorrectionResultBody,
    same_nodes::Measured,
    sensitivity::Level,
    stored::{Judged, Later, MachineAnswerBody, Made, first, implausible, whole},
};
use crate::{api::problem::Problem, jobs::Record};
use flankfit_engine::gear::{
    Gear, Side,
    correction::{Measurements, TeethMean, compare_figures},
    evaluation::tooth_shift::ToothShift,
};

/// Measurements before and after a correction of the gear.
pub struct Round<'a> {
    /// The iterations that it was made for.
    pub before: Vec<&'a Measured>,
    /// The newest iteration of each tooth and flank of the next round.
    pub after: Vec<&'a Measured>,
}

/// Flanks and iterations of a stored correction of the gear.
pub struct MadeFor {
    /// In words.
    pub flanks: String,
    pub iterations: Vec<u32>,
}

impl MadeFor {
    /// Reads it of the record.
    pub fn of(record: &Record) -> Result<Self, Problem> {
        let CorrectionResultBody { iterations, flanks, .. } = CorrectionResultBody::of(record)?;
        let flanks = match flanks.as_deref() {
            Some([Side::Left]) => "the left flank",
            Some([Side::Right]) => "the right flank",
            _ => "both flanks",
        };
        Ok(MadeFor { flanks: flanks.to_owned(), iterations: iterations.unwrap_or_default() })
    }
}

/// Returns a stored correction of the gear as JSON. `applied` is what was entered after
/// it; `today` is the gear of the job. Processor work.
pub fn write(
    record: &Record,
    applied: Option<AppliedChangesBody>,
    round: &Round<'_>,
    tooth_shift: Option<ToothShift>,
    today: Option<&Gear>,
    include: CorrectionInclude,
) -> Result<Vec<u8>, Problem> {
    let compared = match (round.after.is_empty(), round.after.iter().find_map(|one| implausible(one))) {
        (true, _) => (None, None),
        (false, Some(why)) => (None, Some(why)),
        (false, None) => match answer(record, applied.as_ref(), round, today)? {
            Ok(mut answer) => {
                if !include.nodes {
                    (answer.predicted_um, answer.measured_um) = (None, None);
                }
                (Some(answer), None)
            }
            Err(why) => (None, Some(why)),
        },
    };
    whole(record, CorrectionResultBody::of(record)?, applied, compared, tooth_shift, include)
}

fn answer(
    record: &Record,
    applied: Option<&AppliedChangesBody>,
    round: &Round<'_>,
    today: Option<&Gear>,
) -> Result<Result<MachineAnswerBody, String>, Problem> {
    let made = match Made::of(record, today)? {
        Ok(made) => made,
        Err(why) => return Ok(Err(why)),
    };
    let Round { before, after } = round;
    let Read { spec, nodes, .. } = match made.read(before, Level::Gear) {
        Ok(earlier) => earlier,
        Err(why) => return Ok(Err(why)),
    };
    let flanks: Vec<Side> = nodes.blocks.iter().filter_map(|block| block.side).collect();
    if Some(flanks) != made.result.flanks {
        return Ok(Err("flank, tooth or axes of the corrected iterations have changed since".to_owned()));
    }
    let sensitivity = &made.request.sensitivity;
    let how = How { sensitivity, level: Level::Gear, gear: made.gear(), absolute: None, trace: None };
    let means = match nodes.again(before, after, how) {
        Ok(means) => means,
        Err(faults) => return Ok(Err(first(&faults))),
    };
    let count = |later: bool| -> usize {
        let pairs = nodes.blocks.iter().zip(&means).filter_map(|(block, mean)| Some((block, mean.as_ref()?)));
        pairs.map(|(block, mean)| if later { mean.count } else { block.mean.count }).sum()
    };
    if count(true) == 0 {
        return Ok(Err("no corrected flank was measured afterwards".to_owned()));
    }
    let missing = |k: usize| vec![f64::NAN; nodes.blocks[k].mean.deviation.len()];
    let deviation = |(k, mean): (usize, &Option<TeethMean>)| {
        mean.as_ref().map_or_else(|| missing(k), |mean| mean.deviation.clone())
    };
    let later = Later {
        measured: means.iter().enumerate().flat_map(deviation).collect(),
        scatter: nodes.scatter(&means),
        // a mean over fewer teeth has more noise
        noise: (0.5 * (1.0 + count(false) as f64 / count(true) as f64)).sqrt(),
    };
    let weight = spec.weight.clone();
    Ok(made.judge(spec, applied, later).map(|judged| {
        let Judged { answer, predicted, before, measured } = judged;
        let mut iterations: Vec<u32> = round.after.iter().map(|one| one.number).collect();
        iterations.sort_unstable();
        let last = iterations.last().copied().unwrap_or_default();
        let body = MachineAnswerBody::new(answer, last, &predicted, &measured);
        let (mut sided, mut start) = (SidedBody::default(), 0);
        for (number, block) in nodes.blocks.iter().enumerate() {
            let rows = start..start + block.mean.deviation.len();
            start = rows.end;
            let Some(flank) = &block.flank else { continue };
            let weight = weight.as_ref().map(|weight| &weight[rows.clone()]);
            let lists = [&before, &predicted, &measured].map(|list| &list[rows.clone()]);
            let later = || means[number].iter();
            let before = block.scatter(vec![&block.mean]);
            let after = block.scatter(later().collect());
            let both = block.scatter(std::iter::once(&block.mean).chain(later()).collect());
            let figures = |list: &[f64], measurements: Measurements| {
                let scatter = match measurements {
                    Measurements::Before => &before,
                    Measurements::After => &after,
                    Measurements::Both => &both,
                };
                flank.scattered_figures(list, weight, scatter)
            };
            let measured = round.after.iter().filter(|one| one.measurand.flank == block.side);
            let measured = measured.map(|one| &one.chosen).filter(|_| !block.chosen.is_empty());
            let [before, measured] = to_compare(flank, &block.chosen, measured);
            let changes = compare_figures(lists[0], lists[1], lists[2], figures);
            let changes = changes.map(|changes| changed_by_fits(changes, &before, &measured));
            match flank.side {
                Side::Left => sided.left = changes,
                Side::Right => sided.right = changes,
            }
        }
        let flanks = (sided != SidedBody::default()).then_some(sided);
        MachineAnswerBody { iterations: Some(iterations), flanks, ..body }
    }))
}
