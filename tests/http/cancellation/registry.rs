//! One list of all operations that take a POST: a new one fails the test until it is entered here,
//! with the dearest request that its limits allow or the reason why there is none.

use std::{
    collections::BTreeSet,
    io::{ErrorKind, Read, Write},
    net::TcpStream,
    time::{Duration, Instant},
};

use serde_json::{Value, json};

use super::dear::{self, Body};
use crate::jobs::kill::Server;

/// Time for which a worker may continue after its client has left. On a quiet machine it is some
/// milliseconds; a busy one may delay the worker, the server or this test.
const REST: Duration = Duration::from_secs(10);

/// Time within which one of some tries must end; work that does not notice the departure of its
/// client takes longer.
const SOON: Duration = Duration::from_secs(2);

/// Moments at which the client leaves, after the work was seen running: at once (often while the
/// request is still read), and in the midst of it.
const MOMENTS: [Duration; 2] = [Duration::ZERO, Duration::from_millis(150)];

/// Number of attempts of a client to leave before its response, at half the moment each time.
const TRIES: usize = 20;

enum Entry {
    /// Runs for longer than the later moment.
    Dear(&'static str, fn() -> Body),
    /// Has a limit below it: the client leaves at once.
    Bounded(&'static str, fn() -> Body),
    /// Computes nothing of weight, for this reason.
    Trivial(&'static str),
}

use Entry::{Bounded, Dear, Trivial};

const ENTRIES: &[(&str, Entry)] = &[
    ("create_fit", Dear("/v1/fits", dear::lp)),
    ("study_randomization", Dear("/v1/studies/randomization", dear::study)),
    ("create_curve", Dear("/v1/curves", dear::adaptive_curve)),
    ("evaluate_curve", Dear("/v1/curves/evaluate", dear::arc_lengths)),
    ("closest_points_of_curve", Dear("/v1/curves/closest-points", dear::closest_on_curve)),
    ("export_curve", Bounded("/v1/curves/export", dear::curve_file)),
    ("create_surface", Dear("/v1/surfaces", dear::big_surface)),
    ("evaluate_surface", Dear("/v1/surfaces/evaluate", dear::surface_values)),
    ("closest_points_of_surface", Dear("/v1/surfaces/closest-points", dear::closest_on_surface)),
    ("sections_of_surface", Dear("/v1/surfaces/sections", dear::sections_of_surface)),
    ("export_surface", Bounded("/v1/surfaces/export", dear::surface_file)),
    ("create_job", Trivial("texts of bounded lengths")),
    ("create_iteration", Dear("{job}/iterations", dear::lp)),
    ("create_iteration_fit", Dear("{job}/iterations/1/fits", dear::lp_refit)),
    ("preview_iteration_fit", Dear("{job}/iterations/1/preview", dear::lp_refit)),
    ("replay_fit", Bounded("{job}/iterations/1/fits/{dear_fit}/replay", dear::nothing)),
    ("gear_geometry", Trivial("closed forms of one gear")),
    ("gear_tolerances", Trivial("a table and closed forms")),
    ("gear_pitch", Trivial("sums over at most 10,000 teeth")),
    ("gear_flank", Bounded("/v1/gears/flank", dear::flank)),
    ("read_gears", Bounded("/v1/gears/read", dear::rexs_model)),
    ("read_nodes", Bounded("/v1/nodes/read", dear::points_file)),
    ("gear_profile", Bounded("/v1/gears/profile", dear::profile)),
    ("gear_solid_mesh", Bounded("/v1/gears/solid-mesh", dear::solid_mesh)),
    ("gear_envelope", Bounded("/v1/gears/envelope", dear::envelope)),
    ("evaluate_gear", Bounded("/v1/gears/evaluate", dear::traces)),
    ("gear_deviations", Dear("/v1/gears/deviations", dear::registered_points)),
    ("gear_flank_surface", Dear("/v1/gears/flank-surface", dear::robust_flank)),
    ("create_iteration_deviations", Dear("{job}/iterations/1/deviations", dear::registered_points)),
    ("create_iteration_evaluation", Bounded("{job}/iterations/1/evaluations", dear::traces)),
    ("create_iteration_pitch", Trivial("sums over at most 10,000 teeth")),
    ("create_iteration_correction", Dear("{job}/iterations/1/correction", dear::correction)),
    ("create_applied_changes", Trivial("names of settings")),
    ("create_gear_correction", Dear("{flank_job}/correction", dear::correction)),
    ("create_gear_applied_changes", Trivial("names of settings")),
    ("import_iteration", Bounded("{job}/import", dear::points_file)),
    ("create_iteration_curve", Dear("{curve_job}/iterations/1/curves", dear::curve_of_nodes)),
    ("create_iteration_surface", Dear("{job}/iterations/1/surfaces", dear::surface_of_nodes)),
    ("simulate_closed_loop", Dear("/v1/simulations/closed-loop", dear::closed_loop)),
    ("create_stream", Trivial("a spec without nodes")),
    ("add_stream_nodes", Dear("{stream}/nodes", dear::block)),
    ("purge_job", Trivial("one transaction")),
    ("create_key", Trivial("texts of bounded lengths")),
    ("rotate_key", Trivial("a number")),
    ("create_tenant", Trivial("texts of bounded lengths")),
    ("finish_stream", Bounded("{full_stream}/finish", dear::nothing)),
];

/// Metrics of the process about its work.
pub struct Metrics {
    pub busy: u64,
    pub cancelled: u64,
}

impl Metrics {
    pub fn of(address: &str) -> Self {
        let mut stream = TcpStream::connect(address).unwrap();
        stream.write_all(b"GET /metrics HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n").unwrap();
        let mut text = String::new();
        stream.read_to_string(&mut text).unwrap();
        let sum = |name: &str| {
            let lines = text.lines().filter(|line| line.starts_with(name));
            lines.map(|line| line.rsplit(' ').next().unwrap().parse::<f64>().unwrap()).sum::<f64>() as u64
        };
        Metrics { busy: sum("flankfit_fit_workers_busy "), cancelled: sum("flankfit_cancelled_work_seconds_count") }
    }
}

/// A request that was sent; dropping it is leaving.
pub fn sent(address: &str, path: &str, body: &Body) -> TcpStream {
    let mut stream = TcpStream::connect(address).unwrap();
    let Body { media, bytes } = body;
    let head = format!(
        "POST {path} HTTP/1.1\r\nhost: [::1]\r\ncontent-type: {media}\r\ncontent-length: {}\r\n\r\n",
        bytes.len()
    );
    stream.write_all(head.as_bytes()).unwrap();
    stream.write_all(bytes).unwrap();
    stream
}

/// Response so far, if any.
fn answered(stream: &mut TcpStream) -> Option<String> {
    stream.set_nonblocking(true).unwrap();
    let mut text = vec![0; 4096];
    let read = stream.read(&mut text);
    stream.set_nonblocking(false).unwrap();
    match read {
        Ok(length) => Some(String::from_utf8_lossy(&text[..length]).into_owned()),
        Err(error) if error.kind() == ErrorKind::WouldBlock => None,
        Err(error) => panic!("{error}"),
    }
}

/// Waits until the process burns no more than a thread that polls it does.
#[cfg(target_os = "linux")]
fn until_quiet(process: u32, until: Instant) {
    let ticks = || -> u64 {
        let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap();
        let fields: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
        fields[11].parse::<u64>().unwrap() + fields[12].parse::<u64>().unwrap()
    };
    loop {
        let before = ticks();
        std::thread::sleep(Duration::from_millis(50));
        // a busy thread takes five ticks in that time
        if ticks() - before <= 1 {
            return;
        }
        assert!(Instant::now() < until, "no worker is busy, but the process does not rest");
    }
}

#[cfg(not(target_os = "linux"))]
fn until_quiet(_process: u32, _until: Instant) {}

/// POSTs JSON and reads the answer.
fn ask(server: &Server, path: &str, body: &Value) -> (Value, String) {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let answer = reqwest::Client::new().post(format!("{}{path}", server.base)).json(body).send().await.unwrap();
        let place = answer.headers().get("location").map_or("", |value| value.to_str().unwrap()).to_owned();
        let status = answer.status();
        let text = answer.text().await.unwrap();
        assert!(status.is_success(), "{path}: {text}");
        (serde_json::from_str(&text).unwrap(), place)
    })
}

#[test]
fn every_operation_ends_with_its_client() {
    let directory = tempfile::tempdir().unwrap();
    let server = Server::start_with(&directory.path().join("jobs.db"), &["--workers", "1"]);
    let address = server.base.trim_start_matches("http://").to_owned();

    // what the paths name
    let plain = |nodes: Value| json!({"nodes": nodes, "model": {"type": "polynomial", "degree": 2}});
    let (_, job) = ask(&server, "/v1/jobs", &dear::job());
    ask(&server, &format!("{job}/iterations"), &plain(dear::nodes()));
    let (fit, _) = ask(&server, &format!("{job}/iterations/1/fits"), &dear::replayed());
    let (_, curve_job) = ask(&server, "/v1/jobs", &dear::job());
    ask(&server, &format!("{curve_job}/iterations"), &plain(dear::curve_nodes()));
    let (_, flank_job) = ask(&server, "/v1/jobs", &dear::job());
    let mut flank = plain(dear::nodes());
    flank["flank"] = json!("left");
    ask(&server, &format!("{flank_job}/iterations"), &flank);
    let (_, stream) = ask(&server, &format!("{job}/streams"), &dear::stream());
    let (spec, block) = dear::full_stream();
    let (_, full_stream) = ask(&server, &format!("{job}/streams"), &spec);
    ask(&server, &format!("{full_stream}/nodes"), &block);
    let names = [
        ("{dear_fit}", fit["id"].as_str().unwrap()),
        ("{curve_job}", &curve_job),
        ("{flank_job}", &flank_job),
        ("{full_stream}", &full_stream),
        ("{stream}", &stream),
        ("{job}", &job),
    ];

    let mut worst = Duration::ZERO;
    for (operation, entry) in ENTRIES {
        let (path, body, moments) = match entry {
            Dear(path, body) => (path, body(), &MOMENTS[..]),
            Bounded(path, body) => (path, body(), &MOMENTS[..1]),
            Trivial(_reason) => continue,
        };
        let path = names.iter().fold((*path).to_owned(), |path, (name, value)| path.replace(name, value));
        for moment in moments {
            let leave = || left_in_time(&address, server.id(), operation, (&path, &body), *moment);
            let (mut rest, mut moment) = leave();
            for _ in 0..4 {
                if rest < SOON {
                    break;
                }
                (rest, moment) = leave();
            }
            assert!(rest < SOON, "{operation}: left after {moment:?}, at rest only {rest:?} later");
            println!("{operation}: left after {moment:?}, at rest {rest:?} later");
            worst = worst.max(rest);
        }
    }
    println!("the longest rest: {worst:?}");
    server.kill();
}

/// Time for which the worker continued after a client that left at `moment`, or earlier on a
/// machine that has responded by then; and the moment.
fn left_in_time(
    address: &str,
    process: u32,
    operation: &str,
    request: (&str, &Body),
    moment: Duration,
) -> (Duration, Duration) {
    let mut moment = moment;
    for _ in 0..TRIES {
        if let Some(rest) = left_after(address, process, operation, request, moment) {
            return (rest, moment);
        }
        moment /= 2;
    }
    panic!("{operation}: answered before the client could leave; ask for something dearer");
}

/// Sends a request, leaves when its work has run for `moment`, and returns how long the worker
/// continued; `None` if the response came first.
fn left_after(
    address: &str,
    process: u32,
    operation: &str,
    (path, body): (&str, &Body),
    moment: Duration,
) -> Option<Duration> {
    let before = Metrics::of(address).cancelled;
    let mut client = sent(address, path, body);
    let has_answer = |client: &mut TcpStream| {
        let answer = answered(client);
        if let Some(refusal) = answer.as_ref().filter(|answer| !answer.starts_with("HTTP/1.1 20")) {
            panic!("{operation}: refused\n{refusal}");
        }
        answer.is_some()
    };
    while Metrics::of(address).busy == 0 {
        if has_answer(&mut client) {
            return None;
        }
    }
    let running = Instant::now();
    while running.elapsed() < moment {
        if has_answer(&mut client) {
            return None;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    if has_answer(&mut client) {
        return None;
    }
    drop(client);
    let left = Instant::now();
    let rest = loop {
        let now = Metrics::of(address);
        if now.busy == 0 {
            if now.cancelled == before {
                // It came to its end by itself.
                return None;
            }
            break left.elapsed();
        }
        assert!(left.elapsed() < REST, "{operation}: left after {moment:?}, and the worker goes on");
        std::thread::sleep(Duration::from_millis(2));
    };
    until_quiet(process, left + REST);
    Some(rest)
}

#[test]
fn every_operation_is_entered() {
    let document: Value = serde_json::from_str(flankfit::http::openapi::openapi_json()).unwrap();
    let paths = document["paths"].as_object().unwrap();
    let posts: BTreeSet<&str> =
        paths.values().filter_map(|path| path.get("post")).map(|post| post["operationId"].as_str().unwrap()).collect();
    let entered: BTreeSet<&str> = ENTRIES.iter().map(|(operation, _)| *operation).collect();
    assert_eq!(entered, posts);
    assert_eq!(entered.len(), ENTRIES.len());
}
