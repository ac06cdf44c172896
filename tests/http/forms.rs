//! Node sets as `multipart/form-data`.

use reqwest::multipart::{Form, Part};
use serde_json::Value;

use crate::harness::{Answer, CURVE, TestApp, send};

const SPEC: &str = r#"{"model":{"type":"polynomial","degree":1}}"#;

fn part(text: &str, media: &str) -> Part {
    Part::text(text.to_owned()).mime_str(media).unwrap()
}

async fn post(app: &TestApp, form: Form) -> Answer {
    send(app.client.post(app.url("/v1/fits")).multipart(form)).await
}

async fn post_table(app: &TestApp, table: &str) -> Answer {
    post(app, Form::new().part("spec", part(SPEC, "application/json")).part("nodes", part(table, "text/csv"))).await
}

#[tokio::test]
async fn a_table_gives_the_same_answer_as_json() {
    let app = TestApp::start().await;
    let answer = post_table(&app, "x,y\n0,1\n1,3.1\n2,4.9\n3,7.2\n").await;
    assert_eq!((answer.status.as_u16(), &answer.text), (200, &app.fit(CURVE).await.text));
    let without_types = Form::new().text("nodes", "x,y\n0,1\n1,3.1\n2,4.9\n3,7.2").text("spec", SPEC);
    assert_eq!(post(&app, without_types).await.text, answer.text);
}

#[tokio::test]
async fn an_empty_height_is_a_missing_node() {
    let app = TestApp::start().await;
    let answer = post_table(&app, "u,v,z,weight\n0,0,1,1\n0,1,2,1\n1,0,3,1\n1,1,,1\n1,2,4.5,2\n2,2,5,0.5\n").await;
    assert_eq!(answer.status, 200, "{}", answer.text);
    let body: Value = answer.json();
    assert_eq!(body["residuals"]["count"], 5);
}

#[tokio::test]
async fn bad_cells_have_line_and_column() {
    let app = TestApp::start().await;
    let answer = post_table(&app, "x,y\n0,1\n1,2_5\n2,n/a\n3,4\n4,5\n").await;
    assert_eq!(answer.pointers(), ["/nodes"; 3]);
    assert!(answer.text.contains("2 cells are not finite numbers"), "{}", answer.text);
    assert!(answer.text.contains("line 3, column 2 (y): `2_5`"), "{}", answer.text);
    // what is no number in JSON is none in a table
    let json = r#"{"nodes":{"type":"curve","x":[0,1],"y":[1,NaN]},"model":{"type":"polynomial","degree":1}}"#;
    for answer in [post_table(&app, "x,y\n0,1\n1,NaN\n").await, app.fit(json).await] {
        let problem = answer.problem(400, "malformed_body");
        assert!(problem["detail"].as_str().unwrap().contains("NaN and Infinity"), "{problem}");
    }
    assert_eq!(post_table(&app, "roll length,b,c\n1,2,3\n").await.pointers(), ["/nodes"]);
    assert_eq!(post_table(&app, "").await.pointers(), ["/nodes"]);
}

#[tokio::test]
async fn the_spec_is_checked_as_elsewhere() {
    let app = TestApp::start().await;
    let form = |spec: &str| Form::new().text("spec", spec.to_owned()).text("nodes", "x,y\n0,1\n1,2\n2,4\n");
    let both = r#"{"nodes":{"type":"curve","x":[1],"y":[1]},"model":{"type":"polynomial","degree":1}}"#;
    assert_eq!(post(&app, form(both)).await.pointers(), ["/nodes"]);
    assert_eq!(post(&app, form("{}")).await.pointers(), ["/model"]);
    post(&app, form("{")).await.problem(400, "malformed_body");
}

/// `curl -F spec=@spec.json -F nodes=@nodes.csv`: curl knows neither extension.
#[tokio::test]
async fn parts_of_an_unknown_type_are_read() {
    let app = TestApp::start().await;
    let unknown = |text: &str| part(text, "application/octet-stream");
    let form = Form::new().part("spec", unknown(SPEC)).part("nodes", unknown("x,y\n0,1\n1,2\n2,4\n"));
    let answer = post(&app, form).await;
    assert_eq!(answer.status, 200, "{}", answer.text);
    let form = Form::new().part("spec", unknown(SPEC)).part("nodes", unknown("\u{0}\u{1}"));
    assert!(post(&app, form).await.status.is_client_error());
}

