//! A store in a directory of its own, and values to put into it.

use std::{
    collections::BTreeMap,
    ops::Deref,
    path::PathBuf,
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
};

use flankfit::{
    jobs::{
        Answer, Caller, Clock, Computed, Event, Figures, Ids, Job, JobFilter, JobPlace, JobQuery, JobStatus,
        KeyedRequest, Measurand, MeasurementDetails, NewBlock, NewFit, NewIteration, NewStream, OrderedIds,
        PageRequest, Purge, Receipt, Record, RecordDraft, RecordKind, Repository, Store, Stored, Tenant,
        archive::{Key, export},
        audit::{Evidence, Seal, Sealing, Verdict, examine},
    },
    store::{SqlStore, StoreSettings, open_sqlite},
};
use flankfit_engine::{estimation::Nodes, gear::Side};
use jiff::{SignedDuration, Timestamp};
use sqlx::{ConnectOptions, SqliteConnection, sqlite::SqliteConnectOptions};
use uuid::Uuid;

/// More than any test stores.
pub const WHOLE: PageRequest = PageRequest { limit: 1000, after: None };

/// All jobs, newest first.
pub fn all_jobs() -> JobQuery {
    JobQuery { filter: JobFilter::default(), limit: WHOLE.limit, from: JobPlace::Created(None) }
}

/// Fresh ids.
pub fn ids() -> Arc<OrderedIds> {
    Arc::default()
}

/// A clock that does not advance.
pub fn still(at: Timestamp) -> Arc<Still> {
    Arc::new(Still(at))
}

pub struct Still(Timestamp);

impl Clock for Still {
    fn now(&self) -> Timestamp {
        self.0
    }
}

/// A caller of a tenant.
pub fn caller(tenant: &str) -> Caller {
    Caller { tenant: Tenant::named(tenant).unwrap(), actor: "test".into(), origin: Default::default() }
}

/// Actor of what the tests store.
pub fn actor() -> Option<Arc<str>> {
    Some("key-0123456789abcdef".into())
}

/// An open store as a caller of the default tenant sees it.
pub struct Opened {
    pub store: Arc<dyn Store>,
    pub repository: Arc<dyn Repository>,
}

impl Opened {
    fn of(store: SqlStore) -> Self {
        let repository = store.of(&caller("default"));
        Opened { store: Arc::new(store), repository }
    }

    pub async fn close(&self) {
        self.store.close().await;
    }
}

impl Deref for Opened {
    type Target = dyn Repository;

    fn deref(&self) -> &Self::Target {
        &*self.repository
    }
}

/// A directory of its own for a database, and values to put into it.
pub struct Place {
    directory: tempfile::TempDir,
    values: Values,
}

impl Place {
    pub fn new() -> Self {
        Place { directory: tempfile::tempdir().unwrap(), values: Values::default() }
    }

    pub fn file(&self) -> PathBuf {
        self.directory.path().join("jobs.db")
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    pub async fn open(&self) -> Opened {
        self.open_with(StoreSettings::of_file(self.file())).await
    }

    pub async fn open_with(&self, settings: StoreSettings) -> Opened {
        Opened::of(open_sqlite(settings, still(self.now())).await.unwrap())
    }

    /// A connection of the test's own, with no more rights than any program has.
    pub async fn connect(&self) -> SqliteConnection {
        SqliteConnectOptions::new().filename(self.file()).foreign_keys(true).connect().await.unwrap()
    }
}

impl Deref for Place {
    type Target = Values;

    fn deref(&self) -> &Values {
        &self.values
    }
}

/// Fresh ids, a clock that moves, and what is made with them.
#[derive(Default)]
pub struct Values {
    ids: OrderedIds,
    ticks: AtomicU64,
}

impl Values {
    /// Time moves one second with every look.
    pub fn now(&self) -> Timestamp {
        let seconds = self.ticks.fetch_add(1, Ordering::Relaxed);
        let start: Timestamp = "2026-11-21T08:00:00.000001Z".parse().unwrap();
        start + SignedDuration::from_secs(i64::try_from(seconds).unwrap())
    }

    pub fn id(&self) -> Uuid {
        self.ids.fresh(self.now())
    }

