//! Starts the workers, collects their findings, and reports.

use std::{
    collections::BTreeMap,
    io::{BufRead as _, BufReader},
    process::{Command, ExitCode, Stdio},
    sync::Mutex,
    time::Instant,
};

use super::{
    options::{BATCH, Options},
    worker::{AGAIN, folder},
};

/// One kind of finding of one operation.
#[derive(Default)]
struct Found {
    count: u64,
    /// First finding: the command that repeats it, and its message.
    replay: String,
    said: String,
}

#[derive(Default)]
struct Totals {
    requests: u64,
    statuses: BTreeMap<u16, u64>,
    /// Requests and successes by operation.
    operations: BTreeMap<String, [u64; 2]>,
    findings: BTreeMap<(String, String, String), Found>,
    timeouts: BTreeMap<String, Found>,
    slowest: (f64, String),
    biggest: (u64, String),
}

impl Totals {
    fn find(&mut self, kind: &str, operation: &str, replay: &str, said: &str) {
        // what differs by numbers only is one finding
        let alike: String = said.chars().filter(|c| !c.is_ascii_digit()).take(160).collect();
        let found = self.findings.entry((kind.into(), operation.into(), alike)).or_default();
        found.count += 1;
        if found.count == 1 {
            (found.replay, found.said) = (replay.into(), said.into());
            println!("FOUND {kind} {operation}\n  --replay {replay}\n  {said}");
        }
    }

    /// Takes one line of a worker.
    fn take(&mut self, line: &str) {
        let parts: Vec<&str> = line.splitn(5, '\t').collect();
        match parts[..] {
            ["D", operation, replay, seconds, bytes] => {
                self.requests += 1;
                let (seconds, bytes) = (seconds.parse().unwrap_or(0.0), bytes.parse().unwrap_or(0));
                let named = || format!("{operation}, --replay {replay}");
                if seconds > self.slowest.0 {
                    self.slowest = (seconds, named());
                }
                if bytes > self.biggest.0 {
                    self.biggest = (bytes, named());
                }
            }
            ["C", operation, status, count] => {
                let (status, count) = (status.parse().unwrap_or(0), count.parse().unwrap_or(0));
                *self.statuses.entry(status).or_default() += count;
                let [all, taken] = self.operations.entry(operation.into()).or_default();
                *all += count;
                *taken += if (200..300).contains(&status) { count } else { 0 };
            }
            ["F", kind, operation, replay, said] => self.find(kind, operation, replay, said),
            ["T", operation, replay] => {
                let found = self.timeouts.entry(operation.into()).or_default();
                found.count += 1;
                found.replay = replay.into();
            }
            _ => {}
        }
    }
}

/// Runs everything; fails where anything was found.
pub fn run(options: &Options) -> ExitCode {
    let start = Instant::now();
    let _gone = std::fs::remove_dir_all(folder());
    let totals = Mutex::new(Totals::default());
    std::thread::scope(|scope| {
        for first in 0..options.jobs {
            let totals = &totals;
            scope.spawn(move || worker(options, first, start, totals));
        }
    });
    let totals = totals.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    println!(
        "interface_fuzz: {} requests in {:.0} s (seed {}), {} kinds of findings",
        totals.requests,
        start.elapsed().as_secs_f64(),
        options.seed,
        totals.findings.len()
    );
    let statuses: Vec<String> = totals.statuses.iter().map(|(status, count)| format!("{status}: {count}")).collect();
    println!("  answers: {}", statuses.join(", "));
    let shares: Vec<String> =
        totals.operations.iter().map(|(id, [all, taken])| format!("{id} {}", 100 * taken / (*all).max(1))).collect();
    println!("  taken, in percent: {}", shares.join(", "));
    println!("  slowest: {:.2} s, {}", totals.slowest.0, totals.slowest.1);
    println!("  biggest: {} MB, {}", totals.biggest.0 / 1_000_000, totals.biggest.1);
    for (operation, found) in &totals.timeouts {
        println!("  503 request_timeout: {operation} {} times, --replay {}", found.count, found.replay);
    }
    for ((kind, operation, _), found) in &totals.findings {
        println!("FINDING {kind} {operation}: {} times, --replay {}\n  {}", found.count, found.replay, found.said);
    }
    if totals.findings.is_empty() && totals.requests > 0 {
        return ExitCode::SUCCESS;
    }
    println!("  the requests are in {}", folder().display());
    ExitCode::FAILURE
}

/// One process after the other for every `jobs`th batch, until all are done.
fn worker(options: &Options, first: u64, start: Instant, totals: &Mutex<Totals>) {
    let mut next = first;
    while next * BATCH < options.requests {
        let left = options.seconds.saturating_sub(start.elapsed().as_secs());
        let program = std::env::current_exe().expect("this program");
        let mut command = Command::new(program);
        command.args(["--worker", &next.to_string(), &options.jobs.to_string()]);
        command.args(["--seed", &options.seed.to_string(), "--requests", &options.requests.to_string()]);
        command.args(["--seconds", &left.to_string()]);
        command.args(options.only.iter().flat_map(|only| ["--only", only.as_str()]));
        let mut child = command.stdout(Stdio::piped()).stdin(Stdio::null()).spawn().expect("a worker");
        let mut at = None;
        if let Some(out) = child.stdout.take() {
            for line in BufReader::new(out).split(b'\n').map_while(Result::ok) {
                let line = String::from_utf8_lossy(&line);
                let mut parts = line.split('\t');
                if parts.next() == Some("P") {
                    let mut number = || parts.next().and_then(|text| text.parse().ok()).unwrap_or(0);
                    at = Some((number(), number()));
                } else {
                    totals.lock().expect("no worker panics").take(&line);
                }
            }
        }
        let ended = child.wait().expect("a worker ends");
        if ended.success() {
            return;
        }
        let (batch, index) = at.unwrap_or((next, 0));
        if ended.code() != Some(i32::from(AGAIN)) {
            let replay = format!("{}/{batch}/{index}", options.seed);
            let said = format!("the process ended: {ended}");
            totals.lock().expect("no worker panics").find("crash", "any", &replay, &said);
        }
        if at.is_none() {
            // none would get further
            return;
        }
        next = batch + options.jobs;
    }
}
