//! Jobs are listed with their results, found by filters, and counted.

use std::{collections::BTreeMap, sync::Arc};

use flankfit::jobs::{
    Amendment, Choice, Decision, DecisionEvent, Event, FinishedStream, Job, JobFilter, JobGear, JobPatch, JobPlace,
    JobQuery, JobStatus, ListedJob, MOST_MACHINES, Measurand, MeasurementDetails, NewFit, NewIteration, NewRun,
    Precondition, Record, RecordKind, Repository, RepositoryError, Update, folded,
};
use flankfit_engine::gear::Side;
use jiff::{Timestamp, civil::date};
use uuid::Uuid;

use super::pair::Pair;
use crate::support::{Values, WHOLE, actor, all_jobs, intact};

/// The job of that id as it is listed.
async fn listed(store: &Arc<dyn Repository>, id: Uuid) -> ListedJob {
    let page = store.jobs(all_jobs()).await.unwrap();
    page.items.into_iter().find(|listed| listed.job.id == id).unwrap()
}

fn without_iterations(job: &Job) -> ListedJob {
    ListedJob {
        job: job.clone(),
        iteration_count: 0,
        changed_at: job.created_at,
        last_measured_at: None,
        flank: None,
        left: None,
        right: None,
        decision: None,
        rms: None,
        condition: None,
        figures: None,
        class: None,
    }
}

/// Decides on an iteration, and returns when.
async fn decided(store: &Arc<dyn Repository>, place: &Values, job: Uuid, number: u32, decision: Decision) -> Timestamp {
    let event = Event { reason: None, by: actor(), created_at: place.now() };
    let at = event.created_at;
    let decision = DecisionEvent { decision, concession: false, event };
    store.decide(job, number, decision, Precondition::None).await.unwrap();
    at
}

pub async fn a_job_is_listed_with_its_state(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await;
    let decide = async |number, decision| decided(&store, &place, job.id, number, decision).await;
    let expected = without_iterations(&job);
    assert_eq!(listed(&store, job.id).await, expected);

    let (first, _) = place.stored_iteration(&store, job.id).await;
    let expected = ListedJob {
        job: Job { status: JobStatus::Open, ..expected.job },
        iteration_count: 1,
        changed_at: first.created_at,
        last_measured_at: first.details.measured_at,
        flank: Some(Side::Right),
        right: Some(JobStatus::Open),
        rms: Some(1e-3),
        condition: Some(1e9),
        figures: first.fit.computed.flank.clone(),
        ..expected
    };
    let row = listed(&store, job.id).await;
    // the fit of the test is made a second after its iteration
    assert_eq!(ListedJob { changed_at: first.created_at, ..row }, expected);

    let at = decide(1, Decision::Remachine).await;
    let (status, decision) = (JobStatus::Remachine, Some(Decision::Remachine));
    let expected =
        ListedJob { job: Job { status, ..expected.job }, right: Some(status), decision, changed_at: at, ..expected };
    assert_eq!(listed(&store, job.id).await, expected);
    // the same again is no change
    decide(1, Decision::Remachine).await;
    assert_eq!(listed(&store, job.id).await, expected);

    // another fit counts from the time it is chosen
    let mut fit = place.fit(0.5);
    (fit.computed.figures.rms, fit.computed.figures.condition) = (Some(0.25), None);
    let fit = Arc::new(fit);
    store.insert_fit(job.id, 1, fit.clone(), None).await.unwrap();
    let expected = ListedJob { changed_at: fit.event.created_at, ..expected };
    assert_eq!(listed(&store, job.id).await, expected);
    let event = Event { reason: None, by: actor(), created_at: place.now() };
    let choice = Choice { fit_id: fit.id, event: event.clone() };
    store.choose(job.id, 1, choice, Precondition::None).await.unwrap();
    let expected = ListedJob {
        changed_at: event.created_at,
        rms: Some(0.25),
        condition: None,
        figures: fit.computed.flank.clone(),
        ..expected
    };
    assert_eq!(listed(&store, job.id).await, expected);

    // so do data of the job and records
    let (patch, now) = (JobPatch { name: Some("cog".to_owned()), ..JobPatch::default() }, place.now());
    let changed = store.patch_job(job.id, patch, Precondition::None, now).await.unwrap();
    let expected = ListedJob { job: changed, changed_at: now, ..expected };
    assert_eq!(listed(&store, job.id).await, expected);
    let record = place.stored_record(&store, job.id).await;
    let expected = ListedJob { changed_at: record.created_at, ..expected };
    assert_eq!(listed(&store, job.id).await, expected);

    // a new iteration of the same flank is not decided; times do not run back
    let second = place.iteration(job.id);
    let details = MeasurementDetails::default();
    let early: Timestamp = "2026-01-01T00:00:00Z".parse().unwrap();
    let second = NewIteration { details, created_at: early, ..NewIteration::clone(&second) };
    store.insert_iteration(Arc::new(second.clone()), None).await.unwrap();
    let at = decide(1, Decision::Rejected).await;
    let expected = ListedJob {
        job: Job { status: JobStatus::Open, ..expected.job },
        iteration_count: 2,
        changed_at: at,
        last_measured_at: Some(early),
        right: Some(JobStatus::Open),
        decision: None,
        rms: Some(1e-3),
        condition: Some(1e9),
        figures: second.fit.computed.flank.clone(),
        ..expected
    };
    assert_eq!(listed(&store, job.id).await, expected, "what is said of an earlier one does not count");
    for (said, status) in [(Decision::Rejected, JobStatus::Rejected), (Decision::Accepted, JobStatus::Accepted)] {
        decide(2, said).await;
        let row = listed(&store, job.id).await;
        assert_eq!((row.job.status, row.right, row.decision), (status, Some(status), Some(said)));
    }

    another_flank_counts_too(&store, &place, job.id).await;
}

