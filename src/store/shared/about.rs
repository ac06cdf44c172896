//! What each write changes.

use super::{
    operation::{
        Choose, Decide, DeleteJob, DeleteStream, FinishStream, InsertBlock, InsertFit, InsertIteration, InsertJob,
        InsertRecord, InsertRuns, InsertStream, PatchJob,
    },
    subject::{About, Subject},
};

macro_rules! about {
    ($($Write:ident: $write:ident => $subject:expr;)*) => {
        $(impl About for $Write {
            fn about(&self) -> Subject {
                let $write = self;
                $subject
            }
        })*
    };
}

about! {
    InsertJob: write => Subject::Job(write.job.id);
    PatchJob: write => Subject::Job(write.id);
    DeleteJob: write => Subject::Job(write.id);
    InsertRuns: write => write.runs.first().map_or(Subject::Nothing, |run| Subject::Job(run.job.id));
    InsertIteration: write => Subject::Job(write.iteration.job_id);
    InsertFit: write => Subject::Job(write.job);
    Choose: write => Subject::Job(write.job);
    Decide: write => Subject::Job(write.job);
    InsertRecord: write => Subject::Job(write.job);
    InsertStream: write => Subject::Job(write.stream.job_id);
    InsertBlock: write => Subject::Stream(write.block.stream);
    FinishStream: write => Subject::Stream(write.finished.stream);
    DeleteStream: write => Subject::Stream(write.id);
}
