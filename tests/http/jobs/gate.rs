//! A way to PostgreSQL that can be shut: what goes by it is cut then, and whoever comes waits.

use std::path::PathBuf;

use tokio::{
    io::copy_bidirectional,
    net::{TcpListener, UnixStream},
    sync::watch,
};

pub struct Gate {
    pub port: u16,
    open: watch::Sender<bool>,
    /// Connections that it passes on.
    passing: watch::Sender<usize>,
}

impl Gate {
    /// An open one, to a socket of PostgreSQL.
    pub async fn to(socket: PathBuf) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let port = listener.local_addr().unwrap().port();
        let (open, passing) = (watch::Sender::new(true), watch::Sender::new(0));
        let (opened, counted) = (open.clone(), passing.clone());
        tokio::spawn(async move {
            while let Ok((mut client, _)) = listener.accept().await {
                let (socket, mut open, passing) = (socket.clone(), opened.subscribe(), counted.clone());
                tokio::spawn(async move {
                    let _ended = open.wait_for(|open| *open).await.is_err();
                    let Ok(mut server) = UnixStream::connect(socket).await else { return };
                    passing.send_modify(|count| *count += 1);
                    tokio::select! {
                        _ = copy_bidirectional(&mut client, &mut server) => {}
                        _ = async { open.wait_for(|open| !*open).await.is_err() } => {}
                    }
                    drop((client, server));
                    passing.send_modify(|count| *count -= 1);
                });
            }
        });
        Gate { port, open, passing }
    }

    /// Shuts it. Afterwards nothing goes through.
    pub async fn shut(&self) {
        self.open.send_replace(false);
        let shut = self.passing.subscribe().wait_for(|count| *count == 0).await.is_ok();
        assert!(shut);
    }

    pub fn open(&self) {
        self.open.send_replace(true);
    }
}