/// The status of a job is the first in rank among those of its flanks.
async fn another_flank_counts_too(store: &Arc<dyn Repository>, place: &Values, job: Uuid) {
    let decide = async |number, decision| decided(store, place, job, number, decision).await;
    let third = place.iteration(job);
    let measurand = Measurand { flank: Some(Side::Left), ..Measurand::default() };
    let third = NewIteration { measurand, ..NewIteration::clone(&third) };
    store.insert_iteration(Arc::new(third), None).await.unwrap();
    let states = async || {
        let listed = listed(store, job).await;
        (listed.job.status, listed.left, listed.right)
    };
    assert_eq!(states().await, (JobStatus::Open, Some(JobStatus::Open), Some(JobStatus::Accepted)));
    assert_eq!(listed(store, job).await.flank, Some(Side::Left));
    decide(3, Decision::Accepted).await;
    assert_eq!(states().await, (JobStatus::Accepted, Some(JobStatus::Accepted), Some(JobStatus::Accepted)));
    decide(2, Decision::Remachine).await;
    assert_eq!(states().await, (JobStatus::Remachine, Some(JobStatus::Accepted), Some(JobStatus::Remachine)));
    decide(3, Decision::Rejected).await;
    assert_eq!(states().await, (JobStatus::Rejected, Some(JobStatus::Rejected), Some(JobStatus::Remachine)));
}

