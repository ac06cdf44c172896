//! `flankfit keys create`: a key made on the database itself, which is how the first one comes to
//! be. It is written to standard output alone on its line, once; everything else goes to standard
//! error.

use std::sync::Arc;

use clap::{Args, Subcommand};

use super::{CommandError, runtime};
use crate::{
    app::open_store,
    config::{MigrateMode, PostgresArguments, ServeSettings},
    jobs::{
        Caller, JobService, KeyDraft, OrderedIds, PlantDraft, RepositoryError, Resource, Role, Secret, SystemClock,
        Tenant, actor,
    },
};

#[derive(Debug, Args)]
pub struct KeysArguments {
    #[command(subcommand)]
    command: KeysCommand,
}

#[derive(Debug, Subcommand)]
enum KeysCommand {
    /// Make a key and print it; it cannot be printed again.
    Create(CreateArguments),
}

#[derive(Debug, Args)]
struct CreateArguments {
    /// Tenant of the key, made if it does not exist. The role `root` has none.
    #[arg(long, value_parser = parse_tenant)]
    tenant: Option<Tenant>,
    /// Role of the key: reader, operator, engineer, auditor, admin or root.
    #[arg(long, value_parser = parse_role)]
    role: Role,
    /// Name of the key's holder, a person or a program.
    #[arg(long, default_value = "made on the database")]
    name: String,
    /// Database: sqlite://FILE, with no server running on it, or postgres://USER@HOST/NAME.
    #[arg(long, env = "FLANKFIT_DATABASE_URL", default_value = "sqlite://flankfit.db", hide_env_values = true)]
    database_url: String,
    /// PostgreSQL: who makes the schema of a database without one.
    #[arg(long, env = "FLANKFIT_MIGRATE", value_enum, default_value_t = MigrateMode::Auto)]
    migrate: MigrateMode,
    /// PostgreSQL: URL for migrations that bypasses a pooler.
    #[arg(long, env = "FLANKFIT_DATABASE_DIRECT_URL", hide_env_values = true)]
    database_direct_url: Option<String>,
    /// PostgreSQL: continue although the server's settings may lose stored data.
    #[arg(long, env = "FLANKFIT_UNSAFE_STORE")]
    unsafe_store: bool,
}

fn parse_tenant(text: &str) -> Result<Tenant, String> {
    let form = "a tenant has 1 to 63 lower-case letters, digits and hyphens, a hyphen neither first nor last";
    Tenant::named(text).ok_or_else(|| form.to_owned())
}

fn parse_role(text: &str) -> Result<Role, String> {
    Role::named(text).ok_or_else(|| "there are reader, operator, engineer, auditor, admin and root".to_owned())
}

pub fn run(arguments: &KeysArguments) -> Result<(), CommandError> {
    let KeysCommand::Create(arguments) = &arguments.command;
    let tenant = match (&arguments.tenant, arguments.role) {
        (None, Role::Root) => Tenant::root(),
        (Some(_), Role::Root) => return Err("a key of the role root is of no tenant: leave --tenant out".into()),
        (Some(tenant), _) => tenant.clone(),
        (None, _) => return Err("name the tenant whose key it is with --tenant".into()),
    };
    if arguments.name.trim().is_empty() || arguments.name.chars().count() > 200 {
        return Err("--name takes 1 to 200 characters".into());
    }
    if let Some(found) = arguments.name.chars().find(|c| actor::misleads(*c)) {
        let found = u32::from(found);
        return Err(format!("--name holds U+{found:04X}, which is not shown or moves what is; leave it out").into());
    }
    let settings = ServeSettings {
        database_url: arguments.database_url.clone(),
        postgres: PostgresArguments {
            store_writers: 1,
            database_readers: 1,
            migrate: arguments.migrate,
            database_direct_url: arguments.database_direct_url.clone(),
            unsafe_store: arguments.unsafe_store,
            ..PostgresArguments::default()
        },
        ..ServeSettings::default()
    };
    let secret = runtime()?.block_on(async {
        let ids = Arc::new(OrderedIds::new());
        let store = open_store(&settings, ids.clone()).await?;
        let service = JobService::new(store.clone(), Arc::new(SystemClock), ids);
        let made = create(&service, tenant.clone(), arguments).await;
        store.close().await;
        made
    })?;
    let whose = if tenant.is_root() { "no tenant".to_owned() } else { format!("tenant {}", tenant.as_str()) };
    eprintln!("a key of {whose} with the role {}; it cannot be shown again:", arguments.role.name());
    println!("{}", secret.expose());
    Ok(())
}

async fn create(
    service: &Arc<JobService>,
    tenant: Tenant,
    arguments: &CreateArguments,
) -> Result<Secret, CommandError> {
    // a missing schema is reported as that, not as the first missing table
    service.ping().await?;
    let keys = service.keys_of(&Caller {
        tenant: tenant.clone(),
        actor: actor::ON_THE_DATABASE.into(),
        origin: Default::default(),
    });
    let draft = KeyDraft {
        name: arguments.name.clone(),
        role: Some(arguments.role),
        scopes: arguments.role.scopes(),
        expires_at: None,
        san: None,
    };
    let there = tenant.is_root()
        || match keys.plant(tenant.clone()).await {
            Ok(_) => true,
            Err(RepositoryError::NotFound(Resource::Tenant)) => false,
            Err(error) => return Err(error.into()),
        };
    let secret = if there {
        keys.create(draft, None).await?.1
    } else {
        keys.create_plant(PlantDraft { name: tenant, description: None }, draft, None).await?.1
    };
    secret.ok_or_else(|| "the key has no secret".into())
}
