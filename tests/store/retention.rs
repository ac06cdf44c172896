//! Jobs that nobody has touched for long are archived and then purged, on both stores: on
//! PostgreSQL by a server that is no more than a member of `flankfit_app`, and by one of several at
//! a time.

use std::{
    fs::{self, File},
    path::PathBuf,
    sync::{Arc, Mutex},
    time::Duration,
};

use flankfit::{
    app::Retention,
    config::RetentionSettings,
    jobs::{
        Clock, Job, JobDraft, JobService, NewIteration, OrderedIds, RepositoryError, Store, archive,
        audit::{Chain, Verdict},
    },
    store::{Migrate, PostgresSettings, StoreSettings, open_postgres, open_sqlite},
};
use jiff::{SignedDuration, Timestamp};
use sha2::{Digest as _, Sha256};
use sqlx::{Connection as _, Executor as _, PgConnection};

use crate::{
    service::served,
    support::{Values, archived, caller},
};

/// A clock that is put forward.
struct Put(Mutex<Timestamp>);

impl Put {
    fn forward(&self, days: i64) {
        self.forward_by(SignedDuration::from_hours(24 * days));
    }

    fn forward_by(&self, time: SignedDuration) {
        *self.0.lock().unwrap() += time;
    }
}

impl Clock for Put {
    fn now(&self) -> Timestamp {
        *self.0.lock().unwrap()
    }
}

/// A server with a folder for archives.
struct Plant {
    place: tempfile::TempDir,
    clock: Arc<Put>,
    service: Arc<JobService>,
    store: Arc<dyn Store>,
    values: Values,
}

impl Plant {
    async fn on_sqlite() -> Self {
        let place = tempfile::tempdir().unwrap();
        let (ids, clock) = (Arc::new(OrderedIds::new()), Plant::clock());
        let settings = StoreSettings::of_file(place.path().join("jobs.db"));
        let store = Arc::new(open_sqlite(settings, ids.clone(), clock.clone()).await.unwrap());
        Plant::of(place, store, ids, clock)
    }

    async fn on_postgres() -> Self {
        let [_, url] = served().await;
        Plant::at(&url).await
    }

    /// One of several on a database with the schema.
    async fn at(url: &str) -> Self {
        let (ids, clock) = (Arc::new(OrderedIds::new()), Plant::clock());
        let mut settings = PostgresSettings::of_url(url).unwrap();
        (settings.writers, settings.readers, settings.unsafe_store) = (1, 2, true);
        settings.migrate = Migrate::Check;
        let store = Arc::new(open_postgres(settings, ids.clone(), clock.clone()).await.unwrap());
        Plant::of(tempfile::tempdir().unwrap(), store, ids, clock)
    }

    fn clock() -> Arc<Put> {
        Arc::new(Put(Mutex::new("2026-11-21T08:00:00Z".parse().unwrap())))
    }

    fn of(place: tempfile::TempDir, store: Arc<dyn Store>, ids: Arc<OrderedIds>, clock: Arc<Put>) -> Self {
        let service = JobService::new(store.clone(), clock.clone(), ids);
        Plant { place, clock, service, store, values: Values::default() }
    }

    fn retention(&self, days: u32) -> Retention {
        let folder = self.place.path().join("archives");
        std::fs::create_dir_all(&folder).unwrap();
        let settings =
            RetentionSettings { retain_bulk_days: Some(days.try_into().unwrap()), archive_dir: Some(folder) };
        Retention::of(&settings).unwrap().unwrap()
    }

    async fn job(&self) -> Arc<Job> {
        let draft = JobDraft { name: "wheel".to_owned(), ..JobDraft::default() };
        self.service.of(&caller("default")).create_job(draft, None).await.unwrap()
    }

    /// A job with an iteration, which somebody has measured.
    async fn measured(&self) -> Arc<Job> {
        let job = self.job().await;
        let mut iteration = NewIteration::clone(&self.values.iteration(job.id));
        iteration.created_at = self.clock.now();
        iteration.fit.event.created_at = self.clock.now();
        assert!(iteration.details.operator.is_some());
        self.store.of(&caller("default")).insert_iteration(Arc::new(iteration), None).await.unwrap();
        job
    }

    async fn is_purged(&self, job: &Job) -> bool {
        self.service.of(&caller("default")).job(job.id).await.unwrap().purged_at.is_some()
    }

    /// Files of the folder of the tenant.
    fn files(&self) -> Vec<PathBuf> {
        let folder = self.place.path().join("archives/default");
        let mut all: Vec<_> = fs::read_dir(folder).into_iter().flatten().map(|file| file.unwrap().path()).collect();
        all.sort();
        all
    }
}

