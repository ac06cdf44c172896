//! How the store is opened.

use std::{str::FromStr as _, time::Duration};

use sqlx::postgres::PgConnectOptions;

use super::error::PostgresError;

/// Who brings the schema up to date.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Migrate {
    /// Whoever starts first; the others wait.
    #[default]
    Auto,
    /// Nobody at start: until the schema is there the store is not ready.
    Check,
}

/// See the module's documentation.
#[derive(Clone, Debug)]
pub struct PostgresSettings {
    pub(super) options: PgConnectOptions,
    direct: Option<PgConnectOptions>,
    /// Connections that write.
    pub writers: usize,
    /// Connections that read.
    pub readers: u32,
    /// Writes that may wait for each writing connection; more are refused.
    pub queue: usize,
    /// How long a write or a read is tried again while the server does not answer.
    pub patience: Duration,
    pub migrate: Migrate,
    /// Serve although the server's settings do not let it keep what it says it keeps.
    pub unsafe_store: bool,
}

/// What each session is told: how long it waits for a lock and for a statement, when it is ended in
/// an idle transaction, and how often the server looks whether a client is still there.
const SESSION: [(&str, &str); 4] = [
    ("lock_timeout", "2s"),
    ("statement_timeout", "30s"),
    ("idle_in_transaction_session_timeout", "10s"),
    ("client_connection_check_interval", "1s"),
];

impl PostgresSettings {
    /// Whether a database URL is of this store.
    pub fn takes(url: &str) -> bool {
        ["postgres:", "postgresql:"].iter().any(|scheme| url.starts_with(scheme))
    }

    /// Settings for a database URL such as `postgres://flankfit@db.example/flankfit`.
    pub fn of_url(url: &str) -> Result<Self, PostgresError> {
        let options = parse(url)?.options(SESSION);
        Ok(PostgresSettings {
            options,
            direct: None,
            writers: 4,
            readers: 8,
            queue: 4096,
            patience: Duration::from_secs(5),
            migrate: Migrate::default(),
            unsafe_store: false,
        })
    }

    /// Migrations and notifications go past a pooler, by this URL.
    pub fn direct(mut self, url: &str) -> Result<Self, PostgresError> {
        self.direct = Some(parse(url)?);
        Ok(self)
    }

    /// What migrations connect by: without limits of time, for they wait for each other.
    pub(super) fn migrations(&self) -> PgConnectOptions {
        let patient = [("lock_timeout", "0"), ("statement_timeout", "0"), ("idle_in_transaction_session_timeout", "0")];
        self.direct.clone().unwrap_or_else(|| self.options.clone().options(patient))
    }

    /// What is connected by for what a pooler does not pass on.
    pub(super) fn past_a_pooler(&self) -> PgConnectOptions {
        self.direct.as_ref().unwrap_or(&self.options).clone()
    }

    /// Host, port and name.
    pub fn address(&self) -> String {
        let (host, port) = (self.options.get_host(), self.options.get_port());
        let name = self.options.get_database().unwrap_or(self.options.get_username());
        match self.options.get_socket() {
            Some(folder) => format!("{}:{port}/{name}", folder.display()),
            None => format!("{host}:{port}/{name}"),
        }
    }
}

fn parse(url: &str) -> Result<PgConnectOptions, PostgresError> {
    let options = PgConnectOptions::from_str(url).map_err(|error| PostgresError::Url { reason: error.to_string() })?;
    Ok(sqlx::ConnectOptions::disable_statement_logging(options.application_name("flankfit")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_password_is_not_part_of_what_is_told() {
        let settings = PostgresSettings::of_url("postgres://app:canary@db.example:6432/plant").unwrap();
        assert_eq!(settings.address(), "db.example:6432/plant");
        for wrong in ["postgres://app:canary@db.example:port/plant", "postgres://app:canary@[/x"] {
            let error = PostgresSettings::of_url(wrong).unwrap_err().to_string();
            assert!(!error.contains("canary"), "{error}");
        }
    }

    #[test]
    fn the_scheme_says_whose_a_url_is() {
        assert!(PostgresSettings::takes("postgres://h/d") && PostgresSettings::takes("postgresql://h/d"));
        assert!(!PostgresSettings::takes("sqlite://postgres.db"));
    }
}
