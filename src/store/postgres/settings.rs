//! Settings for opening the store.

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

/// Limits of each session: how long it waits for a lock and for a statement, when it is ended in an
/// idle transaction, and how often the server checks that a client is still there.
const SESSION: [(&str, &str); 4] = [
    ("lock_timeout", "2s"),
    ("statement_timeout", "30s"),
    ("idle_in_transaction_session_timeout", "10s"),
    ("client_connection_check_interval", "1s"),
];

impl PostgresSettings {
    /// Returns whether a database URL is of this store.
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

    /// Returns the options for migrations: without limits of time, since they wait for each other.
    pub(super) fn migrations(&self) -> PgConnectOptions {
        let patient = [("lock_timeout", "0"), ("statement_timeout", "0"), ("idle_in_transaction_session_timeout", "0")];
        self.direct.clone().unwrap_or_else(|| self.options.clone().options(patient))
    }

    /// Returns the options for connections that a pooler does not support.
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

/// Parameters of URLs that the library knows; of others it would log the value.
const PARAMETERS: &str = "sslmode ssl-mode sslrootcert ssl-root-cert ssl-ca sslcert ssl-cert sslkey ssl-key \
    statement-cache-capacity host hostaddr port dbname user password application_name options";

/// A URL without the parameters that are not known.
fn without_unknown(url: &str) -> String {
    let Some((place, query)) = url.split_once('?') else { return url.to_owned() };
    let is_known = |parameter: &&str| {
        let name = parameter.split('=').next().unwrap_or_default();
        PARAMETERS.split(' ').any(|known| known == name) || name.starts_with("options")
    };
    let (known, unknown): (Vec<&str>, Vec<&str>) =
        query.split('&').filter(|parameter| !parameter.is_empty()).partition(is_known);
    if !unknown.is_empty() {
        tracing::warn!("the database's URL has {} parameters that are not known; they are left out", unknown.len());
    }
    format!("{place}?{}", known.join("&"))
}

fn parse(url: &str) -> Result<PgConnectOptions, PostgresError> {
    let refused = |reason: String| PostgresError::Url { reason };
    if !PostgresSettings::takes(url) {
        return Err(refused("it begins with postgres://, in small letters".into()));
    }
    let place = url.split_once("://").map_or(url, |(_, rest)| rest).split('?').next().unwrap_or_default();
    if place.split_once('/').is_some_and(|(_, name)| name.contains('@')) {
        // the part before it would be taken for the name of the database, and logged
        return Err(refused("in users and passwords write `/` as %2F, `?` as %3F, `#` as %23, `@` as %40".into()));
    }
    let url = without_unknown(url);
    let options = PgConnectOptions::from_str(&url).map_err(|error| refused(error.to_string()))?;
    Ok(sqlx::ConnectOptions::disable_statement_logging(options.application_name("flankfit")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_that_are_not_known_are_left_out() {
        let given = "postgres://h/d?sslmode=require&passwrd=canary&options[a]=b&x";
        assert_eq!(without_unknown(given), "postgres://h/d?sslmode=require&options[a]=b");
        assert_eq!(without_unknown("postgres://h/d"), "postgres://h/d");
        assert!(PostgresSettings::of_url(given).is_ok());
        let all = "postgres://h/d?ssl-mode=require&sslkey=k&statement-cache-capacity=0&application_name=a";
        assert_eq!(without_unknown(all), all);
    }

    #[test]
    fn the_scheme_says_whose_a_url_is() {
        assert!(PostgresSettings::takes("postgres://h/d") && PostgresSettings::takes("postgresql://h/d"));
        assert!(!PostgresSettings::takes("sqlite://postgres.db"));
    }
}
