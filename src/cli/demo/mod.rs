//! `flankfit demo`: a gear job from first measurement to acceptance, driven over real HTTP and
//! printed as tables.

mod client;
mod closed_loop;
mod flank_form;
mod node_file;
mod numbers;
mod report;
mod story;
mod traces;

use std::{
    io::{self, Write},
    net::SocketAddr,
    path::PathBuf,
};

use clap::Args;
use serde_json::{Value, json};
use tokio::sync::oneshot;

use self::{
    client::Client,
    node_file::{NodeSet, Units},
    story::{SlopeLimit, Story},
};
use super::{CommandError, out::out, reachable, serve::stop_signal};
use crate::{
    app::App,
    config::{Authentication, LogFormat, ServeSettings, TraceSettings},
    telemetry,
};

#[derive(Debug, Args)]
pub struct DemoArguments {
    /// Fit requests or nodes of your own (JSON; CSV with u,v,z or x,y; traces of a gear tester) in
    /// place of the bundled flank.
    #[arg(long, value_name = "FILE")]
    nodes: Option<PathBuf>,
    /// Show corrections of a simulated machine in a loop instead: measured, corrected, machined
    /// again.
    #[arg(long, conflicts_with = "nodes")]
    closed_loop: bool,
    /// Stop when the tables are printed, instead of serving on.
    #[arg(long)]
    exit: bool,
    /// Where the jobs of the demonstration are kept (never taken from the environment, so that a
    /// demonstration cannot write into a cell's own database).
    #[arg(long, visible_alias = "database", value_name = "URL", default_value = "sqlite://flankfit-demo.db")]
    database_url: String,
    /// Address and port to listen on; port 0 takes any free one.
    #[arg(long, env = "FLANKFIT_BIND", default_value = "127.0.0.1:8080")]
    bind: SocketAddr,
}

/// The bundled flank, before and after the correction; `examples/flank_z52.md` says how it was
/// made.
const FLANK: &str = include_str!("../../../examples/flank_z52.json");
const FLANK_REMACHINED: &str = include_str!("../../../examples/flank_z52_remachined.json");
const JOB: &str = include_str!("../../../examples/requests/job.json");

/// Starts a server, drives it, prints, and serves on until it is stopped.
pub fn run(arguments: &DemoArguments) -> Result<(), CommandError> {
    telemetry::init(LogFormat::Pretty, "warn", &TraceSettings::default())?;
    let chapters = match &arguments.nodes {
        Some(path) => node_file::read(path)?.into_iter().map(Chapter::of_file).collect(),
        None if arguments.closed_loop => Vec::new(),
        None => vec![Chapter::bundled()?],
    };
    let settings = ServeSettings {
        bind: arguments.bind,
        database_url: arguments.database_url.clone(),
        // its client has no key
        auth: Authentication::Off,
        ..ServeSettings::default()
    };

    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
    let app = runtime.block_on(App::start(settings))?;
    let base = format!("http://{}", reachable(app.address()?));
    let (stop, stopped) = oneshot::channel::<()>();
    let server = runtime.spawn(app.serve(async {
        // An error means that the other end is gone, which is a reason to stop as well.
        let _ = stopped.await;
    }));

    let outcome = run_chapters(&chapters, &base, arguments);
    if outcome.is_ok() && !arguments.exit {
        runtime.block_on(async {
            stop_signal()?.await;
            io::Result::Ok(())
        })?;
    }
    drop(stop);
    runtime.block_on(server)?;
    outcome
}

fn run_chapters(chapters: &[Chapter], base: &str, arguments: &DemoArguments) -> Result<(), CommandError> {
    let client = Client::new(base);
    let mut out = out();
    writeln!(
        out,
        "flankfit {} serves at {base} and keeps its jobs in {}",
        env!("CARGO_PKG_VERSION"),
        arguments.database_url
    )?;
    let mut jobs = Vec::new();
    if arguments.closed_loop {
        jobs = closed_loop::run(&client, &mut out)?;
    }
    for chapter in chapters {
        let mut story = Story { client: &client, limit: chapter.limit, out: &mut out };
        jobs.push(story.run(&chapter.job, &chapter.first, chapter.second.as_ref())?);
    }
    if !arguments.exit {
        writeln!(out, "\nThe server stays up (Ctrl-C ends it):")?;
        for job in &jobs {
            writeln!(out, "  trace          {base}{job}/trace")?;
        }
        writeln!(out, "  documentation  {base}/docs\n  metrics        {base}/metrics")?;
        // last, since that is where to look next
        for job in &jobs {
            writeln!(out, "  dashboard      {base}{}", job.trim_start_matches("/v1"))?;
        }
    }
    out.flush()?;
    Ok(())
}

/// One job of the demonstration: what is measured first, and again after re-machining.
struct Chapter {
    job: Value,
    first: NodeSet,
    second: Option<NodeSet>,
    limit: SlopeLimit,
}

/// For flanks of gears that the demonstration knows nothing of.
const DEMONSTRATION_LIMIT: SlopeLimit = SlopeLimit { um: 5.0, of: "this demonstration" };

/// f_Hα of class 5 by ISO 1328-1:2013, unrounded: 0.4 m_n + 0.001 d + 4 µm, here for m_n = 1 mm and
/// d = 52 mm.
const BUNDLED_GEAR_LIMIT: SlopeLimit = SlopeLimit { um: 4.452, of: "class 5" };

impl Chapter {
    fn bundled() -> Result<Self, serde_json::Error> {
        let set = |name: &str, text: &str| {
            let request = serde_json::from_str(text)?;
            Ok(NodeSet { name: name.into(), request, units: Units::FlankDeviation, report: String::new() })
        };
        Ok(Chapter {
            job: serde_json::from_str(JOB)?,
            first: set("left flank of the bundled gear, z = 52, m_n = 1 mm", FLANK)?,
            second: Some(set("the same flank, machined again", FLANK_REMACHINED)?),
            limit: BUNDLED_GEAR_LIMIT,
        })
    }

    fn of_file(set: NodeSet) -> Self {
        Chapter { job: json!({"name": set.name}), first: set, second: None, limit: DEMONSTRATION_LIMIT }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bundled_flank_has_three_missing_nodes() {
        let chapter = Chapter::bundled().unwrap();
        for set in [&chapter.first, chapter.second.as_ref().unwrap()] {
            let rows = set.request["nodes"]["z"].as_array().unwrap();
            let missing = rows.iter().flat_map(|row| row.as_array().unwrap()).filter(|z| z.is_null()).count();
            assert_eq!((rows.len(), missing), (9, 3));
        }
    }
}
