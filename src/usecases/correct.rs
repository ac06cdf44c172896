//! Corrections of an iteration and of a gear: what they are computed from, and how they are read
//! with the measurement that followed.

use super::prelude::*;
use super::{
    entered::entered_after,
    rounds::{Iterations, measured, measured_of, newest, tooth_shift},
};
use crate::{
    api::{
        gears::{
            correction::{
                self,
                blocks::Subject,
                csv,
                include::CorrectionInclude,
                round::{self, MadeFor, Round},
                same_nodes::Measured,
                sensitivity::Level,
                stored::{self, After},
            },
            gear::of_job,
            requirements::RequirementsBody,
        },
        jobs::records::{self, Shown},
        problem::{ProblemCode, Room},
    },
    jobs::{Job, RecordDraft, Rounds, Successors},
};

/// The form of a correction that is read.
#[derive(Clone, Copy)]
pub enum Form {
    Json(CorrectionInclude),
    /// For the control of the machine; refused where predicted figures lie outside their limits,
    /// unless that is allowed.
    Csv {
        outside_limits: bool,
    },
}

/// Measurements that a correction is computed from.
pub struct Basis {
    job: Job,
    kind: RecordKind,
    measured: Iterations,
    /// The newest iteration of the other flank.
    other: Option<WithPermit<Measured>>,
}

/// Reads what a correction by an iteration is computed from.
pub async fn basis_of_iteration(context: Context<'_>, job: Uuid, number: u32) -> Result<Basis, Problem> {
    let own = measured(context, job, number).await?;
    let rounds = context.jobs.rounds(job).await?;
    let other = match rounds.newest_of_other_flank(&own.measurand).map(|one| one.number) {
        Some(newest) => Some(measured(context, job, newest).await?),
        None => None,
    };
    Ok(Basis { job: context.jobs.job(job).await?, kind: RecordKind::Correction, measured: vec![own], other })
}

/// Reads what a correction of the gear is computed from, with the last of its iterations.
pub async fn basis_of_gear(context: Context<'_>, job: Uuid) -> Result<(u32, Basis), Problem> {
    let own = context.jobs.job(job).await?;
    let rounds = context.jobs.rounds(job).await?;
    let numbers: Vec<u32> = rounds.current().iter().map(|one| one.number).collect();
    let Some(last) = numbers.iter().copied().max() else { return Err(nothing_measured(&rounds)) };
    let measured = measured_of(context, job, &numbers).await?;
    Ok((last, Basis { job: own, kind: RecordKind::GearCorrection, measured, other: None }))
}

impl Basis {
    /// Computes the correction that a request asks for: its record, and the parts of it that are
    /// returned. Processor work.
    pub fn correct(&self, text: &[u8], room: Room) -> Result<(RecordDraft, Shown), Problem> {
        let level = match self.kind {
            RecordKind::GearCorrection => {
                room(aligned(&self.measured))?;
                Level::Gear
            }
            _ => Level::Iteration,
        };
        let gear = of_job(&self.job)?;
        let required = RequirementsBody::of(&self.job);
        let subject = Subject {
            level,
            measured: list(&self.measured),
            other: self.other.as_deref(),
            gear: gear.as_ref(),
            requirements: required.as_ref(),
        };
        let (built, include, result) = correction::build(text, &subject)?;
        let draft = records::of_gear(&self.job, self.kind, text, built)?;
        let request = include.of_request(&draft.request).map_err(|syntax| Problem::internal(syntax.what))?;
        let result = String::from_utf8_lossy(&result).into();
        Ok((draft, Shown { request, result }))
    }
}

/// Returns the newest correction of an iteration, with what the next iteration of the flank
/// measured.
pub async fn of_iteration(context: Context<'_>, job: Uuid, number: u32, form: Form) -> Result<Vec<u8>, Problem> {
    let Some(record) = context.jobs.latest_record(job, number, RecordKind::Correction).await? else {
        return Err(Problem::new(ProblemCode::NotFound, "The iteration has no correction."));
    };
    let own = context.jobs.job(job).await?;
    let include = match form {
        Form::Json(include) => include,
        Form::Csv { outside_limits } => {
            let flanks = context.jobs.measurand(job, number).await?.words();
            let about =
                move || csv::write(&record, &csv::About { job: &own, flanks, iterations: &[number] }, outside_limits);
            return context.pool.run(about).await?;
        }
    };
    let (before, _before) = measured(context, job, number).await?.into_parts();
    let successors = context.jobs.successors(job, number).await?;
    let applied = entered_after(context, job, &record, number, successors.alike.as_slice()).await?;
    let shift = tooth_shift(context, job, &[number], successors.alike.as_slice()).await?;
    let (after, _after) = match successors {
        Successors { alike: Some(next), .. } => {
            let (after, permit) = measured(context, job, next).await?.into_parts();
            (After::Same(Box::new(after)), Some(permit))
        }
        Successors { any: Some(next), .. } => (After::Others(next), None),
        Successors { .. } => (After::Nothing, None),
    };
    let today = of_job(&own)?;
    let write = move || stored::write(&record, applied, &before, &after, shift, today.as_ref(), include);
    context.pool.run(write).await?
}

/// Returns the newest correction of the gear, with what the next round measured.
pub async fn of_gear(context: Context<'_>, job: Uuid, form: Form) -> Result<Vec<u8>, Problem> {
    let own = context.jobs.job(job).await?;
    let rounds = context.jobs.rounds(job).await?;
    let Some((made, record)) = newest(context, job, &rounds).await? else {
        return Err(Problem::new(ProblemCode::NotFound, "The job has no correction of the gear."));
    };
    let MadeFor { flanks, iterations } = MadeFor::of(&record)?;
    let include = match form {
        Form::Json(include) => include,
        Form::Csv { outside_limits } => {
            let about =
                move || csv::write(&record, &csv::About { job: &own, flanks, iterations: &iterations }, outside_limits);
            return context.pool.run(about).await?;
        }
    };
    let later: Vec<u32> = rounds.after(made).iter().map(|one| one.number).collect();
    let applied = entered_after(context, job, &record, made.number, &later).await?;
    let before = if later.is_empty() { Vec::new() } else { measured_of(context, job, &iterations).await? };
    let after = measured_of(context, job, &later).await?;
    let shift = tooth_shift(context, job, &iterations, &later).await?;
    let today = of_job(&own)?;
    let _aligned = context.budget.take(aligned(&before) + aligned(&after))?;
    let write = move || {
        let round = Round { before: list(&before), after: list(&after) };
        round::write(&record, applied, &round, shift, today.as_ref(), include)
    };
    context.pool.run(write).await?
}

fn nothing_measured(rounds: &Rounds) -> Problem {
    let detail = match rounds.iterations.len() {
        0 => "the job has no iteration: measure a flank before correcting the gear",
        _ => "no iteration since the last correction has a flank: send `flank` by `PATCH` of the iteration",
    };
    Problem::invalid(Faults::one("", detail))
}

/// Returns the bytes that a mean over teeth takes: deviations and residuals of each tooth at the
/// nodes of the one with most of them.
fn aligned(iterations: &Iterations) -> usize {
    let most = iterations.iter().map(|one| one.nodes.posted()).max().unwrap_or(0);
    2 * size_of::<f64>() * most * iterations.len()
}

fn list(iterations: &Iterations) -> Vec<&Measured> {
    iterations.iter().map(|one| &**one).collect()
}
