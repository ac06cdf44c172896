//! Migrations and the dashboard are embedded at compile time; a new file must lead to a new build.
//! And tests that need a PostgreSQL server, haproxy or openssl are ignored where there is none,
//! unless FLANKFIT_TEST_POSTGRES=required; those that need promtool are wherever there is none.

use std::{env, fs, path::PathBuf};

fn main() {
    println!("cargo:rerun-if-changed=migrations");
    for embedded in ["index.html", "app", "vendor"] {
        println!("cargo:rerun-if-changed=web/{embedded}");
    }
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed=FLANKFIT_TEST_POSTGRES");
    println!("cargo:rerun-if-env-changed=FLANKFIT_POSTGRES_BIN");
    println!("cargo:rustc-check-cfg=cfg(without_postgres, without_haproxy, without_promtool, without_openssl)");
    let required = env::var("FLANKFIT_TEST_POSTGRES").is_ok_and(|wanted| wanted == "required");
    if !required && !has_postgres() {
        println!("cargo:rustc-cfg=without_postgres");
    }
    if !required && !has_haproxy() {
        println!("cargo:rustc-cfg=without_haproxy");
    }
    if !required && !is_in_path("openssl") {
        println!("cargo:rustc-cfg=without_openssl");
    }
    if !is_in_path("promtool") {
        println!("cargo:rustc-cfg=without_promtool");
    }
}

fn is_in_path(program: &str) -> bool {
    env::split_paths(&env::var_os("PATH").unwrap_or_default()).any(|folder| folder.join(program).exists())
}

fn has_haproxy() -> bool {
    let path = env::var_os("PATH").unwrap_or_default();
    let folders = env::split_paths(&path).chain(["/usr/sbin".into(), "/usr/local/sbin".into()]);
    folders.into_iter().any(|folder| folder.join("haproxy").exists())
}

fn has_postgres() -> bool {
    let installed = fs::read_dir("/usr/lib/postgresql").into_iter().flatten().flatten();
    let path = env::var_os("PATH").unwrap_or_default();
    let named = env::var_os("FLANKFIT_POSTGRES_BIN").map(PathBuf::from);
    let folders = installed.map(|entry| entry.path().join("bin")).chain(env::split_paths(&path)).chain(named);
    folders.into_iter().any(|folder| folder.join("initdb").exists() && folder.join("postgres").exists())
}
