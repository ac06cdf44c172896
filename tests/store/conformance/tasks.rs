//! Tasks: who does them, and that nothing is stored for them twice.

use std::{sync::Arc, time::Duration};

use flankfit::jobs::{
    Answer, EndedTask, EventKind, Lease, MOST_KEPT, MOST_OPEN, NewRun, NewTask, PageRequest, Receipt, RecordKind,
    Repository, RepositoryError, Resource, Scope, Scopes, TaskAnswer, TaskResult, TaskState, Tasks,
};
use jiff::SignedDuration;
use uuid::Uuid;

use super::pair::Pair;
use crate::support::{Values, WHOLE, receipt};

const SCOPE: &str = "POST /there";
/// More than any test takes, and less than nothing.
const LONG: SignedDuration = SignedDuration::from_hours(1);
const OVER: SignedDuration = SignedDuration::from_secs(-1);
/// Room for every task of a test.
const ROOM: u64 = 1 << 20;

fn new_task(place: &Values, key: &str, job: Option<Uuid>) -> Arc<NewTask> {
    Arc::new(NewTask {
        id: place.id(),
        scope: Scope::Measure,
        scopes: Scopes::of(&[Scope::Read, Scope::Measure]),
        request: "/there?a=b".to_owned(),
        job,
        key: key.to_owned(),
        key_scope: SCOPE.to_owned(),
        request_sha256: [9; 32],
        headers: r#"[["content-type","application/json"]]"#.to_owned(),
        body: vec![0, 255, 40, 181],
        created_at: place.now(),
    })
}

fn answer(status: u16) -> TaskAnswer {
    TaskAnswer { status, headers: "[]".to_owned(), body: vec![1, 0, 2] }
}

fn ended(lease: Lease, job: Option<Uuid>, place: &Values) -> Arc<EndedTask> {
    Arc::new(EndedTask { lease, job, state: TaskState::Failed, answer: answer(422), most: ROOM, now: place.now() })
}

/// A receipt of a task's request.
fn under(lease: Lease, key: &str) -> Option<Receipt> {
    let mut receipt = receipt(key, SCOPE);
    receipt.request.lease = Some(lease);
    Some(receipt)
}

async fn claimed(tasks: &Arc<dyn Tasks>, place: &Values, lasting: SignedDuration) -> Option<Lease> {
    tasks.claim(place.id(), place.now(), lasting).await.unwrap().map(|task| task.lease)
}

async fn states(store: &Arc<dyn Repository>) -> Vec<TaskState> {
    let all = store.tasks(Scopes::ALL, WHOLE).await.unwrap().items;
    all.into_iter().rev().map(|task| task.state).collect()
}

