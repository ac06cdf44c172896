//! Clients that send and read slowly, and many large bodies at once: whoever else asks is served
//! meanwhile.

use std::time::{Duration, Instant};

use tokio::{
    io::{AsyncReadExt, AsyncWriteExt},
    net::{TcpSocket, TcpStream},
    sync::watch,
    task::JoinSet,
    time::sleep,
};

use crate::harness::{CURVE, TestApp};

/// Sends a text byte by byte until the server has enough of it; when that was, and what it said.
async fn dripped(app: &TestApp, begun: &str, pause: Duration) -> (Duration, String) {
    let (mut stream, from) = (TcpStream::connect(app.address).await.unwrap(), Instant::now());
    stream.write_all(begun.as_bytes()).await.unwrap();
    let (mut reading, mut writing) = stream.split();
    let mut said = Vec::new();
    let read = async { reading.read_to_end(&mut said).await };
    let drip = async {
        loop {
            sleep(pause).await;
            if writing.write_all(b"a").await.is_err() {
                // what was said is still to be read
                std::future::pending::<()>().await;
            }
        }
    };
    tokio::select! {
        _ = read => {}
        _ = drip => {}
    }
    (from.elapsed(), String::from_utf8_lossy(&said).into_owned())
}

/// A head that never ends holds its connection ten seconds, however steadily it comes.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_head_that_drips_is_given_up() {
    let app = TestApp::start().await;
    let heads = ["", "GET /healthz HTTP/1.1\r\nHost: [::1]\r\nx-long: "];
    let drips = (0..24).map(|k| dripped(&app, heads[k % 2], Duration::from_millis(100)));
    let dripping = futures_util::future::join_all(drips);
    let honest = async {
        let mut slowest = Duration::ZERO;
        for _ in 0..20 {
            let begun = Instant::now();
            assert_eq!(app.fit(CURVE).await.status, 200);
            slowest = slowest.max(begun.elapsed());
            sleep(Duration::from_millis(200)).await;
        }
        slowest
    };
    let (ended, slowest) = tokio::join!(dripping, honest);
    for (lasted, said) in ended {
        assert!(lasted < Duration::from_secs(25), "{lasted:?}");
        assert!(said.is_empty() || said.starts_with("HTTP/1.1 4"), "{said}");
    }
    assert!(slowest < Duration::from_secs(5), "{slowest:?}");
    app.stop().await;
}

/// A body has its time as a whole: one that comes drop by drop is 408 then.
#[tokio::test]
async fn a_body_that_drips_is_408() {
    let app = TestApp::start_with(|settings| settings.body_timeout = 2).await;
    let head =
        "POST /v1/fits HTTP/1.1\r\nHost: [::1]\r\nContent-Type: application/json\r\nContent-Length: 9000\r\n\r\n{";
    let (lasted, said) = dripped(&app, head, Duration::from_millis(50)).await;
    assert!(said.starts_with("HTTP/1.1 408 ") && said.contains("\"body_timeout\""), "{said}");
    assert!((Duration::from_secs(2)..Duration::from_secs(15)).contains(&lasted), "{lasted:?}");
    while app.state.budget.held() > 0 {
        sleep(Duration::from_millis(1)).await;
    }
    app.stop().await;
}

