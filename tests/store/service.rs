//! A database that its owner does not serve.

use flankfit::store::{PostgresSettings, migrate};
use sqlx::{Connection as _, Executor as _, PgConnection};
use tokio::sync::OnceCell;

use crate::server::Server;

/// The URLs of a new database with the schema: its owner's, and that of a member of
/// `flankfit_app`.
pub async fn served() -> [String; 2] {
    static ROLES: OnceCell<()> = OnceCell::const_new();
    let server = Server::shared();
    let owners = server.url(&server.copy_of("template1").await);
    ROLES
        .get_or_init(|| async {
            let mut owner = PgConnection::connect(&owners).await.unwrap();
            for sql in ["CREATE ROLE flankfit_app NOLOGIN", "CREATE ROLE service LOGIN IN ROLE flankfit_app"] {
                owner.execute(sql).await.unwrap();
            }
            owner.close().await.unwrap();
        })
        .await;
    // only now: this gives the role its rights
    migrate(&PostgresSettings::of_url(&owners).unwrap()).await.unwrap();
    let services = owners.replace("owner@", "service@");
    [owners, services]
}