pub async fn a_task_comes_back_and_is_done_under_a_lease(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let [one, two] = [pair.handles[0].tasks(), pair.handles[1].tasks()];
    assert_eq!(claimed(&one, &place, LONG).await, None);
    let new = new_task(&place, "k", None);
    let begun = store.insert_task(new.clone(), ROOM).await.unwrap();
    assert_eq!(
        (begun.id, begun.state, begun.attempts, begun.created_at),
        (new.id, TaskState::Queued, 0, new.created_at)
    );
    assert_eq!(store.task(new.id).await.unwrap(), begun);
    assert_eq!(store.task_of_key("k".into(), SCOPE.into()).await.unwrap(), Some((begun.clone(), [9; 32])));
    assert_eq!(store.task_of_key("k".into(), "POST /elsewhere".into()).await.unwrap(), None);
    assert_eq!(store.task_result(new.id).await.unwrap(), (begun, None));
    // it is taken by one, with all that its request was
    let lease = place.id();
    let taken = one.claim(lease, place.now(), LONG).await.unwrap().unwrap();
    assert_eq!((taken.lease, taken.attempts), (Lease { task: new.id, id: lease }, 1));
    assert_eq!(
        (&taken.headers, &taken.body, &taken.key, taken.scopes),
        (&new.headers, &new.body, &new.key, new.scopes)
    );
    assert_eq!(
        (taken.caller.tenant.as_str(), &*taken.caller.actor, &*taken.request),
        ("default", "test", "/there?a=b")
    );
    assert_eq!(claimed(&two, &place, LONG).await, None);
    // who has it says how far it is
    let at = place.now();
    let other = Lease { id: place.id(), ..taken.lease };
    assert_eq!(one.renew(vec![(taken.lease, 0.25), (other, 0.5)], at, LONG).await.unwrap(), [taken.lease]);
    let told = store.task(new.id).await.unwrap();
    assert_eq!((told.state, told.progress, told.told_at, told.attempts), (TaskState::Running, 0.25, Some(at), 1));
    // it is given back, as if it had not been taken, and taken again after a while
    one.give_back(other, at, true).await.unwrap();
    one.give_back(taken.lease, place.now() - LONG, false).await.unwrap();
    assert_eq!((store.task(new.id).await.unwrap().attempts, states(&store).await), (0, vec![TaskState::Queued]));
    let lease = claimed(&two, &place, LONG).await.unwrap();
    two.give_back(lease, "2200-01-01T00:00:00Z".parse().unwrap(), true).await.unwrap();
    assert_eq!((store.task(new.id).await.unwrap().attempts, claimed(&one, &place, LONG).await), (1, None));
    pair.ground.intrude("UPDATE operations SET lease_until = NULL".into()).await;
    let lease = claimed(&one, &place, LONG).await.unwrap();
    // its end is written down once
    assert!(!two.end(ended(other, None, &place)).await.unwrap());
    let end = ended(lease, None, &place);
    assert!(two.end(end.clone()).await.unwrap() && !one.end(end.clone()).await.unwrap());
    let (task, result) = store.task_result(new.id).await.unwrap();
    assert_eq!((task.state, task.status, task.ended_at), (TaskState::Failed, Some(422), Some(end.now)));
    assert_eq!(result, Some(TaskResult::Own(answer(422))));
    assert_eq!(one.renew(vec![(lease, 0.5)], place.now(), LONG).await.unwrap(), []);
    // and forgotten by its age
    assert_eq!(one.forget_tasks(end.now, 10).await.unwrap(), 0);
    assert_eq!(two.forget_tasks(place.now(), 10).await.unwrap(), 1);
    assert!(matches!(store.task(new.id).await, Err(RepositoryError::NotFound(Resource::Task))));
}

/// What is stored and the end of the task are one transaction; of two who do the task one stores.
pub async fn a_late_owner_stores_nothing(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let [one, two] = [pair.handles[0].tasks(), pair.handles[1].tasks()];
    let job = place.stored_job(&store).await.id;
    place.stored_iteration(&store, job).await;
    let new = new_task(&place, "k", Some(job));
    store.insert_task(new.clone(), ROOM).await.unwrap();
    let late = claimed(&one, &place, OVER).await.unwrap();
    let own = claimed(&two, &place, LONG).await.unwrap();
    assert_eq!((late.task, store.task(new.id).await.unwrap().attempts), (own.task, 2));
    let events = store.last_event(job).await.unwrap();
    // by every way in which something is stored
    let lost = |outcome: Result<_, RepositoryError>| assert!(matches!(outcome, Err(RepositoryError::LeaseLost)));
    lost(store.insert_iteration(place.iteration(job), under(late, "k")).await);
    lost(store.insert_fit(job, 1, Arc::new(place.fit(0.5)), under(late, "k")).await);
    lost(store.insert_record(job, 1, place.record(RecordKind::Curve, "newton"), under(late, "k")).await);
    let runs = vec![NewRun { job: place.job("run"), iterations: Vec::new() }];
    lost(store.insert_runs(runs, under(late, "k"), place.now()).await);
    assert!(!one.end(ended(late, Some(job), &place)).await.unwrap());
    assert_eq!(one.renew(vec![(late, 0.9)], place.now(), LONG).await.unwrap(), []);
    assert_eq!(store.last_event(job).await.unwrap(), events);
    // both at once, in one transaction or in two
    let (first, second) = tokio::join!(
        store.insert_iteration(place.iteration(job), under(late, "k")),
        store.insert_iteration(place.iteration(job), under(own, "k"))
    );
    assert_eq!(second.unwrap().number, 2);
    lost(first);
    // it has ended with what was stored
    let (task, result) = store.task_result(new.id).await.unwrap();
    assert_eq!((task.state, task.status), (TaskState::Succeeded, Some(201)));
    let kept = Answer {
        status: 201,
        location: Some("/there".to_owned()),
        etag: Some("\"1\"".to_owned()),
        body: br#"{"number":2}"#.to_vec(),
    };
    assert_eq!(result, Some(TaskResult::Kept(kept)));
    lost(store.insert_iteration(place.iteration(job), under(own, "k")).await);
    lost(store.insert_fit(job, 1, Arc::new(place.fit(0.5)), under(own, "other")).await);
    assert!(!two.end(ended(own, Some(job), &place)).await.unwrap());
    assert_eq!(claimed(&one, &place, LONG).await, None);
    // which is an event of the job, as its beginning was
    let told: Vec<EventKind> = store.events(job, 0, 100).await.unwrap().into_iter().map(|event| event.kind).collect();
    let of = |state| EventKind::Task { id: new.id, state };
    assert_eq!(told.iter().filter(|kind| **kind == of(TaskState::Queued)).count(), 1);
    assert_eq!(told.iter().filter(|kind| **kind == of(TaskState::Succeeded)).count(), 1);
    assert_eq!(told.len(), 4, "{told:?}");
    let numbers: Vec<u64> = store.events(job, 0, 100).await.unwrap().iter().map(|event| event.number).collect();
    assert_eq!(numbers, [1, 2, 3, 4]);
}

