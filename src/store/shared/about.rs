//! The change of each write, and the digests of its rows as far as known beforehand.

use uuid::Uuid;

use super::{
    operation::{
        Amend, CancelTask, Choose, Decide, DeleteJob, DeleteStream, FinishStream, InsertBlock, InsertFit,
        InsertIteration, InsertJob, InsertKey, InsertPlant, InsertRecord, InsertRuns, InsertStream, InsertTask,
        KeepMapping, PatchJob, PatchKey, PatchPlant, PurgeJob, RevokeKey, RotateKey,
    },
    row::purge_name,
    subject::{About, Subject},
};
use crate::jobs::{
    Amendment, Job, NewKey, NewRun, Plant,
    audit::{
        Contents, block_digest, choice_digest, decision_digest, job_digest, key_digest, new_iteration, plant_digest,
        purge_digest, record_digest, stream_digest,
    },
};

macro_rules! about {
    ($($Write:ident: $write:ident => $subject:expr $(, $contents:expr)?;)*) => {
        $(impl About for $Write {
            fn about(&self) -> Subject {
                let $write = self;
                $subject
            }

            $(fn contents(&self) -> Vec<Contents> {
                let $write = self;
                $contents
            })?
        })*
    };
}

about! {
    InsertJob: write => Subject::Job(write.job.id), vec![of_job(&write.job)];
    PatchJob: write => Subject::Job(write.id);
    DeleteJob: write => Subject::Job(write.id);
    InsertRuns: write => first(&write.runs).map_or(Subject::Nothing, Subject::Job), of_runs(&write.runs);
    InsertIteration: write => Subject::Job(write.iteration.job_id), vec![new_iteration(&write.iteration)];
    InsertFit: write => Subject::Job(write.job), vec![Contents::one("fit", write.fit.digest())];
    Choose: write => Subject::Job(write.job), vec![Contents::one("choice", choice_digest(&write.choice))];
    Decide: write => Subject::Job(write.job), vec![Contents::one("decision", decision_digest(&write.decision))];
    Amend: write => Subject::Job(write.job), vec![of_amendment(&write.amendment)];
    InsertRecord: write => Subject::Job(write.job), vec![Contents::one("record", record_digest(&write.record))];
    InsertStream: write => Subject::Job(write.stream.job_id), vec![of_stream(write)];
    InsertBlock: write => Subject::Stream(write.block.stream), vec![of_block(write)];
    FinishStream: write => Subject::Stream(write.finished.stream), vec![new_iteration(&write.finished.iteration)];
    DeleteStream: write => Subject::Stream(write.id);
    InsertTask: write => write.task.job.map_or(Subject::Nothing, Subject::Job);
    CancelTask: write => write.job.map_or(Subject::Nothing, Subject::Job);
    KeepMapping: _write => Subject::Nothing;
    InsertKey: write => no_job(write), vec![of_keys([&*write.key], None)];
    PatchKey: _write => Subject::Nothing;
    RotateKey: _write => Subject::Nothing;
    RevokeKey: _write => Subject::Nothing;
    InsertPlant: write => no_job(write), vec![of_keys([&write.plant.key], Some(&write.plant.plant))];
    PatchPlant: _write => Subject::Nothing;
}

impl About for PurgeJob {
    fn about(&self) -> Subject {
        Subject::Job(self.purge.job)
    }

    /// An entry of the job, and one of the tenant.
    fn contents(&self) -> Vec<Contents> {
        let purge = purge_digest(self.purge.job, &self.purge.purge);
        vec![Contents::default(), Contents::one(&purge_name(self.purge.job), purge)]
    }

    fn erases(&self) -> bool {
        true
    }
}

fn no_job<W>(_of: &W) -> Subject {
    Subject::Nothing
}

/// Of keys, each by its id since an entry may tell of two, and of a tenant.
pub fn of_keys<'a>(keys: impl IntoIterator<Item = &'a NewKey>, plant: Option<&Plant>) -> Contents {
    let keys = keys.into_iter().map(|new| (format!("key.{}", new.key.id), key_digest(new)));
    Contents::of(keys.chain(plant.map(|plant| ("tenant".to_owned(), plant_digest(plant)))).collect())
}

pub fn of_job(job: &Job) -> Contents {
    Contents::one("job", job_digest(job))
}

fn first(runs: &[NewRun]) -> Option<Uuid> {
    runs.first().map(|run| run.job.id)
}

/// Of each job an entry, and behind it those of its iterations.
fn of_runs(runs: &[NewRun]) -> Vec<Contents> {
    let of_run = |run: &NewRun| {
        let iterations: Vec<Contents> = run.iterations.iter().map(|iteration| new_iteration(iteration)).collect();
        [vec![of_job(&run.job)], iterations].concat()
    };
    runs.iter().flat_map(of_run).collect()
}

fn of_amendment(Amendment { record, fit, decision, .. }: &Amendment) -> Contents {
    let fit = fit.iter().flat_map(|fit| [("fit", fit.digest()), ("choice", choice_digest(&fit.choice()))]);
    let decision = decision.iter().map(|decision| ("decision", decision_digest(decision)));
    Contents::of([("record", record_digest(record))].into_iter().chain(fit).chain(decision).collect())
}

fn of_stream(InsertStream { stream, .. }: &InsertStream) -> Contents {
    let factor = stream.forgetting_factor;
    let digest = stream_digest(stream.id, &stream.spec, factor, &stream.measurand, stream.created_at);
    Contents::one("stream", digest)
}

fn of_block(InsertBlock { block, .. }: &InsertBlock) -> Contents {
    let digest = block_digest(block.sequence, &block.sha256, block.nodes.posted() as u64, block.nodes.bytes());
    Contents::one("block", digest)
}