#[tokio::test]
async fn broken_forms_are_refused() {
    let app = TestApp::start().await;
    post(&app, Form::new().text("spec", SPEC)).await.problem(400, "malformed_body");
    post(&app, Form::new().text("nodes", "x,y\n1,2")).await.problem(400, "malformed_body");
    let more = Form::new().text("spec", SPEC).text("nodes", "x,y\n1,2").text("more", "1");
    post(&app, more).await.problem(400, "malformed_body");
    let twice = Form::new().text("spec", SPEC).text("nodes", "x,y\n1,2").text("spec", SPEC);
    post(&app, twice).await.problem(400, "malformed_body");
    let other = Form::new().part("spec", part(SPEC, "text/csv")).text("nodes", "x,y\n1,2");
    post(&app, other).await.problem(415, "unsupported_media_type");
    for (media, body) in [
        ("multipart/form-data", "--x\r\n"),
        ("multipart/form-data; boundary=x", ""),
        ("multipart/form-data; boundary=x", "--x\r\nContent-Disposition: form-data; name=\"spec\"\r\n\r\n{"),
        ("multipart/form-data; boundary=x", "--x--\r\n"),
    ] {
        let request = app.client.post(app.url("/v1/fits")).header("content-type", media).body(body);
        send(request).await.problem(400, "malformed_body");
    }
}

/// The only limit on forms is that on bodies.
#[tokio::test]
async fn a_large_form_is_read() {
    let app = TestApp::start_with(|settings| settings.body_limit = 6 << 20).await;
    // points on a line, in rows of equal length
    let rows: String = (0..280_000).map(|i| format!("{i:08},{:09}\n", 2 * i + 1)).collect();
    assert!(rows.len() > 5 << 20);
    let answer = post_table(&app, &format!("x,y\n{rows}")).await;
    assert_eq!(answer.status, 200, "{:.300}", answer.text);
    assert_eq!(answer.json()["residuals"]["count"], 280_000);
    let more = format!("x,y\n{rows}{rows}");
    post_table(&app, &more).await.problem(413, "body_too_large");
}

/// The content decides on the form of a table, whatever its media type.
#[tokio::test]
async fn a_table_may_have_any_media_type_and_character_set() {
    let app = TestApp::start().await;
    let text = "x,y\n0,1\n1,2\n2,4\n";
    let wanted = post_table(&app, text).await.text;
    let utf16: Vec<u8> = std::iter::once(0xFEFF).chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    for (bytes, media) in [
        (text.as_bytes().to_vec(), "text/csv; charset=utf-8"),
        (utf16, "text/csv; charset=utf-16le"),
        (text.as_bytes().to_vec(), "application/vnd.ms-excel"),
        (text.replace(',', "\t").into_bytes(), "text/tab-separated-values"),
    ] {
        let nodes = Part::bytes(bytes).mime_str(media).unwrap();
        let answer = post(&app, Form::new().text("spec", SPEC).part("nodes", nodes)).await;
        assert_eq!((answer.status.as_u16(), &answer.text), (200, &wanted), "{media}");
    }
}

/// Decimal commas between commas are distinguished only by quotes or another separator.
#[tokio::test]
async fn a_mapping_determines_how_a_table_is_read() {
    let app = TestApp::start().await;
    let form = |mapping: &str| {
        Form::new()
            .text("spec", SPEC)
            .text("nodes", "y;x\n1;0\n3,1;1\n4,9;2\n7,2;3\n")
            .text("mapping", mapping.to_owned())
    };
    let wanted = app.fit(CURVE).await.text;
    for mapping in [r#"{"decimal": ",", "separator": ";", "header": null}"#, "{}"] {
        assert_eq!(post(&app, form(mapping)).await.text, wanted, "{mapping}");
    }
    let swapped = r#"{"columns": [{"meaning": "x"}, {"meaning": "y"}]}"#;
    assert_ne!(post(&app, form(swapped)).await.text, wanted);
    let refused = post(&app, form(r#"{"separator": ","}"#)).await;
    assert_eq!(refused.status, 422, "{}", refused.text);
    assert!(refused.text.contains("no line of the table has two numbers"), "{}", refused.text);
    assert_eq!(post(&app, form(r#"{"decimals": ","}"#)).await.pointers(), ["/mapping/decimals"]);
    assert_eq!(
        post(&app, form(r#"{"columns": [{"meaning": "depth"}]}"#)).await.pointers(),
        ["/mapping/columns/0/meaning"]
    );
    post(&app, form("{")).await.problem(400, "malformed_body");
}
