//! Batches of requests, one after the other, so that time and memory are those of one.

use std::{
    collections::BTreeMap,
    io::Write as _,
    panic,
    process::ExitCode,
    sync::Mutex,
    time::{Duration, Instant},
};

use flankfit::api::examples::REQUEST_EXAMPLES;
use tokio::runtime::Runtime;

use super::{
    check::{self, Finding},
    contract::{Contract, Operation},
    fixture::{Service, Stored},
    forms::Files,
    memory,
    node::Node,
    options::{BATCH, Options},
    prepare,
    request::{Maker, Request},
    rng::Rng,
    send::{self, Answer},
};

/// Exit code of a worker that is to be replaced by another one, which continues with the next
/// batch.
pub const AGAIN: u8 = 3;
/// An answer that has not come by then never comes.
const HANGS: Duration = Duration::from_secs(30);

static PANICS: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Sources of requests, the same for all of them.
struct Stage {
    contract: Contract,
    draws: Vec<(Operation, Option<Node>)>,
    bodies: Vec<Node>,
    files: Files,
}

impl Stage {
    fn new(only: Option<&str>) -> Self {
        let contract = Contract::new(flankfit::http::openapi::openapi_json());
        let mut draws = Vec::new();
        for operation in contract.operations.iter().filter(|operation| only.is_none_or(|only| operation.id == only)) {
            let examples = REQUEST_EXAMPLES.iter().filter(|example| example.operation_id == operation.id);
            let mut bodies: Vec<Node> = examples.map(|e| Node::parse(e.text).expect("an example is JSON")).collect();
            let json = operation.bodies.iter().find(|(media, _)| media == "application/json");
            bodies.extend(json.and_then(|(_, schema)| contract.example(schema)));
            let takes_json = json.is_some();
            assert!(!(takes_json && bodies.is_empty()), "{} has no example in api::examples", operation.id);
            // one of many tags of an operation is as good as another: what takes a body gets more
            // draws, studies one
            let slots = match (bodies.len(), operation.id.as_str()) {
                (0, _) if operation.bodies.is_empty() => 2,
                (0, _) => 6,
                (_, "study_randomization") => 1,
                (count, _) => count.max(6),
            };
            for slot in 0..slots {
                draws.push((operation.clone(), bodies.get(slot % bodies.len().max(1)).cloned()));
            }
        }
        let bodies = REQUEST_EXAMPLES.iter().filter_map(|example| Node::parse(example.text)).collect();
        Stage { contract, draws, bodies, files: Files::new() }
    }

    fn maker(&self) -> Maker<'_> {
        Maker { contract: &self.contract, draws: &self.draws, bodies: &self.bodies, files: &self.files }
    }
}

/// Result of one request.
struct Outcome {
    request: Request,
    answer: Option<Answer>,
    seconds: f64,
    bytes: usize,
    findings: Vec<Finding>,
}

struct Batch {
    service: Service,
    stored: Stored,
}

impl Batch {
    async fn start() -> Self {
        let service = Service::start().await;
        let stored = Stored::fill(&service).await;
        Batch { service, stored }
    }

    async fn one(&mut self, stage: &Stage, seed: u64, batch: u64, index: u64) -> Outcome {
        let mut rng = Rng::of(seed, batch, index);
        let mut request = stage.maker().make(&self.stored, &mut rng);
        prepare::prepare(&self.service, &mut request, &mut rng).await;
        let before = memory::mark();
        let (start, processor) = (Instant::now(), processor_seconds());
        let answer = tokio::time::timeout(HANGS, send::send(&self.service, &request)).await;
        let (seconds, processor) = (start.elapsed().as_secs_f64(), processor_seconds() - processor);
        let mut findings: Vec<Finding> = Vec::new();
        if answer.is_err() {
            findings.push(("hangs", format!("no answer within {HANGS:?}")));
        }
        let answer = answer.ok().flatten();
        let bytes = answer.as_ref().map_or_else(memory::peak, |answer| answer.peak).saturating_sub(before);
        if let Some(answer) = &answer {
            let operation = stage.contract.operations.iter().find(|operation| operation.id == request.operation);
            check::answer(&request, operation, answer, &mut findings);
            if let Ok(body) = serde_json::from_slice(&answer.body)
                && (200..300).contains(&answer.status)
            {
                self.stored.learn(&request.target, answer.tag.as_deref(), &body);
            }
        }
        for panic in PANICS.lock().expect("no panic while panics are reported").drain(..) {
            findings.push(("panic", panic));
        }
        // a machine that does other things may stop the clock of none, but not that of the
        // processor
        if seconds > check::MOST_SECONDS && processor > check::MOST_SECONDS - 1.0 {
            findings.push(("slow", format!("{seconds:.1} s, {processor:.1} s of the processor")));
        }
        if bytes > check::MOST_BYTES {
            findings.push(("memory", format!("{} MB", bytes / 1_000_000)));
        }
        Outcome { request, answer, seconds, bytes, findings }
    }
}

/// User and system time of the process.
fn processor_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after_name = stat.rsplit(')').next().unwrap_or_default();
    let ticks = after_name.split_whitespace().skip(11).take(2).filter_map(|ticks| ticks.parse::<f64>().ok());
    ticks.sum::<f64>() / 100.0
}

