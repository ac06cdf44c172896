//! `flankfit serve`.

use super::CommandError;
use crate::{app::App, config::ServeSettings, telemetry};

pub fn run(settings: ServeSettings) -> Result<(), CommandError> {
    telemetry::init_logs(settings.log_format, &settings.log)?;
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
    runtime.block_on(async {
        let app = App::start(settings).await?;
        let address = app.address()?;
        tracing::info!(%address, engine = crate::api::ENGINE, "listening on http://{address}, documentation at http://{address}/docs");
        app.serve(stop_signal()?).await;
        Ok(())
    })
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
