//! The digest of each kind of row. None has the row's number or position in it: where a row stands
//! is said by the entry. So all of them are known before a change waits for its turn.

use std::borrow::Cow;

use jiff::Timestamp;
use uuid::Uuid;

use super::{
    contents::Contents,
    layout::{Fields, Sha256Digest},
};
use crate::jobs::{
    callers::{NewKey, Plant, San},
    fit::{Computed, Figures, NewFit},
    iteration::NewIteration,
    job::Job,
    measurand::Measurand,
    measurement::MeasurementDetails,
    purge::Purge,
    record::Record,
    said::{Choice, DecisionEvent, Event},
};

fn of(id: Uuid) -> Fields {
    Fields::default().text(&id.to_string())
}

/// With what is behind them where there is something; rows from before that was kept have none.
fn also(fields: Fields, more: Option<&str>) -> Sha256Digest {
    more.into_iter().fold(fields, Fields::text).digest()
}

pub fn job_digest(job: &Job) -> Sha256Digest {
    let start = of(job.id)
        .text(&job.name)
        .maybe(job.part_number.as_deref())
        .maybe(job.serial_number.as_deref())
        .maybe(job.machine.as_deref())
        .maybe(job.gear.as_deref())
        .number(job.tags.len() as u64);
    let tagged = job.tags.iter().fold(start, |fields, (name, value)| fields.text(name).text(value));
    also(tagged.number(job.version).time(job.created_at).time(job.updated_at), job.requirements.as_deref())
}

fn measured(fields: Fields, measurand: &Measurand) -> Fields {
    fields.maybe(measurand.flank_name()).maybe(measurand.tooth.as_deref()).maybe(measurand.axes.as_deref())
}

pub fn iteration_digest(
    id: Uuid,
    measurand: &Measurand,
    details: &MeasurementDetails,
    created_at: Timestamp,
) -> Sha256Digest {
    let MeasurementDetails { measured_at, instrument, operator, note } = details;
    let fields = of(id)
        .maybe(measured_at.map(super::time_text).as_deref())
        .maybe(instrument.as_deref())
        .maybe(operator.as_deref())
        .maybe(note.as_deref());
    measured(fields, measurand).time(created_at).digest()
}

/// Digest of nodes by their stored bytes.
pub fn nodes_digest(count: u64, bytes: &[u8]) -> Sha256Digest {
    Fields::default().number(count).bytes(bytes).digest()
}

pub fn fit_digest(
    id: Uuid,
    event: &Event,
    figures: &Figures,
    spec: &str,
    result: &str,
    flank: Option<&str>,
) -> Sha256Digest {
    let fields = of(id)
        .maybe(event.reason.as_deref())
        .time(event.created_at)
        .real(figures.lambda_star)
        .maybe(figures.criterion)
        .maybe(figures.scheme)
        .maybe(figures.count.map(|count| count.to_string()).as_deref())
        .real(figures.condition)
        .real(figures.regularized_condition)
        .real(figures.bias_norm)
        .real(figures.bias_sharp_bound)
        .real(figures.rms)
        .real(figures.max_abs)
        .text(spec)
        .text(result);
    match flank {
        Some(flank) => fields.maybe(event.by.as_deref()).text(flank).digest(),
        None => also(fields, event.by.as_deref()),
    }
}

pub fn choice_digest(Choice { fit_id, event }: &Choice) -> Sha256Digest {
    also(of(*fit_id).maybe(event.reason.as_deref()).time(event.created_at), event.by.as_deref())
}

pub fn decision_digest(DecisionEvent { decision, concession, event }: &DecisionEvent) -> Sha256Digest {
    let fields = Fields::default().text(decision.name()).maybe(event.reason.as_deref()).time(event.created_at);
    match concession {
        true => fields.maybe(event.by.as_deref()).text("concession").digest(),
        false => also(fields, event.by.as_deref()),
    }
}

