//! The way from the servers to PostgreSQL: passes everything on, and now and then cuts a connection
//! around the message that commits.

use std::{
    collections::HashSet,
    path::PathBuf,
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering},
    },
};

use tokio::{
    io::{AsyncReadExt as _, AsyncWriteExt as _},
    net::{TcpListener, TcpStream, UnixStream},
};

/// Moment at which a connection is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cut {
    /// The server never gets the message: nothing is stored.
    Before,
    /// The server gets it and finds nobody to answer.
    With,
    /// The server's answer is not passed on: everything is stored.
    After,
}

pub const CUTS: [Cut; 3] = [Cut::Before, Cut::With, Cut::After];

/// The next cut, and the cuts so far.
#[derive(Default)]
pub struct Cuts {
    /// One more than the place in [`CUTS`]; zero is nothing.
    next: AtomicUsize,
    fallen: [AtomicU64; CUTS.len()],
}

impl Cuts {
    /// Has the next commit cut.
    pub fn arm(&self, cut: Cut) {
        self.next.store(1 + cut as usize, Ordering::SeqCst);
    }

    /// True if a cut waits for the next commit.
    pub fn is_armed(&self) -> bool {
        self.next.load(Ordering::SeqCst) > 0
    }

    /// Numbers of connections that were cut, in the order of [`CUTS`].
    pub fn fallen(&self) -> [u64; CUTS.len()] {
        self.fallen.each_ref().map(|count| count.load(Ordering::SeqCst))
    }

    fn take(&self) -> Option<Cut> {
        let next = self.next.swap(0, Ordering::SeqCst).checked_sub(1)?;
        self.fallen[next].fetch_add(1, Ordering::SeqCst);
        Some(CUTS[next])
    }
}

/// Listens for the servers and passes on to the socket of PostgreSQL: the port.
pub async fn open(socket: PathBuf, cuts: Arc<Cuts>) -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let port = listener.local_addr().unwrap().port();
    tokio::spawn(async move {
        while let Ok((client, _)) = listener.accept().await {
            let (socket, cuts) = (socket.clone(), cuts.clone());
            tokio::spawn(async move {
                // where PostgreSQL does not listen, the client is left
                if let Ok(server) = UnixStream::connect(socket).await {
                    pass(client, server, &cuts).await;
                }
            });
        }
    });
    port
}

/// Passes everything on until one side ends or the connection is cut.
async fn pass(client: TcpStream, server: UnixStream, cuts: &Cuts) {
    let (mut from_client, mut to_client) = client.into_split();
    let (mut from_server, mut to_server) = server.into_split();
    let silent = AtomicBool::new(false);
    let up = async {
        let (mut sent, mut commits) = (vec![0; 1 << 16], Commits::default());
        while let Ok(length @ 1..) = from_client.read(&mut sent).await {
            let cut = if commits.passes(&sent[..length]) { cuts.take() } else { None };
            silent.fetch_or(cut == Some(Cut::After), Ordering::SeqCst);
            if cut == Some(Cut::Before) || to_server.write_all(&sent[..length]).await.is_err() || cut == Some(Cut::With)
            {
                break;
            }
        }
    };
    let down = async {
        let mut said = vec![0; 1 << 16];
        while let Ok(length @ 1..) = from_server.read(&mut said).await {
            if silent.load(Ordering::SeqCst) || to_client.write_all(&said[..length]).await.is_err() {
                break;
            }
        }
    };
    tokio::select! {
        () = up => {}
        () = down => {}
    }
}

/// Messages of a client, read as far as needed to recognise a COMMIT.
#[derive(Default)]
struct Commits {
    /// Beginning of an incomplete message.
    rest: Vec<u8>,
    /// True if the first message has come, which has no type.
    begun: bool,
    /// The names of prepared statements that commit.
    statements: HashSet<Vec<u8>>,
}

impl Commits {
    /// True if a message that commits ends in these bytes.
    fn passes(&mut self, sent: &[u8]) -> bool {
        self.rest.extend_from_slice(sent);
        let mut commits = false;
        while let Some(message) = self.message() {
            let (kind, body) = (message[0], &message[5..]);
            let mut texts = body.split(|byte| *byte == 0);
            let (first, second) = (texts.next().unwrap_or_default(), texts.next().unwrap_or_default());
            match kind {
                b'Q' => commits |= is_commit(first),
                // name and text of a statement
                b'P' => {
                    self.statements.remove(first);
                    if is_commit(second) {
                        self.statements.insert(first.to_vec());
                    }
                }
                // the portal and the statement it is of
                b'B' => commits |= self.statements.contains(second),
                _ => {}
            }
        }
        commits
    }

    /// The next whole message: type, length, body.
    fn message(&mut self) -> Option<Vec<u8>> {
        loop {
            let kind = usize::from(self.begun);
            let length = self.rest.get(kind..kind + 4)?;
            let length = kind + u32::from_be_bytes(length.try_into().ok()?) as usize;
            if self.rest.len() < length {
                return None;
            }
            let message: Vec<u8> = self.rest.drain(..length).collect();
            if self.begun {
                return Some(message);
            }
            self.begun = true;
        }
    }
}

fn is_commit(text: &[u8]) -> bool {
    text.trim_ascii().eq_ignore_ascii_case(b"COMMIT")
}

#[test]
fn commits_are_seen_however_they_are_sent() {
    let message = |kind: u8, body: &[u8]| {
        let length = (body.len() as u32 + 4).to_be_bytes();
        [&[kind], length.as_slice(), body].concat()
    };
    let mut commits = Commits::default();
    assert!(!commits.passes(&[0, 0, 0, 9, 0, 3, 0, 0, 0]));
    assert!(!commits.passes(&message(b'Q', b"BEGIN; SELECT 'COMMIT'\0")));
    assert!(commits.passes(&message(b'Q', b"COMMIT\0")));
    assert!(!commits.passes(&message(b'P', b"s1\0SELECT 1\0\0\0")));
    assert!(!commits.passes(&message(b'P', b"s2\0COMMIT\0\0\0")));
    assert!(!commits.passes(&message(b'B', b"\0s1\0\0\0\0\0\0\0")));
    let bind = message(b'B', b"\0s2\0\0\0\0\0\0\0");
    assert!(!commits.passes(&bind[..7]));
    assert!(commits.passes(&bind[7..]));
}