/// Makes a test of each case on each store.
macro_rules! on_both {
    ($($case:ident),+) => {
        mod sqlite {
            use super::Plant;

            $(
                #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
                async fn $case() {
                    super::$case(Plant::on_sqlite().await).await;
                }
            )+
        }

        mod postgres {
            use super::Plant;

            $(
                #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
                #[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
                async fn $case() {
                    super::$case(Plant::on_postgres().await).await;
                }
            )+
        }
    };
}

on_both! {
    what_nobody_touches_is_archived_and_then_purged,
    without_a_file_that_reads_as_it_was_written_nothing_is_purged,
    jobs_that_cannot_be_purged_keep_no_other_from_it,
    what_cannot_be_purged_is_tried_less_and_less_often
}

async fn what_nobody_touches_is_archived_and_then_purged(plant: Plant) {
    let retention = plant.retention(30);
    let old = plant.measured().await;
    plant.clock.forward(20);
    let young = plant.measured().await;
    assert_eq!(retention.turn(&plant.service).await.unwrap(), 0);
    plant.clock.forward(11);
    assert_eq!(retention.turn(&plant.service).await.unwrap(), 1);
    assert!(plant.is_purged(&old).await && !plant.is_purged(&young).await);
    // names and nodes are gone, and the chain says so
    let repository = plant.store.of(&caller("default"));
    assert_eq!(repository.iteration(old.id, 1).await.unwrap().details.operator, None);
    assert!(matches!(repository.nodes(old.id, 1).await, Err(RepositoryError::Purged { .. })));
    assert!(repository.iteration(young.id, 1).await.unwrap().details.operator.is_some());
    assert!(repository.nodes(young.id, 1).await.is_ok());
    let verdict = repository.verify_audit(Chain::Job(old.id)).await.unwrap();
    assert!(matches!(verdict, Verdict::Intact { entries: 3, .. }), "{verdict:?}");
    // the archive is there under its digest, and is the job's
    let [file] = &plant.files()[..] else { panic!("{:?}", plant.files()) };
    let name = file.file_name().unwrap().to_str().unwrap();
    let digest: String = Sha256::digest(fs::read(file).unwrap()).iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(name, format!("{}-{digest}.jsonl.zst", old.id));
    let listed = archive::listed(File::open(file).unwrap(), |_| Ok(())).unwrap();
    assert_eq!((listed.len(), listed[0].0.job), (1, old.id));
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        assert_eq!(file.metadata().unwrap().permissions().mode() & 0o777, 0o600);
    }
    // once
    assert_eq!(retention.turn(&plant.service).await.unwrap(), 0);
    assert_eq!(plant.files().len(), 1);
    plant.clock.forward(20);
    assert_eq!(retention.turn(&plant.service).await.unwrap(), 1);
    assert_eq!(plant.files().len(), 2);
    plant.store.close().await;
}

async fn without_a_file_that_reads_as_it_was_written_nothing_is_purged(plant: Plant) {
    let retention = plant.retention(1);
    let job = plant.measured().await;
    plant.clock.forward(2);
    // a file stands where the folder of the tenant would
    let folder = plant.place.path().join("archives/default");
    fs::write(&folder, "").unwrap();
    assert_eq!(retention.turn(&plant.service).await.unwrap(), 0);
    assert!(!plant.is_purged(&job).await);
    fs::remove_file(&folder).unwrap();
    plant.clock.forward(1);
    // a disk that takes everything and keeps nothing
    fs::create_dir(&folder).unwrap();
    let partial = folder.join(format!("{}.partial", job.id));
    std::os::unix::fs::symlink("/dev/null", &partial).unwrap();
    assert_eq!(retention.turn(&plant.service).await.unwrap(), 0);
    assert!(!plant.is_purged(&job).await);
    assert_eq!(plant.files(), std::slice::from_ref(&partial), "nothing has the name of an archive");
    fs::remove_file(partial).unwrap();
    plant.clock.forward(1);
    assert_eq!(retention.turn(&plant.service).await.unwrap(), 1);
    assert!(plant.is_purged(&job).await);
    plant.store.close().await;
}

