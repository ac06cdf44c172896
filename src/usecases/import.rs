//! A file of a gear tester, evaluated, fitted and stored as an iteration.

use bytes::Bytes;

use super::iterate::store;
use super::prelude::*;
use crate::{
    api::{
        jobs::import,
        tables::{kept::SentMapping, mapping::MappingBody},
    },
    jobs::{ExpectedGear, Keyed, NewIteration, Stored},
};

/// A file with its description.
pub struct FileForm {
    pub file: Bytes,
    /// Name given by the caller.
    pub name: Option<String>,
    /// JSON.
    pub spec: Option<Bytes>,
    /// How a table is to be read.
    pub mapping: Option<MappingBody>,
}

/// Stores the file that `read` returns as the next iteration of the job.
pub async fn add(
    context: Context<'_>,
    job: Uuid,
    read: impl FnOnce() -> Result<WithPermit<FileForm>, Problem> + Send + 'static,
    keyed: Option<Keyed<NewIteration>>,
) -> Result<(Arc<NewIteration>, Stored), Problem> {
    let own = context.jobs.job(job).await?;
    let plans = context.plans.clone();
    let work = move || {
        let form = read()?;
        let FileForm { file, name, spec, mapping } = &*form;
        let mut draft = import::draft(file, name.as_deref(), spec.as_deref(), mapping.as_ref(), &own, &plans)?;
        let sent = mapping.as_ref().and_then(|mapping| SentMapping::of(file, mapping));
        let mapping = sent.map(|sent| sent.kept(draft.details.instrument.as_deref()));
        draft.records.iter_mut().for_each(|record| record.gear = own.gear.as_deref().map(Into::into));
        draft.expected_gear = Some(ExpectedGear(own.gear));
        Ok::<_, Problem>((draft, mapping))
    };
    let (draft, mapping) = context.pool.run(work).await??;
    store(context, job, draft, mapping, keyed, "/file").await
}
