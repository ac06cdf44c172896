//! Databases of the tests' servers: each in a file of its own, or with
//! `FLANKFIT_TEST_STORE=postgres` in a database of its own on a PostgreSQL server.

use std::{
    env, fs,
    path::{Path, PathBuf},
    sync::Mutex,
};

use crate::postgres::Server;

/// True if a PostgreSQL server is to be used.
pub fn is_postgres() -> bool {
    env::var("FLANKFIT_TEST_STORE").is_ok_and(|store| store == "postgres")
}

/// The URL of the database of a folder: of one that was used there before, or of a new one.
pub async fn url(folder: &Path) -> String {
    if !is_postgres() {
        return in_file(&folder.join("test.db"));
    }
    let kept = folder.join("url");
    match fs::read_to_string(&kept) {
        Ok(url) => url,
        Err(_) => {
            let server = Server::shared();
            // a database goes after its folder
            USED.lock().unwrap().retain(|(folder, url)| {
                if !folder.exists() {
                    server.done_with(url);
                }
                folder.exists()
            });
            let url = server.database().await;
            fs::write(kept, &url).expect("the folder takes a file");
            USED.lock().unwrap().push((folder.to_owned(), url.clone()));
            url
        }
    }
}

/// Folders and the URLs of their databases.
static USED: Mutex<Vec<(PathBuf, String)>> = Mutex::new(Vec::new());

/// The URL of a file.
pub fn in_file(file: &Path) -> String {
    format!("sqlite://{}", file.display())
}
