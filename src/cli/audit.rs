//! `flankfit audit verify`: checks whether all audited data are as they were written, in the
//! database itself and of seals that were kept elsewhere. A server may use the database meanwhile.

use std::{
    fs,
    io::{self, Write},
    path::{Path, PathBuf},
    process::ExitCode,
    sync::atomic::{AtomicU64, Ordering::Relaxed},
};

use clap::{Args, Subcommand};
use tokio_rustls::rustls::pki_types::{SubjectPublicKeyInfoDer, pem::PemObject};
use uuid::Uuid;

use super::{CommandError, out::out, progress, runtime};
use crate::{
    api::jobs::seals,
    app::open_auditor,
    jobs::audit::{Difference, Evidence, Verdict, examine, public_key},
};

/// A difference was found.
const BROKEN: u8 = 1;
/// The verification could not be completed.
const UNKNOWN: u8 = 2;

#[derive(Debug, Args)]
pub struct AuditArguments {
    #[command(subcommand)]
    command: AuditCommand,
}

#[derive(Debug, Subcommand)]
enum AuditCommand {
    /// Verify entries, rows, chains and seals. Exit code 0: intact; 1: differences, one on each
    /// line; 2: the verification could not be completed.
    Verify(VerifyArguments),
}

#[derive(Debug, Args)]
struct VerifyArguments {
    /// Only this job; without it everything of every tenant.
    #[arg(long)]
    job: Option<Uuid>,
    /// A copy of the file of seals that --audit-seal-file of the server writes; may be given
    /// several times.
    #[arg(long, value_name = "SEALS")]
    against: Vec<PathBuf>,
    /// File (PEM) with the public key that every seal must be signed with.
    #[arg(long, value_name = "FILE")]
    public_key: Option<PathBuf>,
    /// The database: sqlite://FILE, or postgres://USER@HOST/NAME.
    #[arg(long, env = "FLANKFIT_DATABASE_URL", default_value = "sqlite://flankfit.db", hide_env_values = true)]
    database_url: String,
}

pub fn run(arguments: &AuditArguments) -> ExitCode {
    let AuditCommand::Verify(arguments) = &arguments.command;
    let (verdict, spoilt) = match verify(arguments) {
        Ok(verified) => verified,
        Err(error) => {
            eprintln!("flankfit: {error}");
            return ExitCode::from(UNKNOWN);
        }
    };
    let mut out = out();
    // if nobody reads the output, the exit code still reports the result
    let printed = print_verdict(&mut out, &verdict, &spoilt);
    let is_intact = verdict.differences.is_empty() && spoilt.is_empty();
    let _left = printed.and_then(|()| out.flush());
    if is_intact { ExitCode::SUCCESS } else { ExitCode::from(BROKEN) }
}

fn print_verdict(out: &mut impl Write, verdict: &Verdict, spoilt: &[String]) -> io::Result<()> {
    let Verdict { jobs, entries, unsealed, seals, differences } = verdict;
    match (verdict.is_empty(), differences.is_empty() && spoilt.is_empty()) {
        (true, true) => writeln!(
            out,
            "empty: there is nothing in this database that was audited; if there should be, its files were removed or \
             replaced: restore a backup, and verify it --against seals that were kept elsewhere"
        )?,
        (true, false) => writeln!(
            out,
            "broken: the database is empty, although it was sealed: its files were removed or replaced; restore a backup"
        )?,
        (false, true) => writeln!(
            out,
            "intact: {jobs} jobs, {entries} entries, {seals} seals; {unsealed} entries are not sealed yet: they were \
             verified against their rows only"
        )?,
        (false, false) => {}
    }
    spoilt.iter().try_for_each(|line| writeln!(out, "broken: {line}"))?;
    differences.iter().try_for_each(|Difference { tenant, job, place, kind }| {
        let job = job.map(|job| format!("job {job} of ")).unwrap_or_default();
        writeln!(out, "broken: {job}tenant {tenant}, {place}: {}", kind.name())
    })
}

/// Returns the result, and what is wrong with the seals that were kept elsewhere.
fn verify(arguments: &VerifyArguments) -> Result<(Verdict, Vec<String>), CommandError> {
    let key = arguments.public_key.as_deref().map(read_key).transpose()?;
    let (mut places, mut seals, mut spoilt) = (Vec::new(), Vec::new(), Vec::new());
    for file in &arguments.against {
        let text = fs::read_to_string(file).map_err(|error| format!("cannot read {}: {error}", file.display()))?;
        for (number, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
            let place = format!("line {} of {}", number + 1, file.display());
            match seals::read(line) {
                Ok(seal) => {
                    places.push(place);
                    seals.push(seal);
                }
                Err(error) => spoilt.push(format!("{place} is no seal, or was cut off: {error}")),
            }
        }
        if seals.is_empty() && spoilt.is_empty() {
            return Err(format!("there are no seals in {}", file.display()).into());
        }
    }
    let evidence = Evidence::of(seals, key)
        .map_err(|place| format!("the seal in {} is not as it was made, so it proves nothing", places[place]))?;
    let runtime = runtime()?;
    let auditor = runtime.block_on(open_auditor(&arguments.database_url))?;
    let done = AtomicU64::new(0);
    let step = |part: f64| done.store(part.to_bits(), Relaxed);
    let examined = || runtime.block_on(examine(&*auditor, None, arguments.job, &evidence, &step));
    let part = || Some(f64::from_bits(done.load(Relaxed)));
    let verdict = progress::watched("audit", part, examined)?;
    match arguments.job {
        Some(_) if verdict.is_empty() => Err("there is no such job, and there never was".into()),
        _ => Ok((verdict, spoilt)),
    }
}

fn read_key(file: &Path) -> Result<[u8; 32], CommandError> {
    let other = || format!("{} holds no Ed25519 public key in PEM form (`-----BEGIN PUBLIC KEY-----`)", file.display());
    let document = SubjectPublicKeyInfoDer::from_pem_file(file).map_err(|error| format!("{}: {error}", other()))?;
    Ok(public_key(&document).ok_or_else(other)?)
}
