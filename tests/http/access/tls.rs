//! The service over TLS, with clients of another hand than the server's own.

use std::{
    fs,
    io::Write as _,
    net::SocketAddr,
    path::PathBuf,
    process::{Command, Stdio},
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use flankfit::{
    config::{Authentication, ClientAuthentication, ServeSettings},
    jobs::{Caller, Clock, KeyDraft, Role, San, SystemClock, Tenant},
};
use jiff::Timestamp;
use rcgen::{BasicConstraints, CertificateParams, CertifiedIssuer, DnType, IsCa, KeyPair, SanType};
use tokio::{
    io::{AsyncReadExt, AsyncWriteExt},
    net::TcpStream,
    task::{JoinSet, spawn_blocking},
};
use tokio_rustls::{
    TlsConnector,
    client::TlsStream,
    rustls::{
        ClientConfig, ProtocolVersion, RootCertStore, SupportedProtocolVersion,
        crypto::aws_lc_rs::default_provider,
        pki_types::{CertificateDer, PrivateKeyDer, ServerName},
        version::{TLS12, TLS13},
    },
};

use super::talkative::Talkative;
use crate::harness::{CURVE, TestApp, figure};

/// One that signs certificates, and the files of a server.
pub struct Authority {
    issuer: CertifiedIssuer<'static, KeyPair>,
    directory: tempfile::TempDir,
}

/// Certificate and key.
struct Pair {
    certificate: rcgen::Certificate,
    key: KeyPair,
}

impl Authority {
    pub fn new() -> Self {
        // of another name than what it signs, which would seem to be signed by itself
        Self::named("authority of the tests")
    }

    fn named(name: &str) -> Self {
        let mut params = CertificateParams::new(Vec::<String>::new()).unwrap();
        params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
        params.distinguished_name.push(DnType::CommonName, name);
        let issuer = CertifiedIssuer::self_signed(params, KeyPair::generate().unwrap()).unwrap();
        let authority = Authority { issuer, directory: tempfile::tempdir().unwrap() };
        fs::write(authority.file("ca.pem"), authority.issuer.pem()).unwrap();
        authority.install(&authority.sign("localhost"));
        authority
    }

    pub fn file(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    fn sign(&self, name: &str) -> Pair {
        self.signed(CertificateParams::new([name.to_owned()]).unwrap())
    }

    /// Until the first day of a year.
    fn sign_until(&self, name: &str, year: i32) -> Pair {
        let mut params = CertificateParams::new([name.to_owned()]).unwrap();
        params.not_after = rcgen::date_time_ymd(year, 1, 1);
        self.signed(params)
    }

    /// For one that is named by a URI, as workloads are.
    fn sign_uri(&self, uri: &str) -> Pair {
        let mut params = CertificateParams::new(Vec::<String>::new()).unwrap();
        params.subject_alt_names.push(SanType::URI(uri.try_into().unwrap()));
        self.signed(params)
    }

    fn signed(&self, params: CertificateParams) -> Pair {
        let key = KeyPair::generate().unwrap();
        let certificate = params.signed_by(&key, &self.issuer).unwrap();
        Pair { certificate, key }
    }

    /// Gives the server another pair.
    fn install(&self, pair: &Pair) {
        fs::write(self.file("cert.pem"), pair.certificate.pem()).unwrap();
        fs::write(self.file("key.pem"), pair.key.serialize_pem()).unwrap();
    }

    pub fn serve(&self, settings: &mut ServeSettings) {
        settings.tls.certificate = Some(self.file("cert.pem"));
        settings.tls.key = Some(self.file("key.pem"));
    }

    /// A client that trusts this authority.
    fn client(&self, versions: &[&'static SupportedProtocolVersion], own: Option<&Pair>) -> TlsConnector {
        let mut roots = RootCertStore::empty();
        roots.add(self.issuer.der().clone()).unwrap();
        let builder = ClientConfig::builder_with_provider(Arc::new(default_provider()));
        let builder = builder.with_protocol_versions(versions).unwrap().with_root_certificates(roots);
        let mut config = match own {
            None => builder.with_no_client_auth(),
            Some(pair) => {
                let key = PrivateKeyDer::try_from(pair.key.serialize_der()).unwrap();
                builder.with_client_auth_cert(vec![pair.certificate.der().clone()], key).unwrap()
            }
        };
        config.alpn_protocols = vec![b"h2".to_vec(), b"http/1.1".to_vec()];
        TlsConnector::from(Arc::new(config))
    }
}

async fn connect(client: &TlsConnector, address: SocketAddr) -> std::io::Result<TlsStream<TcpStream>> {
    let stream = TcpStream::connect(address).await?;
    client.connect(ServerName::try_from("localhost").unwrap(), stream).await
}

async fn ask(stream: &mut TlsStream<TcpStream>, request: &str) -> std::io::Result<String> {
    stream.write_all(request.as_bytes()).await?;
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).await?;
    Ok(String::from_utf8_lossy(&answer).into_owned())
}

const HEALTH: &str = "GET /healthz HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n";
const METRICS: &str = "GET /metrics HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n";

#[tokio::test]
async fn fits_are_the_same_over_both_versions_of_tls() {
    let authority = Authority::new();
    let plain = TestApp::start().await.fit(CURVE).await;
    let app = TestApp::start_with(|settings| authority.serve(settings)).await;
    let request = format!(
        "POST /v1/fits HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\ncontent-length: {}\r\n\
         connection: close\r\n\r\n{CURVE}",
        CURVE.len()
    );
    for (version, named) in [(&TLS12, ProtocolVersion::TLSv1_2), (&TLS13, ProtocolVersion::TLSv1_3)] {
        let mut stream = connect(&authority.client(&[version], None), app.address).await.unwrap();
        let (_, session) = stream.get_ref();
        assert_eq!(session.protocol_version(), Some(named));
        assert_eq!(session.alpn_protocol(), Some(&b"http/1.1"[..]));
        let answer = ask(&mut stream, &request).await.unwrap();
        assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
        assert!(answer.contains("strict-transport-security: max-age=31536000"), "{answer}");
        assert!(answer.ends_with(&plain.text), "{answer}");
    }
}

#[tokio::test]
async fn clients_without_tls_get_no_response() {
    let authority = Authority::new();
    let app = TestApp::start_with(|settings| authority.serve(settings)).await;
    let mut stream = TcpStream::connect(app.address).await.unwrap();
    stream.write_all(HEALTH.as_bytes()).await.unwrap();
    let mut answer = Vec::new();
    let _closed_or_reset = stream.read_to_end(&mut answer).await;
    assert!(!answer.starts_with(b"HTTP"), "{answer:?}");
}

#[tokio::test]
async fn clients_show_certificates_of_the_named_authorities() {
    let (authority, stranger) = (Authority::new(), Authority::new());
    let status = async |asked: ClientAuthentication, own: Option<&Pair>| {
        let app = TestApp::start_with(|settings| {
            authority.serve(settings);
            settings.tls.client_authorities = Some(authority.file("ca.pem"));
            settings.tls.client_authentication = asked;
        })
        .await;
        // with TLS 1.3 the refusal comes when something is read
        let client = authority.client(&[&TLS13], own);
        let answer = async { ask(&mut connect(&client, app.address).await?, HEALTH).await };
        answer.await.is_ok_and(|answer| answer.starts_with("HTTP/1.1 200"))
    };
    let (good, bad) = (authority.sign("cell-7.example"), stranger.sign("cell-7.example"));
    assert!(status(ClientAuthentication::Required, Some(&good)).await);
    assert!(!status(ClientAuthentication::Required, Some(&bad)).await);
    assert!(!status(ClientAuthentication::Required, None).await);
    assert!(status(ClientAuthentication::Optional, None).await);
    assert!(status(ClientAuthentication::Optional, Some(&good)).await);
    assert!(!status(ClientAuthentication::Optional, Some(&bad)).await);
}

#[tokio::test]
async fn a_new_certificate_is_taken_without_losing_a_request() {
    let authority = Authority::new();
    let app = TestApp::start_with(|settings| authority.serve(settings)).await;
    let client = authority.client(&[&TLS13], None);
    let shown = async || {
        let mut stream = connect(&client, app.address).await.unwrap();
        let certificate: CertificateDer = stream.get_ref().1.peer_certificates().unwrap()[0].clone().into_owned();
        assert!(ask(&mut stream, HEALTH).await.unwrap().starts_with("HTTP/1.1 200"));
        certificate
    };
    let first = shown().await;
    // half of a pair is not used
    let next = authority.sign("localhost");
    fs::write(authority.file("cert.pem"), next.certificate.pem()).unwrap();
    for _ in 0..20 {
        assert_eq!(shown().await, first);
    }
    authority.install(&next);
    while shown().await == first {}
    assert_eq!(shown().await, *next.certificate.der());
}

/// Time left of the certificate in use, a new one included. (A process of its own: servers of one
/// process share their metrics.)
#[tokio::test]
async fn the_time_to_expiry_of_the_certificate_is_a_metric() {
    let authority = Authority::new();
    let [certificate, key] = ["cert.pem", "key.pem"].map(|name| authority.file(name).display().to_string());
    let client = authority.client(&[&TLS13], None);
    let mut server = None;
    for year in [2090, 2100] {
        let begun = SystemClock.now().as_second();
        authority.install(&authority.sign_until("localhost", year));
        let ends = format!("{year}-01-01T00:00:00Z").parse::<Timestamp>().unwrap().as_second();
        let server = server.get_or_insert_with(|| {
            Talkative::start(&authority.file("test.db"), &["--tls-cert", &certificate, "--tls-key", &key])
        });
        let address = server.base.trim_start_matches("http://").parse().unwrap();
        loop {
            let answer = ask(&mut connect(&client, address).await.unwrap(), METRICS).await.unwrap();
            let left = figure(&answer, "flankfit_tls_expiry_seconds");
            let now = SystemClock.now().as_second();
            // it is updated every five seconds
            if left.is_some_and(|left| ((ends - now) as f64..=(ends - begun) as f64).contains(&left)) {
                break;
            }
            assert!(now - begun < 60, "{left:?} of {} s", ends - now);
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
    }
}

/// Certificate that the server shows, on a connection that is then used.
async fn shown_to(client: &TlsConnector, address: SocketAddr) -> CertificateDer<'static> {
    let mut stream = connect(client, address).await.unwrap();
    let certificate = stream.get_ref().1.peer_certificates().unwrap()[0].clone().into_owned();
    let answer = ask(&mut stream, HEALTH).await.unwrap();
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    certificate
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn certificates_change_under_load_and_no_client_fails() {
    let authority = Authority::new();
    let app = TestApp::start_with(|settings| authority.serve(settings)).await;
    let over = Arc::<AtomicBool>::default();
    // how often each client has asked, and what it was shown
    type Seen = (u32, Vec<CertificateDer<'static>>);
    let seen = Arc::new(Mutex::new(vec![Seen::default(); 8]));
    let mut load = JoinSet::new();
    for number in 0..8 {
        let version = if number % 2 == 0 { &TLS12 } else { &TLS13 };
        let (client, address, over) = (authority.client(&[version], None), app.address, over.clone());
        let seen = seen.clone();
        load.spawn(async move {
            while !over.load(Ordering::SeqCst) {
                let certificate = shown_to(&client, address).await;
                let (asked, shown) = &mut seen.lock().unwrap()[number];
                if shown.last() != Some(&certificate) {
                    shown.push(certificate);
                }
                *asked += 1;
            }
        });
    }
    // a client that fails is a panic here
    let all_have = async |load: &mut JoinSet<()>, wanted: &dyn Fn(&Seen) -> bool| {
        let begun = Instant::now();
        while !seen.lock().unwrap().iter().all(wanted) {
            if let Some(ended) = load.try_join_next() {
                ended.unwrap();
            }
            assert!(begun.elapsed() < Duration::from_secs(120), "a client does not come again");
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    };
    let client = authority.client(&[&TLS13], None);
    let mut installed = vec![shown_to(&client, app.address).await];
    all_have(&mut load, &|(_, shown)| shown.last() == installed.last()).await;
    for _ in 0..2 {
        let next = authority.sign("localhost");
        authority.install(&next);
        while shown_to(&client, app.address).await != *next.certificate.der() {}
        installed.push(next.certificate.der().clone());
        all_have(&mut load, &|(_, shown)| shown.last() == installed.last()).await;
    }
    all_have(&mut load, &|(asked, _)| *asked > 10).await;
    over.store(true, Ordering::SeqCst);
    load.join_all().await;
    // each was shown all certificates, in order
    for (asked, shown) in &*seen.lock().unwrap() {
        assert!(*asked > 10, "{asked}");
        assert!(*shown == installed, "{} certificates were shown", shown.len());
    }
}

/// The client of another project: old versions are refused by the server, with an alert, and the
/// protocol above is agreed upon.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_openssl, ignore = "openssl is not installed")]
async fn openssl_agrees_on_new_versions_alone() {
    let authority = Authority::new();
    let app = TestApp::start_with(|settings| authority.serve(settings)).await;
    let connected = async |version: &'static str, protocols: &'static str| {
        let mut command = Command::new("openssl");
        command
            .args(["s_client", "-connect", &app.address.to_string(), "-servername", "localhost", "-CAfile"])
            .arg(authority.file("ca.pem"))
            // a client that would take old versions, whatever the system's settings are
            .args(["-verify_return_error", "-cipher", "DEFAULT:@SECLEVEL=0", "-alpn", protocols, version])
            .env("OPENSSL_CONF", "/dev/null")
            .stdin(Stdio::null());
        let done = spawn_blocking(move || command.output()).await.unwrap().unwrap();
        let said = String::from_utf8_lossy(&done.stdout) + String::from_utf8_lossy(&done.stderr);
        (done.status.success(), said.into_owned())
    };
    for version in ["-tls1", "-tls1_1"] {
        let (done, said) = connected(version, "http/1.1").await;
        assert!(!done && said.contains("SSL alert number") && said.contains("Cipher is (NONE)"), "{version}: {said}");
    }
    for (version, named) in [("-tls1_2", "TLSv1.2"), ("-tls1_3", "TLSv1.3")] {
        let (done, said) = connected(version, "h2,http/1.1").await;
        assert!(done && said.contains(&format!("New, {named}, Cipher is ")), "{said}");
        assert!(said.contains("ALPN protocol: http/1.1") && said.contains("Verify return code: 0 (ok)"), "{said}");
        // and a client that speaks nothing else is refused
        let (done, said) = connected(version, "h2").await;
        assert!(!done && said.contains("SSL alert number 120"), "{said}");
    }
}

/// The alerts are those of RFC 8446, 6.2, with TLS 1.2 as well.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_openssl, ignore = "openssl is not installed")]
async fn openssl_gets_the_alert_for_its_certificate() {
    let (authority, namesake, stranger) = (Authority::new(), Authority::new(), Authority::named("stranger"));
    let app = TestApp::start_with(|settings| {
        authority.serve(settings);
        settings.tls.client_authorities = Some(authority.file("ca.pem"));
        settings.tls.client_authentication = ClientAuthentication::Required;
    })
    .await;
    let cases = [
        ("known", Some(&authority), None),
        // the name of its issuer is known, but not that issuer's signature
        ("namesake", Some(&namesake), Some("SSL alert number 51")),
        ("stranger", Some(&stranger), Some("SSL alert number 48")),
        ("none", None, Some("SSL alert number 116")),
    ];
    for (name, issuer, alert) in cases {
        let [certificate, key] = ["pem", "key"].map(|end| authority.file(&format!("{name}.{end}")));
        if let Some(issuer) = issuer {
            let own = issuer.sign("cell-7.example");
            fs::write(&certificate, own.certificate.pem()).unwrap();
            fs::write(&key, own.key.serialize_pem()).unwrap();
        }
        for version in ["-tls1_2", "-tls1_3"] {
            let mut command = Command::new("openssl");
            command
                .args(["s_client", "-connect", &app.address.to_string(), "-servername", "localhost", "-CAfile"])
                .arg(authority.file("ca.pem"))
                .args(["-verify_return_error", "-ign_eof", version])
                .env("OPENSSL_CONF", "/dev/null")
                .stdin(Stdio::piped())
                .stdout(Stdio::piped())
                .stderr(Stdio::piped());
            if issuer.is_some() {
                command.arg("-cert").arg(&certificate).arg("-key").arg(&key);
            }
            let mut child = command.spawn().unwrap();
            // open until it has ended by itself; with nothing written, the alert is what it reads
            let mut input = child.stdin.take().unwrap();
            if alert.is_none() {
                input.write_all(HEALTH.as_bytes()).unwrap();
            }
            let done = spawn_blocking(move || child.wait_with_output()).await.unwrap().unwrap();
            drop(input);
            let said = String::from_utf8_lossy(&done.stdout) + String::from_utf8_lossy(&done.stderr);
            match alert {
                None => assert!(done.status.success() && said.contains("HTTP/1.1 200"), "{name} {version}: {said}"),
                Some(alert) => {
                    assert!(!done.status.success() && said.contains(alert), "{name} {version}: {said}");
                    assert!(!said.contains("HTTP/1.1"), "{name} {version}: {said}");
                }
            }
        }
    }
}

#[tokio::test]
async fn stalled_handshakes_are_in_nobodys_way_and_end() {
    let authority = Authority::new();
    let app = TestApp::start_with(|settings| authority.serve(settings)).await;
    let mut stalled = Vec::new();
    let begun = Instant::now();
    for _ in 0..50 {
        stalled.push(TcpStream::connect(app.address).await.unwrap());
    }
    let client = authority.client(&[&TLS12, &TLS13], None);
    let mut stream = connect(&client, app.address).await.unwrap();
    assert!(ask(&mut stream, HEALTH).await.unwrap().starts_with("HTTP/1.1 200"));
    for mut stream in stalled {
        let mut byte = [0];
        let ended = tokio::time::timeout(Duration::from_secs(60), stream.read(&mut byte)).await;
        assert!(matches!(ended, Ok(Ok(0) | Err(_))), "{ended:?}");
        // each has ten seconds, with the delays of a busy machine
        assert!((9..25).contains(&begun.elapsed().as_secs()), "{:?}", begun.elapsed());
    }
}

/// Who comes with a certificate needs no other key: the name in it is one.
#[tokio::test]
async fn a_certificate_is_a_key() {
    let authority = Authority::new();
    let app = TestApp::start_with(|settings| {
        authority.serve(settings);
        settings.tls.client_authorities = Some(authority.file("ca.pem"));
        settings.tls.client_authentication = ClientAuthentication::Optional;
        settings.auth = Authentication::Required;
    })
    .await;
    let hosts = ["cell-7.example", "cell-8.example"].map(|name| authority.sign(name));
    let workloads = ["spiffe://plant-7/cell/7", "spiffe://plant-7/cell/8"].map(|uri| authority.sign_uri(uri));
    let keys =
        app.state.jobs.keys_of(&Caller { tenant: Tenant::default(), actor: "test".into(), origin: Default::default() });
    let whoami = async |own: Option<&Pair>, more: &str| {
        let client = authority.client(&[&TLS13], own);
        let request = format!("GET /v1/whoami HTTP/1.1\r\nhost: localhost\r\n{more}connection: close\r\n\r\n");
        ask(&mut connect(&client, app.address).await.unwrap(), &request).await.unwrap()
    };
    for (name, [known, unknown]) in [("Cell-7.example", hosts), ("spiffe://plant-7/cell/7", workloads)] {
        let draft = KeyDraft {
            name: name.to_owned(),
            role: Some(Role::Reader),
            scopes: Role::Reader.scopes(),
            expires_at: None,
            san: San::named(name),
        };
        let (key, secret) = keys.create(draft, None).await.unwrap();
        assert!(secret.is_none());
        let response = whoami(Some(&known), "").await;
        assert!(response.starts_with("HTTP/1.1 200") && response.contains(&format!("key-{}", key.id)), "{response}");
        assert!(response.contains(r#""role":"reader""#), "{response}");
        for (own, more, code) in [
            (Some(&unknown), "", "unauthorized"),
            (None, "", "unauthorized"),
            // a key that is sent is what counts
            (Some(&known), "x-api-key: wrong\r\n", "invalid_key"),
        ] {
            let response = whoami(own, more).await;
            assert!(response.starts_with("HTTP/1.1 401") && response.contains(code), "{response}");
        }
        keys.revoke(key.id).await.unwrap();
        let response = whoami(Some(&known), "").await;
        assert!(response.starts_with("HTTP/1.1 401") && response.contains("invalid_key"), "{response}");
    }
}