/// True if the process does nothing within two seconds, though nobody asks it to.
fn rests() -> bool {
    (0..10).any(|_| {
        let before = processor_seconds();
        std::thread::sleep(Duration::from_millis(200));
        processor_seconds() - before < 0.05
    })
}

fn watch_panics() {
    panic::set_hook(Box::new(|info| {
        let thread = std::thread::current();
        if thread.name() == Some("main") {
            eprintln!("{info}");
        }
        if let Ok(mut panics) = PANICS.lock() {
            panics.push(info.to_string().replace('\n', " "));
        }
    }));
}

fn runtime() -> Runtime {
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build();
    runtime.expect("a runtime")
}

/// Runs batches and reports to the parent by lines on standard output.
pub fn run(options: &Options, first: u64, step: u64) -> ExitCode {
    watch_panics();
    let stage = Stage::new(options.only.as_deref());
    let start = Instant::now();
    let mut out = std::io::stdout().lock();
    let mut report = |line: String| {
        // a parent that has gone away needs no news
        let _told = writeln!(out, "{}", line.replace(['\n', '\r'], " ")).and_then(|()| out.flush());
    };
    let mut batch = first;
    while batch * BATCH < options.requests && start.elapsed().as_secs() < options.seconds {
        let runtime = runtime();
        let mut counts: BTreeMap<(String, u16), u64> = BTreeMap::new();
        let mut again = false;
        runtime.block_on(async {
            report(format!("P\t{batch}\t0"));
            let mut current = Batch::start().await;
            for index in 0..BATCH.min(options.requests - batch * BATCH) {
                report(format!("P\t{batch}\t{index}"));
                let outcome = current.one(&stage, options.seed, batch, index).await;
                let replay = format!("{}/{batch}/{index}", options.seed);
                let status = outcome.answer.as_ref().map_or(0, |answer| answer.status);
                *counts.entry((outcome.request.operation.clone(), status)).or_default() += 1;
                report(format!(
                    "D\t{}\t{replay}\t{:.3}\t{}",
                    outcome.request.operation, outcome.seconds, outcome.bytes
                ));
                for (kind, said) in &outcome.findings {
                    keep(&replay, &outcome);
                    report(format!("F\t{kind}\t{}\t{replay}\t{said}", outcome.request.operation));
                }
                if timed_out(outcome.answer.as_ref()) {
                    report(format!("T\t{}\t{replay}", outcome.request.operation));
                }
                let hung = outcome.findings.iter().any(|(kind, _)| *kind == "hangs");
                if hung || (timed_out(outcome.answer.as_ref()) && !rests()) {
                    report(format!(
                        "F\tnever_rests\t{}\t{replay}\twork goes on after its answer",
                        outcome.request.operation
                    ));
                    keep(&replay, &outcome);
                    again = true;
                    break;
                }
            }
        });
        for ((operation, status), count) in counts {
            report(format!("C\t{operation}\t{status}\t{count}"));
        }
        if again {
            std::process::exit(i32::from(AGAIN));
        }
        runtime.shutdown_timeout(Duration::from_secs(2));
        batch += step;
    }
    ExitCode::SUCCESS
}

fn timed_out(answer: Option<&Answer>) -> bool {
    let text = |answer: &Answer| String::from_utf8_lossy(&answer.body).contains("request_timeout");
    answer.is_some_and(|answer| answer.status == 503 && text(answer))
}

/// Folder of requests with findings, to be inspected and sent again.
pub fn folder() -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("interface_fuzz")
}

fn keep(replay: &str, outcome: &Outcome) {
    let mut text = send::wire(&outcome.request);
    text.extend_from_slice(b"\n\n");
    for (kind, said) in &outcome.findings {
        text.extend_from_slice(format!("{kind}: {said}\n").as_bytes());
    }
    if let Some(answer) = &outcome.answer {
        text.extend_from_slice(format!("{}\n", answer.status).as_bytes());
        text.extend_from_slice(&answer.body[..answer.body.len().min(4000)]);
    }
    // a full disk must not end the run
    let _kept =
        std::fs::create_dir_all(folder()).and_then(|()| std::fs::write(folder().join(replay.replace('/', "-")), text));
}

/// One request again, after those of its batch that came before it.
pub fn replay(seed: u64, batch: u64, index: u64, alone: bool) -> ExitCode {
    watch_panics();
    let stage = Stage::new(None);
    let outcome = runtime().block_on(async {
        let mut current = Batch::start().await;
        for before in 0..if alone { 0 } else { index } {
            current.one(&stage, seed, batch, before).await;
        }
        current.one(&stage, seed, batch, index).await
    });
    println!("{}\n", String::from_utf8_lossy(&send::wire(&outcome.request)));
    if let Some(answer) = &outcome.answer {
        println!("{} {}", answer.status, String::from_utf8_lossy(&answer.body[..answer.body.len().min(4000)]));
    }
    println!("{:.3} s, {} kB", outcome.seconds, outcome.bytes / 1000);
    for (kind, said) in &outcome.findings {
        println!("{kind}: {said}");
    }
    if outcome.findings.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