/// What a record, a fit or runs store ends their task as well.
pub async fn whatever_is_stored_ends_its_task(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let tasks = pair.handles[1].tasks();
    let job = place.stored_job(&store).await.id;
    place.stored_iteration(&store, job).await;
    for (k, key) in ["fit", "record", "runs"].into_iter().enumerate() {
        store.insert_task(new_task(&place, key, None), ROOM).await.unwrap();
        let lease = claimed(&tasks, &place, LONG).await.unwrap();
        let receipt = under(lease, key);
        let stored = match key {
            "fit" => store.insert_fit(job, 1, Arc::new(place.fit(0.5)), receipt).await,
            "record" => store.insert_record(job, 1, place.record(RecordKind::Curve, "newton"), receipt).await,
            _ => store.insert_runs(Vec::new(), receipt, place.now()).await,
        };
        stored.unwrap();
        assert_eq!(states(&store).await, vec![TaskState::Succeeded; k + 1], "{key}");
    }
}

pub async fn a_cancelled_task_stores_nothing(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let tasks = pair.handles[0].tasks();
    let job = place.stored_job(&store).await.id;
    let [waiting, running] = ["w", "r"].map(|key| new_task(&place, key, Some(job)));
    store.insert_task(running.clone(), ROOM).await.unwrap();
    let lease = claimed(&tasks, &place, LONG).await.unwrap();
    store.insert_task(waiting.clone(), ROOM).await.unwrap();
    for task in [&running, &waiting] {
        store.cancel_task(task.id, Some(job), place.now()).await.unwrap();
    }
    assert_eq!(states(&store).await, [TaskState::Cancelled; 2]);
    assert_eq!(tasks.renew(vec![(lease, 0.5)], place.now(), LONG).await.unwrap(), []);
    let refused = store.insert_iteration(place.iteration(job), under(lease, "r")).await;
    assert!(matches!(refused, Err(RepositoryError::LeaseLost)), "{refused:?}");
    assert!(!tasks.end(ended(lease, Some(job), &place)).await.unwrap());
    assert_eq!((claimed(&tasks, &place, LONG).await, store.task_result(running.id).await.unwrap().1), (None, None));
    assert_eq!(store.last_event(job).await.unwrap(), 4, "two were begun and two cancelled");
    // the keys are free again
    assert_eq!(store.task_of_key("r".to_owned(), SCOPE.to_owned()).await.unwrap(), None);
    // and what has ended goes away
    store.cancel_task(running.id, Some(job), place.now()).await.unwrap();
    assert!(matches!(store.task(running.id).await, Err(RepositoryError::NotFound(Resource::Task))));
    let gone = store.cancel_task(running.id, Some(job), place.now()).await;
    assert!(matches!(gone, Err(RepositoryError::NotFound(Resource::Task))));
    store.insert_task(new_task(&place, "r", None), ROOM).await.unwrap();
    // a job without iterations may go, whatever is still to be done with it
    store.insert_task(new_task(&place, "of it", Some(job)), ROOM).await.unwrap();
    store.delete_job(job, Default::default()).await.unwrap();
    for _ in 0..2 {
        let lease = claimed(&tasks, &place, LONG).await.unwrap();
        assert!(tasks.end(ended(lease, Some(job), &place)).await.unwrap());
    }
}