/// Who reads slowly, but reads, has the whole answer, and holds no worker meanwhile.
#[tokio::test]
async fn a_slow_reader_has_the_whole_answer() {
    let app = TestApp::start_with(|settings| settings.workers = 1).await;
    let points = "[[[0,0,0],[0,1,1],[0,2,0]],[[1,0,1],[1,1,3],[1,2,1]],[[2,0,0],[2,1,1],[2,2,0]]]";
    let surface = format!(r#"{{"type":"bezier","control_points":{points}}}"#);
    let body = format!(r#"{{"surface":{surface},"format":"stl_text","samples":[120,120]}}"#);
    let socket = TcpSocket::new_v4().unwrap();
    socket.set_recv_buffer_size(16 << 10).unwrap();
    let mut stream = socket.connect(app.address).await.unwrap();
    let head = "Host: localhost\r\nConnection: close\r\nContent-Type: application/json\r\n";
    let request = format!("POST /v1/surfaces/export HTTP/1.1\r\n{head}Content-Length: {}\r\n\r\n{body}", body.len());
    stream.write_all(request.as_bytes()).await.unwrap();
    let (begun, mut whole, mut piece) = (Instant::now(), Vec::new(), vec![0; 128 << 10]);
    loop {
        match stream.read(&mut piece).await.expect("it is not let go") {
            0 => break,
            read => whole.extend_from_slice(&piece[..read]),
        }
        if begun.elapsed() < Duration::from_secs(5) {
            sleep(Duration::from_millis(250)).await;
            assert_eq!(app.fit(CURVE).await.status, 200);
        }
    }
    assert!(begun.elapsed() > Duration::from_secs(4), "{:?}", begun.elapsed());
    let whole = String::from_utf8(whole).unwrap();
    assert!(whole.contains("endsolid surface") && whole.ends_with("\r\n0\r\n\r\n"), "{} bytes", whole.len());
    app.stop().await;
}

/// With many large bodies at once some are accepted, the others refused at once, and never more is
/// held than allowed.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn large_bodies_at_once_stay_within_the_bound() {
    const BOUND: usize = 1 << 20;
    let app = TestApp::start_with(|settings| settings.body_memory = BOUND).await;
    let (blank, address) = (400_000, app.address);
    for _ in 0..3 {
        let (mut clients, length) = (JoinSet::new(), blank + CURVE.len());
        let (gate, opened) = watch::channel(false);
        for _ in 0..16 {
            let mut opened = opened.clone();
            clients.spawn(async move {
                let mut stream = TcpStream::connect(address).await.unwrap();
                let head = "Host: [::1]\r\nConnection: close\r\nContent-Type: application/json\r\n";
                let head = format!("POST /v1/fits HTTP/1.1\r\n{head}Content-Length: {length}\r\n\r\n");
                stream.write_all(head.as_bytes()).await.unwrap();
                stream.write_all(&vec![b' '; blank]).await.unwrap_or_default();
                // none is whole before others are refused, which they are without their rest
                let mut said = Vec::new();
                let refused = tokio::select! {
                    _ended = stream.read_to_end(&mut said) => true,
                    _opened = opened.wait_for(|is_open| *is_open) => false,
                };
                if !refused {
                    stream.write_all(CURVE.as_bytes()).await.unwrap_or_default();
                    let _ended = stream.read_to_end(&mut said).await;
                }
                String::from_utf8_lossy(&said).to_ascii_lowercase()
            });
        }
        let (mut most, mut taken, mut refused) = (0, 0, 0);
        while !clients.is_empty() {
            most = most.max(app.state.budget.held());
            if refused >= 4 && most >= blank {
                gate.send_replace(true);
            }
            tokio::select! {
                said = clients.join_next() => {
                    let said = said.unwrap().unwrap();
                    match said.split(' ').nth(1) {
                        Some("200") => taken += 1,
                        Some("503") => {
                            assert!(said.contains("\"overloaded\"") && said.contains("retry-after: 1"), "{said}");
                            refused += 1;
                        }
                        _ => panic!("{said}"),
                    }
                }
                () = sleep(Duration::from_millis(1)) => {}
            }
        }
        assert!(taken >= 1 && refused >= 4, "{taken} were taken, {refused} refused");
        // those that are refused at the same moment may leave memory for one alone
        assert!((blank..=BOUND).contains(&most), "{most} bytes were held");
        while app.state.budget.held() > 0 {
            sleep(Duration::from_millis(1)).await;
        }
    }
    assert_eq!(app.fit(CURVE).await.status, 200);
    app.stop().await;
}
