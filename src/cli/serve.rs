//! `flankfit serve`.

use super::CommandError;
use crate::{app::App, config::ServeSettings, telemetry};

pub fn run(settings: ServeSettings) -> Result<(), CommandError> {
    telemetry::init(settings.log_format, &settings.log, &settings.traces)?;
    let runtime =
        tokio::runtime::Builder::new_multi_thread().worker_threads(connection_threads()).enable_all().build()?;
    let outcome = runtime.block_on(async {
        prepare(settings.max_connections)?;
        let app = App::start(settings).await?;
        let address = app.address()?;
        let scheme = if app.has_tls() { "https" } else { "http" };
        tracing::info!(%address, engine = crate::api::ENGINE, "listening on {scheme}://{address}");
        if app.state().dashboard.is_some() {
            tracing::info!("dashboard at {scheme}://{}/", super::reachable(address));
        }
        if app.state().settings.docs {
            tracing::info!("documentation at {scheme}://{}/docs", super::reachable(address));
        }
        if let Some(operation) = app.operation_address() {
            let operation = operation?;
            tracing::info!(address = %operation, "readiness and metrics at http://{operation}/readyz and /metrics");
        }
        app.serve(stop_signal()?).await;
        Ok(())
    });
    // What was accepted has been answered or its grace is over: a fit that still runs is not waited
    // for.
    runtime.shutdown_background();
    telemetry::flush_traces();
    outcome
}

/// Threads that serve connections: one per processor, for they also do the small fits.
fn connection_threads() -> usize {
    std::thread::available_parallelism().map_or(1, |n| n.get())
}

/// Asks the system for handles for all connections, and for an error instead of the end where a
/// file would become too large.
fn prepare(connections: usize) -> std::io::Result<()> {
    #[cfg(unix)]
    {
        use rustix::process::{Resource, Rlimit, Signal, getrlimit, setrlimit};
        use tokio::signal::unix::{SignalKind, signal};
        let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
        let wanted = connections as u64 + crate::http::server::KEPT_HANDLES;
        let wanted = maximum.map_or(wanted, |most| wanted.min(most));
        if current.is_some_and(|current| current < wanted) {
            // with fewer, fewer connections are taken
            let _refused = setrlimit(Resource::Nofile, Rlimit { current: Some(wanted), maximum });
        }
        // Once it is listened for, the signal does not end the program, and the write fails.
        let _listening = signal(SignalKind::from_raw(Signal::XFSZ.as_raw()))?;
    }
    Ok(())
}

/// Ready at SIGTERM or SIGINT.
pub fn stop_signal() -> std::io::Result<impl Future<Output = ()> + Send + 'static> {
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        let mut terminate = signal(SignalKind::terminate())?;
        let mut interrupt = signal(SignalKind::interrupt())?;
        Ok(async move {
            tokio::select! {
                _ = terminate.recv() => {}
                _ = interrupt.recv() => {}
            }
        })
    }
    #[cfg(not(unix))]
    Ok(async {
        let _ = tokio::signal::ctrl_c().await;
    })
}