/// A cancelled task gives its key away for one that no client has.
pub async fn a_task_is_cancelled_whatever_keys_there_are(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let task = new_task(&place, "k", None);
    store.insert_task(task.clone(), ROOM).await.unwrap();
    for id in [task.id.to_string(), task.id.simple().to_string(), task.id.simple().to_string().to_uppercase()] {
        store.insert_task(new_task(&place, &format!("cancelled-{id}"), None), ROOM).await.unwrap();
    }
    store.cancel_task(task.id, None, place.now()).await.unwrap();
    assert_eq!(store.task(task.id).await.unwrap().state, TaskState::Cancelled);
}

/// Bytes of requests and results are counted, keys are used once, and other tenants have their own.
pub async fn tasks_of_a_tenant_are_bounded_and_its_own(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let other = pair.seen_by("other");
    let tasks = pair.handles[1].tasks();
    let first = new_task(&place, "1", None);
    let each = first.bytes() as u64;
    store.insert_task(first.clone(), each).await.unwrap();
    let full = store.insert_task(new_task(&place, "2", None), 2 * each - 1).await;
    assert!(matches!(full, Err(RepositoryError::TasksFull { held }) if held == each), "{full:?}");
    store.insert_task(new_task(&place, "2", None), 2 * each).await.unwrap();
    let taken = store.insert_task(new_task(&place, "1", None), ROOM).await;
    assert!(matches!(taken, Err(RepositoryError::KeyTaken)), "{taken:?}");
    other.insert_task(new_task(&place, "1", None), each).await.unwrap();
    for refused in [other.task(first.id).await.map(drop), other.task_result(first.id).await.map(drop)] {
        assert!(matches!(refused, Err(RepositoryError::NotFound(Resource::Task))));
    }
    let refused = other.cancel_task(first.id, None, place.now()).await;
    assert!(matches!(refused, Err(RepositoryError::NotFound(Resource::Task))));
    // pages, and whose requests one may make
    let page = |after| PageRequest { limit: 1, after };
    let newest = store.tasks(Scopes::ALL, page(None)).await.unwrap();
    let oldest = store.tasks(Scopes::ALL, page(newest.next)).await.unwrap();
    assert_eq!((newest.items.len(), oldest.items[0].id, oldest.next), (1, first.id, None));
    assert!(store.tasks(Scopes::of(&[Scope::Read, Scope::Compute]), WHOLE).await.unwrap().items.is_empty());
    // the tenant of whom less is done comes first, though it came last
    let mut order = Vec::new();
    for _ in 0..3 {
        order.push(tasks.claim(place.id(), place.now(), LONG).await.unwrap().unwrap().caller.tenant);
    }
    let order: Vec<&str> = order.iter().map(|tenant| tenant.as_str()).collect();
    assert_eq!(order, ["default", "other", "default"]);
}

/// An answer for which there is no room is not kept; a short one is said instead.
pub async fn an_answer_without_room_is_not_kept(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let tasks = pair.handles[1].tasks();
    let [first, second] = ["1", "2"].map(|key| new_task(&place, key, None));
    for task in [&first, &second] {
        store.insert_task(task.clone(), ROOM).await.unwrap();
    }
    let lease = claimed(&tasks, &place, LONG).await.unwrap();
    tasks.renew(vec![(lease, 0.75)], place.now(), LONG).await.unwrap();
    let end = EndedTask::clone(&ended(lease, None, &place));
    let takes = (second.bytes() + end.answer.bytes()) as u64;
    let refused = tasks.end(Arc::new(EndedTask { most: takes - 1, ..end.clone() })).await;
    let waiting = second.bytes() as u64;
    assert!(matches!(refused, Err(RepositoryError::TasksFull { held }) if held == waiting), "{refused:?}");
    assert_eq!(states(&store).await, [TaskState::Running, TaskState::Queued]);
    assert!(tasks.end(Arc::new(EndedTask { most: takes, ..end })).await.unwrap());
    // it did not come to its end
    assert_eq!(store.task(first.id).await.unwrap().progress, 0.75);
    // of its request no more is kept than which it was
    let held = pair.ground.scalar("SELECT CAST(sum(bytes) AS bigint) FROM operations WHERE state = 'failed'").await;
    assert_eq!(held as usize, first.request.len() + answer(422).bytes());
    store.cancel_task(second.id, None, place.now()).await.unwrap();
    let held = pair.ground.scalar("SELECT CAST(sum(bytes) AS bigint) FROM operations WHERE state = 'cancelled'").await;
    assert_eq!(held as usize, second.request.len());
    let left = pair.ground.scalar("SELECT count(*) FROM operations WHERE headers <> '[]' OR length(body) > 0").await;
    assert_eq!(left, 0);
}