    pub fn job(&self, name: &str) -> Job {
        let now = self.now();
        Job {
            id: self.ids.fresh(now),
            name: name.to_owned(),
            part_number: Some("P-1".to_owned()),
            serial_number: None,
            machine: None,
            gear: Some(r#"{"teeth":52,"normal_module_mm":1.0}"#.to_owned().into()),
            requirements: Some(r#"{"tolerance_limits":{"class":6}}"#.into()),
            tags: BTreeMap::from([("shift".to_owned(), "night".to_owned())]),
            status: JobStatus::New,
            version: 1,
            created_at: now,
            updated_at: now,
            purged_at: None,
        }
    }

    pub async fn stored_job(&self, store: &impl Deref<Target = dyn Repository>) -> Job {
        let job = self.job("wheel");
        store.insert_job(job.clone(), None).await.unwrap();
        job
    }

    pub fn fit(&self, lambda_star: f64) -> NewFit {
        let result = format!(
            r#"{{"coefficients":[{{"term":"1","value":{lambda_star}}}],"warnings":[],"provenance":{{"engine":"test 1"}}}}"#
        );
        NewFit {
            id: self.id(),
            computed: Computed {
                spec: Arc::from(r#"{"model":{"type":"polynomial","degree":1}}"#),
                result: result.into(),
                figures: Figures {
                    lambda_star: Some(lambda_star),
                    criterion: Some("min_mse"),
                    scheme: Some("first_order"),
                    count: Some(2),
                    condition: Some(1e9),
                    regularized_condition: None,
                    bias_norm: Some(0.5),
                    bias_sharp_bound: Some(0.75),
                    rms: Some(1e-3),
                    max_abs: Some(2e-3),
                },
                flank: Some(format!(r#"{{"warnings":[],"twist_um":{lambda_star}}}"#).into()),
            },
            event: Event { reason: None, by: actor(), created_at: self.now() },
        }
    }

    pub fn record(&self, kind: RecordKind, method: &str) -> Arc<Record> {
        let draft = RecordDraft {
            kind,
            method: method.to_owned(),
            request: Arc::from(format!(r#"{{"method":{{"type":"{method}"}}}}"#)),
            result: Arc::from(r#"{"domain":[0,1]}"#),
            gear: None,
            class: None,
            measurand: None,
        };
        Arc::new(Record { id: self.id(), created_at: self.now(), by: actor(), draft })
    }

    /// A curve of the job's first iteration.
    pub async fn stored_record(&self, store: &impl Deref<Target = dyn Repository>, job: Uuid) -> Arc<Record> {
        let record = self.record(RecordKind::Curve, "lagrange");
        store.insert_record(job, 1, record.clone(), None).await.unwrap();
        record
    }

    pub fn iteration(&self, job: Uuid) -> Arc<NewIteration> {
        Arc::new(NewIteration {
            id: self.id(),
            job_id: job,
            measurand: Measurand {
                flank: Some(Side::Right),
                tooth: Some("3".to_owned()),
                axes: Some(Arc::from(r#"{"u":{"quantity":"face_width","unit":"mm"}}"#)),
                accept_units: false,
            },
            details: MeasurementDetails {
                measured_at: Some("2026-11-20T23:00:00Z".parse().unwrap()),
                instrument: Some("CMM".to_owned()),
                operator: Some("Ida".to_owned()),
                note: Some("first; cut".to_owned()),
            },
            created_at: self.now(),
            nodes: Arc::new(nodes()).into(),
            fit: self.fit(1e-4),
            records: Vec::new(),
            expected_gear: None,
        })
    }

    pub fn stream(&self, job: Uuid) -> NewStream {
        NewStream {
            id: self.id(),
            job_id: job,
            spec: Arc::from(r#"{"model":{"type":"polynomial","degree":1}}"#),
            forgetting_factor: 1.0,
            input_sha256: [1; 32],
            measurand: Measurand { flank: Some(Side::Left), ..Measurand::default() },
            created_at: self.now(),
        }
    }

    /// Block `sequence` of a stream, with a state.
    pub fn block(&self, stream: Uuid, sequence: u64) -> Arc<NewBlock> {
        Arc::new(NewBlock {
            stream,
            sequence,
            sha256: [sequence as u8; 32],
            previous_sha256: if sequence == 1 { [1; 32] } else { [99 + sequence as u8; 32] },
            input_sha256: [100 + sequence as u8; 32],
            nodes: Arc::new(nodes()).into(),
            state: Some(state(sequence)),
            created_at: self.now(),
        })
    }

    pub async fn stored_iteration(
        &self,
        store: &impl Deref<Target = dyn Repository>,
        job: Uuid,
    ) -> (Arc<NewIteration>, Stored) {
        let iteration = self.iteration(job);
        let stored = store.insert_iteration(iteration.clone(), None).await.unwrap();
        (iteration, stored)
    }
}

/// A keyed request whose response names what was stored.
pub fn receipt(key: &str, scope: &str) -> Receipt {
    Receipt {
        request: KeyedRequest { key: key.to_owned(), scope: scope.to_owned(), request_sha256: [7; 32], claim: None },
        answer: Box::new(|stored| Answer {
            status: 201,
            location: Some("/there".to_owned()),
            etag: Some(format!("\"{}\"", stored.version)),
            body: format!("{{\"number\":{}}}", stored.number).into_bytes(),
        }),
    }
}

/// The archive of a job as it is now, without its first and last line.
pub async fn archived(store: &Arc<dyn Store>, tenant: &str, job: Uuid) -> String {
    let key = Key { tenant: Tenant::named(tenant).unwrap(), job };
    let mut text = String::new();
    let write = |line: String| {
        text += &line;
        std::future::ready(Ok(()))
    };
    assert!(export(&*store.holdings(), &key, write).await.unwrap());
    text
}

pub fn purge_of(place: &Values, job: Uuid) -> Arc<Purge> {
    Arc::new(Purge { job, at: place.now(), reason: "old".to_owned() })
}

/// Seals all entries; the seals.
pub async fn sealed(store: &Arc<dyn Store>, at: Timestamp) -> Vec<Seal> {
    let sealed = store.seal_audit(Sealing { at, key: None }).await.unwrap().unwrap();
    assert_eq!((sealed.more, sealed.failed), (false, Vec::new()));
    sealed.seals
}

/// Verdict on everything in a store.
pub async fn verified(store: &Arc<dyn Store>) -> Verdict {
    examine(&*store.auditor(), None, None, &Evidence::default(), &|_| {}).await.unwrap()
}

/// The same, which is nothing.
pub async fn intact(store: &Arc<dyn Store>) -> Verdict {
    let verdict = verified(store).await;
    assert!(verdict.differences.is_empty(), "{:#?}", verdict.differences);
    verdict
}

/// The state of an estimate, with one number.
pub fn state(number: u64) -> Vec<u8> {
    [b"FFS1".as_slice(), &1_u64.to_le_bytes(), &(number as f64).to_le_bytes(), b"null"].concat()
}

/// A small grid with a missing node.
pub fn nodes() -> Nodes {
    let z = vec![0.1, 0.2, f64::NAN, 0.4, 0.5, 0.6];
    Nodes::grid(vec![1.0, 2.0, 3.0], vec![-1.0, 1.0], z, None, None).unwrap()
}
