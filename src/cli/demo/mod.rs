//! `flankfit demo`: a gear job from first measurement to acceptance, driven over real HTTP.

mod client;
mod closed_loop;
mod gear;
pub mod node_file;
mod numbers;
mod report;
mod story;

use std::{
    io::{self, Write},
    net::SocketAddr,
    path::PathBuf,
};

use clap::Args;
use tokio::sync::oneshot;

use self::{client::Client, node_file::NodeSet, story::Story};
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
    /// Show a simulated machine that is measured, corrected and used again, in several rounds.
    #[arg(long, conflicts_with = "nodes")]
    closed_loop: bool,
    /// Print every table of every fit, not only the results.
    #[arg(long)]
    verbose: bool,
    /// Stop after the results are printed, instead of running the server.
    #[arg(long)]
    exit: bool,
    /// Database of the demonstration's jobs (never taken from the environment, so that a
    /// demonstration cannot write into a production database).
    #[arg(long, visible_alias = "database", value_name = "URL", default_value = "sqlite://flankfit-demo.db")]
    database_url: String,
    /// Address and port to listen on; port 0 selects a free one.
    #[arg(long, env = "FLANKFIT_BIND", default_value = "127.0.0.1:8080")]
    bind: SocketAddr,
}

/// Starts a server, runs the demonstration, prints the results, and serves until stopped.
pub fn run(arguments: &DemoArguments) -> Result<(), CommandError> {
    telemetry::init(LogFormat::Pretty, "warn", &TraceSettings::default())?;
    let own = arguments.nodes.as_deref().map(node_file::read).transpose()?;
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

    let outcome = drive(own.as_deref(), &base, arguments);
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

fn drive(own: Option<&[NodeSet]>, base: &str, arguments: &DemoArguments) -> Result<(), CommandError> {
    let client = Client::new(base);
    let mut out = out();
    writeln!(
        out,
        "flankfit {} serves at {base} and keeps its jobs in {}",
        env!("CARGO_PKG_VERSION"),
        arguments.database_url
    )?;
    let jobs = match own {
        Some(sets) => {
            let mut story = Story { client: &client, out: &mut out };
            sets.iter().map(|set| story.run(set)).collect::<Result<Vec<String>, _>>()?
        }
        None if arguments.closed_loop => closed_loop::run(&client, &mut out)?,
        None => vec![gear::run(&client, &mut out, arguments.verbose)?],
    };
    if !arguments.exit {
        writeln!(out, "\nThe server stays up (Ctrl-C ends it). Documentation: {base}/docs")?;
        for job in &jobs {
            writeln!(out, "  dashboard  {base}{}", job.trim_start_matches("/v1"))?;
        }
    }
    out.flush()?;
    Ok(())
}
