//! Blocks and responses over a WebSocket.

use futures_util::{SinkExt, StreamExt};
use reqwest::Method;
use serde_json::{Value, json};
use tokio_tungstenite::{
    MaybeTlsStream, WebSocketStream, connect_async,
    tungstenite::{
        Error, Message, client::IntoClientRequest, protocol::CloseFrame, protocol::frame::coding::CloseCode,
    },
};

use super::{
    app::{TestApp, send},
    streams::{block, spec},
};

pub type Socket = WebSocketStream<MaybeTlsStream<tokio::net::TcpStream>>;

async fn open(app: &TestApp, stream: &str) -> Socket {
    connect(&app.base, stream).await
}

pub async fn connect(base: &str, stream: &str) -> Socket {
    let url = format!("{}{stream}/ws", base.replace("http://", "ws://"));
    connect_async(url).await.expect("a WebSocket").0
}

/// The same with a key.
pub async fn connect_with(base: &str, stream: &str, key: &str) -> Socket {
    let mut request = format!("{}{stream}/ws", base.replace("http://", "ws://")).into_client_request().unwrap();
    request.headers_mut().insert("authorization", format!("Bearer {key}").parse().unwrap());
    connect_async(request).await.expect("a WebSocket").0
}

async fn ask(socket: &mut Socket, message: &Value) -> (String, Value) {
    socket.send(Message::text(message.to_string())).await.unwrap();
    loop {
        if let Message::Text(text) = socket.next().await.expect("an answer").expect("a message") {
            return (text.to_string(), serde_json::from_str(&text).unwrap());
        }
    }
}

/// Code with which the server closes.
pub async fn close(socket: &mut Socket) -> Option<CloseCode> {
    loop {
        match socket.next().await? {
            Ok(Message::Close(frame)) => return frame.map(|frame| frame.code),
            Ok(_) => {}
            Err(_) => return None,
        }
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn socket_messages_get_the_responses_of_requests() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let (one, two) = (app.stream(&job, &spec()).await, app.stream(&job, &spec()).await);
    let mut socket = open(&app, &one).await;
    for sequence in 1..=15u64 {
        let message = block(sequence, sequence as usize - 1..sequence as usize);
        let (text, answer) = ask(&mut socket, &message).await;
        let by_request = app.post(&format!("{two}/nodes"), &message).await.expect(200);
        assert_eq!((text, answer["node_count"].as_u64()), (by_request.text, Some(sequence)));
        assert_eq!(answer.get("result").is_some(), sequence >= 9);
    }
    // refusals are problems, and the connection goes on
    let (_, gap) = ask(&mut socket, &block(20, 0..1)).await;
    assert_eq!((gap["code"].as_str(), gap["status"].as_u64()), (Some("conflict"), Some(409)));
    let (_, faulty) = ask(&mut socket, &json!({"sequence": 16})).await;
    assert_eq!(
        (faulty["code"].as_str(), faulty["errors"][0]["pointer"].as_str()),
        (Some("invalid_request"), Some("/nodes"))
    );
    socket.send(Message::text("{")).await.unwrap();
    let Some(Ok(Message::Text(text))) = socket.next().await else { panic!("a problem") };
    assert!(text.contains("malformed_body"), "{text}");
    let (_, again) = ask(&mut socket, &block(15, 14..15)).await;
    assert_eq!(again["node_count"], 15);
    socket.send(Message::binary(block(16, 15..16).to_string())).await.unwrap();
    assert!(matches!(socket.next().await, Some(Ok(Message::Text(_)))));

    send(app.request(Method::POST, &format!("{one}/finish"))).await.expect(201);
    assert_eq!(close(&mut socket).await, Some(CloseCode::Normal));
    let mut other = open(&app, &two).await;
    app.delete(&two).await.expect(204);
    assert_eq!(close(&mut other).await, Some(CloseCode::Normal));

    for (path, status) in [(one.as_str(), 409), (two.as_str(), 404)] {
        let url = format!("{}{path}/ws", app.base.replace("http://", "ws://"));
        let Err(Error::Http(response)) = connect_async(url).await else { panic!("no WebSocket") };
        assert_eq!(response.status(), status);
    }
    let three = app.stream(&job, &spec()).await;
    app.get(&format!("{three}/ws")).await.problem(400, "malformed_request");
    let mut last = open(&app, &three).await;
    app.stop().await;
    assert_eq!(close(&mut last).await, Some(CloseCode::Away));
}

/// Browsers open WebSockets to anywhere: a page of another origin is refused, unless its origin was
/// named. A close is confirmed.
#[tokio::test]
async fn pages_of_other_origins_do_not_connect() {
    let named = |settings: &mut flankfit::config::ServeSettings| {
        settings.cors_origins = flankfit::config::parse_origins("https://cell.example").unwrap();
    };
    let app = TestApp::around(crate::harness::TestApp::start_with(named).await);
    let job = app.job().await;
    let stream = app.stream(&job, &spec()).await;
    let url = format!("{}{stream}/ws", app.base.replace("http://", "ws://"));
    let from = |origin: &str| {
        let mut request = url.as_str().into_client_request().unwrap();
        request.headers_mut().insert("origin", origin.parse().unwrap());
        connect_async(request)
    };
    for origin in ["https://evil.example", "null", "https://cell.example.evil"] {
        let Err(Error::Http(response)) = from(origin).await else { panic!("{origin} is let in") };
        assert_eq!(response.status(), 403);
    }
    for origin in ["https://cell.example", app.base.as_str()] {
        let mut socket = from(origin).await.expect(origin).0;
        socket.close(Some(CloseFrame { code: CloseCode::Normal, reason: "done".into() })).await.unwrap();
        assert_eq!(close(&mut socket).await, Some(CloseCode::Normal));
    }
}
