//! YAML as JSON, so that its fields have pointers.

use saphyr_parser::{Event, Parser, ScalarStyle};
use serde_json::{Map, Value};

/// Open node while parsing: a list, or an object with the key whose value comes next.
enum Open {
    List(Vec<Value>),
    Object(Map<String, Value>, Option<String>),
}

/// The documents of a file. Anchors and tags are not for files that people keep by hand.
pub fn documents(text: &str) -> Vec<Value> {
    let (mut open, mut documents) = (Vec::new(), Vec::new());
    for event in Parser::new_from_str(text) {
        let (event, _) = event.unwrap_or_else(|error| panic!("{error}"));
        let value = match event {
            Event::MappingStart(..) => {
                open.push(Open::Object(Map::new(), None));
                continue;
            }
            Event::SequenceStart(..) => {
                open.push(Open::List(Vec::new()));
                continue;
            }
            Event::Scalar(text, style, ..) => scalar(&text, style),
            Event::MappingEnd | Event::SequenceEnd => match open.pop().expect("what ends has begun") {
                Open::List(items) => Value::Array(items),
                Open::Object(fields, key) => {
                    assert_eq!(key, None, "a key has a value");
                    Value::Object(fields)
                }
            },
            Event::Alias(_) => panic!("an alias"),
            _ => continue,
        };
        match open.last_mut() {
            None => documents.push(value),
            Some(Open::List(items)) => items.push(value),
            Some(Open::Object(fields, key)) => match key.take() {
                None => *key = Some(value.as_str().expect("a key is text").to_owned()),
                Some(key) => assert_eq!(fields.insert(key, value), None, "a key stands once"),
            },
        }
    }
    documents
}

/// Value of a scalar in YAML: only plain ones are more than text.
fn scalar(text: &str, style: ScalarStyle) -> Value {
    match text {
        _ if style != ScalarStyle::Plain => Value::from(text),
        "" | "~" | "null" => Value::Null,
        "true" => Value::Bool(true),
        "false" => Value::Bool(false),
        _ => match text.parse::<i64>() {
            Ok(number) => Value::from(number),
            Err(_) => text.parse::<f64>().map_or_else(|_| Value::from(text), Value::from),
        },
    }
}

#[test]
fn it_is_read_as_others_read_it() {
    let text =
        "# first\na: 1\nb: \"1\"\nc: {d: [x, true, 1.5], e: }\nf: >-\n  two\n  lines\n---\n- g: h\n  i: j\n- 5m\n";
    let expected = [
        serde_json::json!({"a": 1, "b": "1", "c": {"d": ["x", true, 1.5], "e": null}, "f": "two lines"}),
        serde_json::json!([{"g": "h", "i": "j"}, "5m"]),
    ];
    assert_eq!(documents(text), expected);
}
