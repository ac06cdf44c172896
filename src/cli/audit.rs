//! `flankfit audit verify`: whether all that the audit tells of is as it was written, asked of the
//! database itself and of seals that were kept elsewhere. A server may use the database meanwhile.

use std::{
    fs,
    io::Write as _,
    path::{Path, PathBuf},
    process::ExitCode,
};

use clap::{Args, Subcommand};
use tokio_rustls::rustls::pki_types::{SubjectPublicKeyInfoDer, pem::PemObject};
use uuid::Uuid;

use super::{CommandError, audited::Counted, out::out, progress};
use crate::{
    api::jobs::seals,
    app::open_auditor,
    jobs::{
        Tenant,
        audit::{Chain, Evidence, Fault, Findings, Place, WholeSeal, examine, public_key},
    },
};

/// A fault was found.
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
    /// Verify chains, the rows they have digests of, and seals. Exit code 0: intact; 1: faults, one
    /// on each line; 2: the verification could not be completed.
    Verify(VerifyArguments),
}

#[derive(Debug, Args)]
struct VerifyArguments {
    /// Only the chain of this job, and the seals of its tenant.
    #[arg(long)]
    job: Option<Uuid>,
    /// Every chain of every tenant (the default without --job).
    #[arg(long, conflicts_with = "job")]
    all: bool,
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
    match verify(arguments) {
        Ok(findings) if findings.is_empty() => {
            let _left = writeln!(
                out(),
                "empty: there is nothing in this database that was audited; if there should be, its files were removed or \
                 replaced: restore a backup, and verify it --against seals that were kept elsewhere"
            );
            ExitCode::SUCCESS
        }
        Ok(findings) if findings.is_intact() => {
            let Findings { chains, entries, seals, .. } = findings;
            // if nobody reads the output, the exit code still reports the result
            let _left = writeln!(out(), "intact: {chains} chains, {entries} entries, {seals} seals");
            ExitCode::SUCCESS
        }
        Ok(findings) => {
            let mut out = out();
            if findings.holds_nothing() {
                let _left = writeln!(
                    out,
                    "broken: the database is empty, although it was sealed: its files were removed or replaced; restore a \
                     backup"
                );
            }
            let _left = findings.faults.iter().try_for_each(|fault| writeln!(out, "{}", told(fault)));
            for (tenant, place, why) in &findings.unreadable {
                let _left = writeln!(out, "broken: {}: {why}", named(tenant, place));
            }
            ExitCode::from(BROKEN)
        }
        Err(error) => {
            eprintln!("flankfit: {error}");
            ExitCode::from(UNKNOWN)
        }
    }
}

fn told(Fault { tenant, place, number, what }: &Fault) -> String {
    let one = match place {
        Place::Chain(_) => "entry",
        Place::Seals => "seal",
    };
    format!("broken: {}, {one} {number}: {}", named(tenant, place), what.name())
}

fn named(tenant: &Tenant, place: &Place) -> String {
    let tenant = tenant.as_str();
    match place {
        Place::Chain(Chain::Job(job)) => format!("job {job} of tenant {tenant}"),
        Place::Chain(Chain::Tenant) => format!("tenant {tenant}"),
        Place::Seals => format!("seals of tenant {tenant}"),
    }
}

fn verify(arguments: &VerifyArguments) -> Result<Findings, CommandError> {
    let key = arguments.public_key.as_deref().map(read_key).transpose()?;
    let mut kept = Vec::new();
    for file in &arguments.against {
        kept.extend(read_seals(file)?);
    }
    let places: Vec<String> = kept.iter().map(|(place, _)| place.clone()).collect();
    let seals: Vec<WholeSeal> = kept.into_iter().map(|(_, seal)| seal).collect();
    let evidence = Evidence::of(seals, key)
        .map_err(|place| format!("the seal in {} is not as it was made, so it proves nothing", places[place]))?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let audit = Counted::of(runtime.block_on(open_auditor(&arguments.database_url))?);
    let examined = || runtime.block_on(examine(&audit, arguments.job, &evidence));
    let found = progress::watched("audit", || Some(audit.part()), examined)?;
    found.ok_or_else(|| "there is no such job, and there never was".into())
}

/// The seals of a file, each with its place.
fn read_seals(file: &Path) -> Result<Vec<(String, WholeSeal)>, CommandError> {
    let text = fs::read_to_string(file).map_err(|error| format!("cannot read {}: {error}", file.display()))?;
    let mut seals = Vec::new();
    for (number, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let place = format!("line {} of {}", number + 1, file.display());
        match seals::read(line) {
            Ok(seal) => seals.push((place, seal)),
            // as a server leaves one that is cut off while it writes
            Err(error) => eprintln!("flankfit: {place} is left out, it is no seal: {error}"),
        }
    }
    if seals.is_empty() {
        return Err(format!("there are no seals in {}", file.display()).into());
    }
    Ok(seals)
}

fn read_key(file: &Path) -> Result<[u8; 32], CommandError> {
    let other = || format!("{} holds no Ed25519 public key in PEM form (`-----BEGIN PUBLIC KEY-----`)", file.display());
    let document = SubjectPublicKeyInfoDer::from_pem_file(file).map_err(|error| format!("{}: {error}", other()))?;
    Ok(public_key(&document).ok_or_else(other)?)
}
