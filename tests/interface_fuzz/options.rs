//! The command line. What `cargo test` hands to every test binary is understood too.

/// Requests of one batch; each batch has a service of its own.
pub const BATCH: u64 = 250;

pub enum Role {
    Parent,
    /// Takes the batches `first`, `first + step`, ….
    Worker {
        first: u64,
        step: u64,
    },
    Replay {
        batch: u64,
        index: u64,
        /// Without the requests before it.
        alone: bool,
    },
}

pub struct Options {
    pub requests: u64,
    pub seed: u64,
    /// No new batch after so many.
    pub seconds: u64,
    pub jobs: u64,
    /// Requests of one operation only.
    pub only: Option<String>,
    pub role: Role,
}

const HELP: &str = "interface_fuzz [--requests 20000] [--seed 1] [--seconds N] [--jobs N] [--only OPERATION_ID] \
    [--replay SEED/BATCH/INDEX [--alone]]";

impl Options {
    /// `None` where nothing is to be run.
    pub fn read(arguments: impl Iterator<Item = String>) -> Result<Option<Self>, String> {
        let processors = std::thread::available_parallelism().map_or(1, |n| n.get() as u64);
        let mut options =
            Options { requests: 20_000, seed: 1, seconds: u64::MAX, jobs: processors, only: None, role: Role::Parent };
        let mut arguments = arguments.peekable();
        let mut filters = Vec::new();
        while let Some(argument) = arguments.next() {
            let mut number = |name: &str| {
                let text = arguments.next().ok_or(format!("{name} wants a number"))?;
                text.parse::<u64>().map_err(|error| format!("{name} {text}: {error}"))
            };
            match argument.as_str() {
                "--requests" => options.requests = number("--requests")?,
                "--seed" => options.seed = number("--seed")?,
                "--seconds" => options.seconds = number("--seconds")?,
                "--jobs" => options.jobs = number("--jobs")?.max(1),
                "--only" => options.only = arguments.next(),
                "--worker" => options.role = Role::Worker { first: number("--worker")?, step: number("--worker")? },
                "--replay" => {
                    let text = arguments.next().unwrap_or_default();
                    let parts: Vec<u64> = text.split('/').filter_map(|part| part.parse().ok()).collect();
                    let [seed, batch, index] = parts[..] else { return Err(format!("--replay {text}: {HELP}")) };
                    options.seed = seed;
                    options.role = Role::Replay { batch, index, alone: false };
                }
                "--alone" => {
                    if let Role::Replay { alone, .. } = &mut options.role {
                        *alone = true;
                    }
                }
                "--help" | "-h" => {
                    println!("{HELP}");
                    return Ok(None);
                }
                // of the test harness
                "--list" => {
                    println!("interface_fuzz: test");
                    return Ok(None);
                }
                "--skip" => {
                    if arguments.next().is_some_and(|name| "interface_fuzz".contains(&name)) {
                        return Ok(None);
                    }
                }
                "--test-threads" | "--format" | "--color" | "--logfile" | "-Z" => drop(arguments.next()),
                "--ignored" => return Ok(None),
                other if other.starts_with('-') => {}
                filter => filters.push(filter.to_owned()),
            }
        }
        let wanted = filters.is_empty() || filters.iter().any(|filter| "interface_fuzz".contains(filter));
        Ok(wanted.then_some(options))
    }
}