pub fn record_digest(Record { id, created_at, by, draft }: &Record) -> Sha256Digest {
    let fields = of(*id)
        .text(draft.kind.name())
        .text(&draft.method)
        .time(*created_at)
        .text(&draft.request)
        .text(&draft.result)
        .maybe(draft.gear.as_deref());
    match &draft.measurand {
        Some(measurand) => fields.maybe(by.as_deref()).text(measurand).digest(),
        None => also(fields, by.as_deref()),
    }
}

/// Digest of the remaining data of a stream.
pub fn stream_digest(
    id: Uuid,
    spec: &str,
    forgetting_factor: f64,
    measurand: &Measurand,
    created_at: Timestamp,
) -> Sha256Digest {
    measured(of(id).text(spec).real(Some(forgetting_factor)), measurand).time(created_at).digest()
}

/// Digest of a block: its number, the digest of its nodes as they were posted, and their stored
/// bytes.
pub fn block_digest(sequence: u64, sha256: &Sha256Digest, count: u64, bytes: &[u8]) -> Sha256Digest {
    Fields::default().number(sequence).bytes(sha256).number(count).bytes(bytes).digest()
}

/// Digest of a purge of a job.
pub fn purge_digest(job: Uuid, Purge { at, reason, archive_sha256 }: &Purge) -> Sha256Digest {
    of(job).time(*at).text(reason).bytes(archive_sha256).digest()
}

/// Of a key, with the digest of its secret: whoever exchanges that is found, and nobody comes from
/// here to 256 random bits. When it was used last is not in it.
pub fn key_digest(NewKey { key, sha256 }: &NewKey) -> Sha256Digest {
    let fields = Fields::default()
        .text(&key.id.to_string())
        .text(key.tenant.as_str())
        .text(&key.name)
        .maybe(key.role.map(|role| role.name()))
        .text(&key.scopes.to_string())
        .maybe(key.san.as_ref().map(San::as_str));
    let fields = match sha256 {
        Some(digest) => fields.bytes(digest),
        None => fields.maybe(None),
    };
    let ends = [key.expires_at, key.revoked_at].map(|time| time.map(super::time_text));
    let fields = fields.number(key.version).time(key.created_at);
    let fields = ends.iter().fold(fields, |fields, end| fields.maybe(end.as_deref()));
    also(fields, key.replaced_by.map(|by| by.to_string()).as_deref())
}

/// Digest of a tenant.
pub fn plant_digest(plant: &Plant) -> Sha256Digest {
    of(plant.id)
        .text(plant.name.as_str())
        .maybe(plant.description.as_deref())
        .text(if plant.suspended { "suspended" } else { "let in" })
        .number(plant.version)
        .time(plant.created_at)
        .time(plant.updated_at)
        .digest()
}

impl NewFit {
    /// Digest of the row.
    pub fn digest(&self) -> Sha256Digest {
        let Computed { spec, result, figures, flank } = &self.computed;
        fit_digest(self.id, &self.event, figures, spec, result, flank.as_deref())
    }
}

/// The rows of an iteration as it is added: with its nodes, its first fit, the choice of that, and
/// what is kept with it from the beginning.
pub fn new_iteration(iteration: &NewIteration) -> Contents {
    let NewIteration { id, measurand, details, created_at, nodes, fit, records, .. } = iteration;
    let first = fit.choice();
    let rows = [
        ("iteration", iteration_digest(*id, measurand, details, *created_at)),
        ("nodes", nodes_digest(nodes.posted() as u64, nodes.bytes())),
        ("fit", fit.digest()),
        ("choice", choice_digest(&first)),
    ];
    let rows = rows.map(|(name, digest)| (Cow::Borrowed(name), digest));
    // as many digits as the greatest has, so that their order is that of their names
    let width = records.len().to_string().len();
    let records =
        records.iter().zip(1..).map(|(record, k)| (format!("record.{k:0width$}").into(), record_digest(record)));
    Contents::of(rows.into_iter().chain(records).collect())
}