/// A changed measurand is appended to what was stored, and applies from then on.
pub async fn a_changed_measurand_counts_everywhere(pair: &mut Pair) {
    let (store, place, none) = (pair.store.clone(), pair.values.clone(), Precondition::None);
    let job = place.stored_job(&store).await;
    let of = |flank| Measurand { flank, tooth: Some("3".to_owned()), ..Measurand::default() };
    for flank in [Some(Side::Right), None] {
        let iteration = NewIteration { measurand: of(flank), ..NewIteration::clone(&place.iteration(job.id)) };
        store.insert_iteration(Arc::new(iteration), None).await.unwrap();
    }
    let event = || Event { reason: Some("by eye".to_owned()), by: actor(), created_at: place.now() };
    let decided = |decision| DecisionEvent { decision, concession: true, event: event() };
    store.decide(job.id, 1, decided(Decision::Accepted), none.clone()).await.unwrap();
    assert_eq!(listed(&store, job.id).await.job.status, JobStatus::Open, "iteration 2 is of a flank of its own");

    let amendment = |flank: &str, fit: Option<NewFit>, decision| {
        let document: Arc<str> =
            format!(r#"{{"flank":"{flank}","tooth":"3","axes":{{"z":{{}}}},"accept_units":true}}"#).into();
        let mut record = Record::clone(&place.record(RecordKind::Measurand, "changed"));
        (record.draft.measurand, record.draft.result) = (Some(document.clone()), document);
        let axes = Some(Arc::from(r#"{"z":{}}"#));
        let flank = if flank == "left" { Side::Left } else { Side::Right };
        let measurand = Measurand { axes, accept_units: true, ..of(Some(flank)) };
        Arc::new(Amendment { measurand, record, fit, decision })
    };
    let before = store.iteration(job.id, 2).await.unwrap();
    let fit = place.fit(0.5);
    let first = amendment("right", Some(fit.clone()), Some(decided(Decision::Remachine)));
    let stale = store.amend(job.id, 2, first.clone(), Precondition::AnyOf(vec![before.version + 1])).await;
    assert!(matches!(stale, Err(RepositoryError::VersionMismatch { .. })), "{stale:?}");
    let stored = store.amend(job.id, 2, first.clone(), Precondition::AnyOf(vec![before.version])).await.unwrap();
    assert_eq!(stored.version, before.version + 4, "the change, the fit, its choice and the decision");
    let after = store.iteration(job.id, 2).await.unwrap();
    assert_eq!((after.version, &after.measurand), (stored.version, &first.measurand));
    assert_eq!(after.fits.iter().map(|fit| fit.chosen).collect::<Vec<_>>(), [false, true]);
    assert_eq!(after.decision, first.decision);
    let row = listed(&store, job.id).await;
    assert_eq!(
        (row.job.status, row.flank, row.right),
        (JobStatus::Remachine, Some(Side::Right), Some(JobStatus::Remachine))
    );
    assert_eq!(row.figures, fit.computed.flank);
    assert_eq!(store.successors(job.id, 1).await.unwrap().alike, Some(2));
    assert_eq!(store.measurand(job.id, 2).await.unwrap(), first.measurand);
    let trace = store.trace(job.id, WHOLE).await.unwrap();
    assert_eq!(trace.iterations[1].measurand, first.measurand);
    assert_eq!(trace.iterations[1].records[0].measurand, first.record.draft.measurand);
    assert_eq!((&trace.iterations[1].decisions[0].concession, trace.iterations[0].decisions.len()), (&true, 1));

    // it was the left one after all: the right flank is as iteration 1 left it
    store.amend(job.id, 2, amendment("left", None, None), none.clone()).await.unwrap();
    let row = listed(&store, job.id).await;
    let (left, right) = (row.left, row.right);
    assert_eq!((left, right), (Some(JobStatus::Remachine), Some(JobStatus::Accepted)));
    intact(&pair.handles[0]).await;

    // a gear without that tooth is refused, and the other way round
    let gear = |teeth: u32| Update::Set(JobGear::from(format!(r#"{{"teeth":{teeth},"normal_module_mm":1.0}}"#)));
    let patch = |teeth| JobPatch { gear: gear(teeth), ..JobPatch::default() };
    store.patch_job(job.id, patch(4), none.clone(), place.now()).await.unwrap();
    let mut fifth = Amendment::clone(&amendment("left", None, None));
    fifth.measurand.tooth = Some("5".to_owned());
    let refused = store.amend(job.id, 2, Arc::new(fifth), none.clone()).await;
    assert!(matches!(refused, Err(RepositoryError::NoSuchTooth { teeth: 4, .. })), "{refused:?}");
    let refused = store.patch_job(job.id, patch(2), none, place.now()).await;
    assert!(matches!(refused, Err(RepositoryError::ToothMeasured { .. })), "{refused:?}");
}

/// Until another finds none.
pub async fn a_job_has_the_class_of_its_last_evaluation(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await;
    for _ in 0..2 {
        place.stored_iteration(&store, job.id).await;
    }
    for (number, class) in [(2, Some(7)), (1, Some(5)), (1, None), (2, Some(11))] {
        let mut record = Record::clone(&place.record(RecordKind::Evaluation, "iso_1328_1"));
        record.draft.class = class;
        store.insert_record(job.id, number, Arc::new(record.clone()), None).await.unwrap();
        let row = listed(&store, job.id).await;
        assert_eq!((row.class, row.changed_at), (class, record.created_at));
        assert_eq!(store.record(job.id, number, record.id).await.unwrap(), record);
    }
    // other records have none
    place.stored_record(&store, job.id).await;
    assert_eq!(listed(&store, job.id).await.class, Some(11));
}

pub async fn every_new_iteration_opens_its_job(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    let stream = Arc::new(place.stream(job));
    store.insert_stream(stream.clone(), None).await.unwrap();
    store.insert_block(place.block(stream.id, 1), None).await.unwrap();
    assert_eq!(listed(&store, job).await.job.status, JobStatus::New);
    let finished = FinishedStream { stream: stream.id, sequence: 1, iteration: place.iteration(job) };
    store.finish_stream(finished, None).await.unwrap();
    let row = listed(&store, job).await;
    assert_eq!((row.job.status, row.iteration_count), (JobStatus::Open, 1));

    let job = place.job("run");
    let iterations = (0..3).map(|_| place.iteration(job.id)).collect();
    store.insert_runs(vec![NewRun { job: job.clone(), iterations }], None, place.now()).await.unwrap();
    let row = listed(&store, job.id).await;
    assert_eq!((row.job.status, row.iteration_count), (JobStatus::Open, 3));
}

/// Name, machine and tags of a job.
type JobFacts<'a> = (&'a str, Option<&'a str>, &'a [(&'a str, &'a str)]);

/// Jobs of these, a second apart.
async fn jobs_of(pair: &Pair, of: &[JobFacts<'_>]) -> Vec<Job> {
    let mut jobs = Vec::new();
    for (name, machine, tags) in of {
        let tags: BTreeMap<_, _> = tags.iter().map(|(name, value)| (name.to_string(), value.to_string())).collect();
        let job = Job { machine: machine.map(str::to_owned), tags, part_number: None, ..pair.values.job(name) };
        pair.store.insert_job(job.clone(), None).await.unwrap();
        jobs.push(job);
    }
    jobs
}

/// Names of the jobs that are found, newest first.
async fn found(store: &Arc<dyn Repository>, filter: JobFilter) -> Vec<String> {
    let page = store.jobs(JobQuery { filter, ..all_jobs() }).await.unwrap();
    page.items.into_iter().map(|listed| listed.job.name).collect()
}

pub async fn jobs_are_found_by_each_filter(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let jobs = jobs_of(
        pair,
        &[
            ("Österreich 50%", Some("Wälz_1"), &[("shift", "Night"), ("a:b", "c")]),
            ("batch_7", Some("wälz_1"), &[("shift", "day")]),
            ("batch 7", None, &[("quo\"te", "ba\\ck"), ("empty", "")]),
            ("ΔΟΚΙΜΗ", Some("WälzX1"), &[]),
        ],
    )
    .await;
    let numbered = JobPatch {
        part_number: Update::Set("P%1".to_owned()),
        serial_number: Update::Set("Nr. 12".to_owned()),
        ..JobPatch::default()
    };
    store.patch_job(jobs[2].id, numbered, Precondition::None, place.now()).await.unwrap();
    let of = |text: &str| JobFilter { text: Some(folded(text)), ..JobFilter::default() };
    for (text, expected) in [
        ("ÖSTER", &["Österreich 50%"][..]),
        ("%", &["batch 7", "Österreich 50%"]),
        ("batch_", &["batch_7"]),
        ("BATCH", &["batch 7", "batch_7"]),
        ("wälz_1", &["batch_7", "Österreich 50%"]),
        ("wÄlzx", &["ΔΟΚΙΜΗ"]),
        ("δοκιμη", &["ΔΟΚΙΜΗ"]),
        ("nr. 12", &["batch 7"]),
        ("shift:n", &["Österreich 50%"]),
        ("QUO\"TE", &["batch 7"]),
        ("a\\c", &["batch 7"]),
        // no text reaches from one field into the next
        ("7w", &[]),
        ("'", &[]),
    ] {
        assert_eq!(found(&store, of(text)).await, expected, "{text}");
    }
    let none = JobFilter::default;
    let by = |tag: &str| JobFilter { tag: Some(tag.to_owned()), ..none() };
    for (filter, expected) in [
        (none(), &["ΔΟΚΙΜΗ", "batch 7", "batch_7", "Österreich 50%"][..]),
        (JobFilter { machine: Some("wälz_1".to_owned()), ..none() }, &["batch_7"]),
        (JobFilter { part_number: Some("P%1".to_owned()), ..none() }, &["batch 7"]),
        (JobFilter { part_number: Some("P".to_owned()), ..none() }, &[]),
        (by("shift"), &["batch_7", "Österreich 50%"]),
        (by("shift:Night"), &["Österreich 50%"]),
        (by("shift:night"), &[]),
        (by("a:b"), &["Österreich 50%"]),
        (by("a:b:c"), &["Österreich 50%"]),
        (by("a"), &[]),
        (by("empty:"), &["batch 7"]),
        (by("quo\"te:ba\\ck"), &["batch 7"]),
        (JobFilter { tag: Some("shift".to_owned()), ..of("7") }, &["batch_7"]),
    ] {
        assert_eq!(found(&store, filter.clone()).await, expected, "{filter:?}");
    }
    place.stored_iteration(&store, jobs[3].id).await;
    let with = |status| JobFilter { status: Some(status), ..none() };
    assert_eq!(found(&store, with(JobStatus::Open)).await, ["ΔΟΚΙΜΗ"]);
    assert_eq!(found(&store, with(JobStatus::New)).await, ["batch 7", "batch_7", "Österreich 50%"]);
    assert_eq!(found(&store, with(JobStatus::Accepted)).await, Vec::<String>::new());
    let mut record = Record::clone(&place.record(RecordKind::Evaluation, "iso_1328_1"));
    record.draft.class = Some(5);
    store.insert_record(jobs[3].id, 1, Arc::new(record), None).await.unwrap();
    let of_class = |class| JobFilter { class: Some(class), ..none() };
    assert_eq!(found(&store, of_class(5)).await, ["ΔΟΚΙΜΗ"]);
    assert_eq!(found(&store, of_class(6)).await, Vec::<String>::new());
    // from a time on, and before one
    let at = |k: usize| Some(jobs[k].created_at);
    assert_eq!(found(&store, JobFilter { from: at(1), ..none() }).await, ["ΔΟΚΙΜΗ", "batch 7", "batch_7"]);
    assert_eq!(found(&store, JobFilter { to: at(1), ..none() }).await, ["Österreich 50%"]);
    assert_eq!(found(&store, JobFilter { from: at(0), to: at(2), ..none() }).await, ["batch_7", "Österreich 50%"]);
    assert_eq!(found(&pair.seen_by("other"), none()).await, Vec::<String>::new());
}

/// In every order, while jobs come and while the one that the page ended with changes and goes.
pub async fn lists_of_jobs_neither_repeat_nor_skip(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let names = ["b", "A", "a", "c", "B", "a", "ä", "C", "d", "a b"].map(|name| (name, None, &[][..]));
    for start in [JobPlace::Changed(None), JobPlace::Name(None), JobPlace::Created(None)] {
        let jobs = jobs_of(pair, &names).await;
        let mut expected: Vec<&Job> = jobs.iter().rev().collect();
        if let JobPlace::Name(_) = start {
            expected.sort_by_key(|job| (folded(&job.name), job.id));
        }
        let expected: Vec<Uuid> = expected.iter().map(|job| job.id).collect();
        let mut query = JobQuery { limit: 3, from: start.clone(), ..JobQuery::default() };
        let mut seen = Vec::new();
        loop {
            let page = store.jobs(query.clone()).await.unwrap();
            seen.extend(page.items.iter().map(|listed| listed.job.id));
            let Some(next) = page.next else { break };
            // what is new has its place before the pages that come
            let another = place.job("0");
            store.insert_job(another, None).await.unwrap();
            let last = page.items.last().unwrap().job.id;
            match &start {
                JobPlace::Created(_) => store.delete_job(last, Precondition::None).await.unwrap(),
                _ => {
                    let patch = JobPatch { name: Some("0".to_owned()), ..JobPatch::default() };
                    store.patch_job(last, patch, Precondition::None, place.now()).await.unwrap();
                }
            }
            query.from = next;
        }
        assert_eq!(seen, expected, "{start:?}");
        for listed in store.jobs(all_jobs()).await.unwrap().items {
            store.delete_job(listed.job.id, Precondition::None).await.unwrap();
        }
    }
}

pub async fn a_full_last_page_has_no_next(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    for _ in 0..4 {
        place.stored_job(&store).await;
    }
    let page = store.jobs(JobQuery { limit: 4, ..all_jobs() }).await.unwrap();
    assert_eq!((page.items.len(), page.next), (4, None));
    let page = store.jobs(JobQuery { limit: 3, ..all_jobs() }).await.unwrap();
    assert_eq!(page.next, Some(JobPlace::Created(Some(page.items[2].job.id))));
}

pub async fn jobs_are_counted(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let since: Timestamp = "2026-11-22T00:00:00Z".parse().unwrap();
    assert_eq!(store.job_counts(since).await.unwrap(), Default::default());
    let machines = MOST_MACHINES as usize + 2;
    let mut k = 0;
    for machine in 0..machines {
        // the last but one has three jobs, the last two, all others one
        for _ in 0..(machine + 4).saturating_sub(machines).max(1) {
            let day = ["2026-11-21T23:59:59.999999Z", "2026-11-22T00:00:00Z", "2026-11-30T12:00:00Z"][k % 3];
            let at: Timestamp = day.parse().unwrap();
            let machine = Some(format!("M{machine:03}"));
            let job = Job { machine, created_at: at, updated_at: at, ..place.job("counted") };
            store.insert_job(job, None).await.unwrap();
            k += 1;
        }
    }
    let without = place.stored_job(&store).await.id;
    place.stored_iteration(&store, without).await;
    let theirs = pair.seen_by("other");
    place.stored_job(&theirs).await;
    let counts = store.job_counts(since).await.unwrap();
    let total = k as u64;
    let mut statuses = counts.statuses.clone();
    statuses.sort_by_key(|(status, _)| status.name());
    assert_eq!(statuses, [(JobStatus::New, total), (JobStatus::Open, 1)]);
    let last = |back: usize| format!("M{:03}", machines - back);
    let first = [(last(1), 3), (last(2), 2), ("M000".to_owned(), 1), ("M001".to_owned(), 1)];
    assert_eq!(counts.machines[..4], first);
    assert_eq!(counts.machines.len(), MOST_MACHINES as usize);
    assert_eq!((counts.machine_count, counts.with_machine), (machines as u64, total));
    let each = |day: usize| (0..k).filter(|job| job % 3 == day).count() as u64;
    assert_eq!(counts.days, [(date(2026, 11, 22), each(1)), (date(2026, 11, 30), each(2))]);
    let theirs = theirs.job_counts(since).await.unwrap();
    assert_eq!((theirs.statuses, theirs.machine_count), (vec![(JobStatus::New, 1)], 0));
}