async fn jobs_that_cannot_be_purged_keep_no_other_from_it(plant: Plant) {
    let retention = plant.retention(1);
    let folder = plant.place.path().join("archives/default");
    fs::create_dir(&folder).unwrap();
    for _ in 0..Retention::AT_A_TIME {
        let job = plant.job().await;
        // a disk that takes everything and keeps nothing
        std::os::unix::fs::symlink("/dev/null", folder.join(format!("{}.partial", job.id))).unwrap();
    }
    plant.clock.forward(1);
    let last = plant.job().await;
    plant.clock.forward(2);
    assert_eq!(retention.turn(&plant.service).await.unwrap(), 0);
    assert_eq!(retention.turn(&plant.service).await.unwrap(), 1);
    assert!(plant.is_purged(&last).await);
    plant.store.close().await;
}

/// Each try archives the whole job.
async fn what_cannot_be_purged_is_tried_less_and_less_often(plant: Plant) {
    let retention = plant.retention(1);
    let job = plant.measured().await;
    let (_, told) = archived(&plant.store, "default", job.id).await;
    let digest: String = told.sha256.iter().map(|byte| format!("{byte:02x}")).collect();
    // a folder has the archive's name, so that whoever tries leaves what he wrote
    let folder = plant.place.path().join("archives/default");
    fs::create_dir_all(folder.join(format!("{}-{digest}.jsonl.zst", job.id))).unwrap();
    let partial = folder.join(format!("{}.partial", job.id));
    let is_tried = async || {
        assert_eq!(retention.turn(&plant.service).await.unwrap(), 0);
        fs::remove_file(&partial).is_ok()
    };
    plant.clock.forward(2);
    assert!(is_tried().await);
    for minutes in [1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 1440, 1440] {
        plant.clock.forward_by(SignedDuration::from_secs(60 * minutes - 1));
        assert!(!is_tried().await, "within {minutes} minutes");
        plant.clock.forward_by(SignedDuration::from_secs(1));
        assert!(is_tried().await, "after {minutes} minutes");
    }
    plant.store.close().await;
}

/// Both find the same job due; one purges it, and the other does not even archive it meanwhile.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn of_two_turns_at_once_one_purges() {
    let [owners, services] = served().await;
    let (one, two) = (Plant::at(&services).await, Plant::at(&services).await);
    let job = one.measured().await;
    for plant in [&one, &two] {
        plant.clock.forward(2);
    }
    // the first comes as far as the row of the job, which is held here
    let mut holder = PgConnection::connect(&owners).await.unwrap();
    holder.execute("BEGIN; SELECT FROM jobs FOR UPDATE").await.unwrap();
    let first = tokio::spawn({
        let (retention, service) = (one.retention(1), one.service.clone());
        async move { retention.turn(&service).await }
    });
    let mut looking = PgConnection::connect(&owners).await.unwrap();
    let waits = "SELECT EXISTS (SELECT FROM pg_stat_activity
                                WHERE datname = current_database() AND wait_event_type = 'Lock')";
    while !sqlx::query_scalar::<_, bool>(waits).fetch_one(&mut looking).await.unwrap() {
        assert!(!first.is_finished(), "the first turn has ended");
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    assert_eq!(two.retention(1).turn(&two.service).await.unwrap(), 0);
    assert_eq!(two.files(), Vec::<PathBuf>::new());
    holder.execute("ROLLBACK").await.unwrap();
    assert_eq!(first.await.unwrap().unwrap(), 1);
    assert!(two.is_purged(&job).await);
    assert_eq!((one.files().len(), two.files().len()), (1, 0));
    one.store.close().await;
    two.store.close().await;
}

/// Whoever has it may be killed, or cut off.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn a_turn_ends_with_its_connection() {
    let [owners, services] = served().await;
    let (one, two) = (Plant::at(&services).await, Plant::at(&services).await);
    let job = one.measured().await;
    for plant in [&one, &two] {
        plant.clock.forward(2);
    }
    let turn = one.store.turn().await.unwrap().expect("nobody has it");
    assert_eq!(two.retention(1).turn(&two.service).await.unwrap(), 0);
    assert!(!two.is_purged(&job).await);
    let mut owner = PgConnection::connect(&owners).await.unwrap();
    let end = "SELECT pg_terminate_backend(pid, 60000) FROM pg_locks JOIN pg_database d ON d.oid = database
               WHERE locktype = 'advisory' AND granted AND d.datname = current_database()";
    let ended: Vec<bool> = sqlx::query_scalar(end).fetch_all(&mut owner).await.unwrap();
    assert_eq!(ended, [true], "one connection has it, and ends");
    assert_eq!(two.retention(1).turn(&two.service).await.unwrap(), 1);
    assert!(two.is_purged(&job).await);
    drop(turn);
    one.store.close().await;
    two.store.close().await;
}
