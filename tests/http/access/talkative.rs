//! A server that logs everything, and what it has said.

use std::{
    io::{BufRead as _, BufReader},
    path::Path,
    process::{Child, Command, Stdio},
    sync::{Arc, Mutex},
    thread::JoinHandle,
};

use serde_json::Value;

use crate::database::in_file;

/// See the module's documentation.
pub struct Talkative {
    child: Child,
    pub base: String,
    said: Arc<Mutex<String>>,
    /// Reads what is said, until there is no more.
    hearing: Option<JoinHandle<()>>,
}

impl Talkative {
    /// Starts a server with these additional arguments.
    pub fn start(database: &Path, arguments: &[&str]) -> Self {
        Self::within(&[], database, arguments)
    }

    /// One within this environment.
    pub fn within(environment: &[(&str, &str)], database: &Path, arguments: &[&str]) -> Self {
        Self::logging("trace", environment, database, arguments)
    }

    /// One that logs so much only.
    pub fn logging(level: &str, environment: &[(&str, &str)], database: &Path, arguments: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_flankfit"))
            .args(["serve", "--bind", "127.0.0.1:0", "--log-format", "json", "--log", level, "--database-url"])
            .arg(in_file(database))
            .args(arguments)
            .env_clear()
            .envs(environment.iter().copied())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut log = BufReader::new(child.stderr.take().unwrap());
        let said = Arc::<Mutex<String>>::default();
        let mut line = String::new();
        let address = loop {
            line.clear();
            assert_ne!(log.read_line(&mut line).unwrap(), 0, "the server ended before it listened");
            said.lock().unwrap().push_str(&line);
            let entry: Value = serde_json::from_str(&line).unwrap_or_default();
            if let Some(address) = entry["address"].as_str() {
                break address.to_owned();
            }
        };
        let heard = said.clone();
        let hearing = std::thread::spawn(move || {
            let mut line = String::new();
            while log.read_line(&mut line).is_ok_and(|length| length > 0) {
                heard.lock().unwrap().push_str(&line);
                line.clear();
            }
        });
        Talkative { child, base: format!("http://{address}"), said, hearing: Some(hearing) }
    }

    /// Log so far.
    pub fn said(&self) -> String {
        self.said.lock().unwrap().clone()
    }

    /// Sends the server the signal to end.
    pub fn terminate(&self) {
        let status = Command::new("kill").args(["-TERM", &self.child.id().to_string()]).status().unwrap();
        assert!(status.success());
    }

    /// Ends the server by a signal, and returns its whole log.
    pub fn end(mut self) -> String {
        self.terminate();
        assert!(self.child.wait().unwrap().success());
        // the last lines may still be on their way when the process has gone
        self.hearing.take().unwrap().join().unwrap();
        self.said()
    }
}

impl Drop for Talkative {
    fn drop(&mut self) {
        let _ended_already = self.child.kill();
        let _status = self.child.wait();
    }
}
