//! Gear jobs and their trace: which nodes were measured, which fits were made of them, which λ*
//! choice is current, and what was decided.
//!
//! A job collects iterations (measure, correct the machine, measure again). An iteration holds its
//! nodes for good and one or more fits; the chosen fit is that of the latest [`Choice`], and what
//! followed is the latest [`DecisionEvent`]. Choices and decisions are events: a change of mind is
//! a new one, so the trace has the whole story and nothing in it is ever overwritten.
//!
//! Jobs belong to tenants. What a [`Caller`] can do is [`Jobs`], which see those of one tenant;
//! what all of these share is the [`JobService`].
//!
//! This module knows neither SQL nor HTTP. Storage is the [`Repository`] of a caller, and the
//! ambient world (time, fresh ids) comes in through [`Clock`] and [`Ids`], so a test can hold all
//! three in its hand. Fits are computed before anything is written and come here [`Computed`]: no
//! write ever waits for a fit.

#[macro_use]
mod names;
mod ambient;
pub mod archive;
pub mod audit;
mod callers;
mod draft;
mod encoded_nodes;
mod encoded_text;
mod event;
mod fit;
mod follow;
pub mod frames;
mod gear;
mod idempotency;
mod iteration;
mod iterations;
mod job;
mod known_jobs;
mod listing;
mod mapping;
mod measurand;
pub mod nodes_codec;
mod origin;
mod outcome;
mod page;
mod purges;
mod record;
mod replay;
mod repository;
mod rounds;
pub mod rows;
mod runs;
mod said;
mod service;
mod streams;
mod summary;

pub use ambient::{Clock, Ids, OrderedIds, SystemClock};
pub use callers::{
    ApiKey, Caller, Credentials, KeyDraft, KeyId, KeyPatch, Keys, KnownKey, KnownKeys, NewKey, NewPlant, Owned, Plant,
    PlantDraft, PlantPatch, Role, Rotation, San, Scope, Scopes, Secret, Tenant, TenantKeys, actor, secret,
};
pub use draft::{AmendmentDraft, DecisionDraft, ExpectedGear, IterationDraft, JobDraft, RefitDraft, StreamDraft};
pub use encoded_nodes::EncodedNodes;
pub use encoded_text::{EncodedResult, EncodedText, Told};
pub use event::{EVENTS_TOLD, EventKind, EventPlace, JobChange, JobEvent, JobNotifier, StreamEvent, ToldEvent};
pub use fit::{Computed, Figures, FitRecord, NewFit};
pub use follow::Wake;
pub use gear::JobGear;
pub use idempotency::{ANSWERS_KEPT, Answer, KeyClaim, Keyed, KeyedRequest, Receipt, RunningKeys};
pub use iteration::{
    Amendment, Earlier, FitSummary, Iteration, ListedIteration, MAX_LISTED, NewIteration, NewRun, Predecessor,
    Predecessors, Trace, TracedFit, TracedIteration,
};
pub use job::{Job, JobPatch, Update};
pub use listing::{
    JobFilter, JobPage, JobPlace, JobPlaceError, JobQuery, JobSort, JobStatus, ListedJob, folded, searched_text,
};
pub use mapping::{KeptMapping, MOST_MAPPINGS};
pub use measurand::{Measurand, MeasurementDetails, Successors, has_no_tooth, side_name, side_named};
pub use origin::Origin;
pub use outcome::{Precondition, RepositoryError, RepositoryFuture, Resource, Stored, Unfit};
pub use page::{Cursor, CursorError, List, Page, PageRequest};
pub use purges::Purge;
pub use record::{Record, RecordDraft, RecordKind, RecordSummary};
pub use replay::{Difference, Replay};
pub use repository::{Repository, Store, Upkeep, Wakes};
pub use rounds::{MadeCorrection, MeasuredIteration, Rounds};
pub use said::{Choice, Decision, DecisionEvent, Event};
pub use service::{JobService, Jobs};
pub use streams::{
    Block, FinishedStream, NewBlock, NewStream, PostedBlock, Stream, StreamError, StreamHost, StreamState, is_state,
};
pub use summary::{JobCounts, JobSummary, MOST_MACHINES};