/// Whoever looks for the next task passes all that wait.
pub async fn a_tenant_has_so_many_tasks_and_no_more(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let task = new_task(&place, "1", None);
    store.insert_task(task.clone(), ROOM).await.unwrap();
    let copies = |state: &str, from: u64, to: u64| {
        let (id, ended) = (pair.ground.id(task.id), if state == "queued" { "NULL" } else { "created_at" });
        format!(
            "INSERT INTO operations (id, tenant, actor, scope, scopes, request, key, key_scope, request_sha256, headers,
                                     body, state, attempts, progress, bytes, created_at, ended_at)
             WITH RECURSIVE n (n) AS (SELECT {from} UNION ALL SELECT n + 1 FROM n WHERE n < {to})
             SELECT {}, o.tenant, o.actor, o.scope, o.scopes, o.request, 'copy ' || n, o.key_scope, o.request_sha256,
                    o.headers, o.body, '{state}', 0, 0, 1, o.created_at, {ended} FROM operations o, n WHERE o.id = {id}",
            pair.ground.numbered_id("n")
        )
    };
    pair.ground.intrude(copies("queued", 1, MOST_OPEN - 1)).await;
    let refused = store.insert_task(new_task(&place, "2", None), ROOM).await;
    let many = matches!(refused, Err(RepositoryError::TooManyTasks { open: MOST_OPEN, kept: MOST_OPEN }));
    assert!(many, "{refused:?}");
    // others are none of it, and come first
    let other = new_task(&place, "1", None);
    pair.seen_by("other").insert_task(other.clone(), ROOM).await.unwrap();
    let tasks = pair.handles[0].tasks();
    let order = [claimed(&tasks, &place, LONG).await.unwrap(), claimed(&tasks, &place, LONG).await.unwrap()];
    assert_eq!(order[1].task, other.id);
    // what has ended counts as long as it is kept
    let all_end = "UPDATE operations SET state = 'failed', ended_at = created_at WHERE tenant = 'default'";
    pair.ground.intrude(all_end.to_owned()).await;
    store.insert_task(new_task(&place, "2", None), ROOM).await.unwrap();
    pair.ground.intrude(copies("failed", MOST_OPEN, MOST_KEPT - 2)).await;
    let refused = store.insert_task(new_task(&place, "3", None), ROOM).await;
    let full = matches!(refused, Err(RepositoryError::TooManyTasks { open: 1, kept: MOST_KEPT }));
    assert!(full, "{refused:?}");
}

/// Several processes take tasks at once, and each task is taken by one.
pub async fn a_task_is_taken_by_one(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    for k in 0..40 {
        store.insert_task(new_task(&place, &k.to_string(), None), ROOM).await.unwrap();
    }
    let takers = (0..8).map(|k| {
        let (tasks, place) = (pair.handles[k % 2].tasks(), place.clone());
        tokio::spawn(async move {
            let (mut taken, mut misses) = (Vec::new(), 0);
            // a task that another is about to take is passed over
            while misses < 5 {
                match claimed(&tasks, &place, LONG).await {
                    Some(lease) => taken.push(lease.task),
                    None => {
                        misses += 1;
                        tokio::time::sleep(Duration::from_millis(5)).await;
                    }
                }
            }
            taken
        })
    });
    let mut all = Vec::new();
    for taker in takers.collect::<Vec<_>>() {
        all.extend(taker.await.unwrap());
    }
    all.sort_unstable();
    let count = all.len();
    all.dedup();
    assert_eq!((all.len(), count), (40, 40));
}
