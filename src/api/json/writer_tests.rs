//! Objects are what serde reads.

use proptest::prelude::*;

use super::*;

fn written(write: impl FnOnce(&mut Object<'_>)) -> String {
    let mut json = Json::with_capacity(0);
    let mut object = json.object();
    write(&mut object);
    object.end();
    String::from_utf8(json.finish().unwrap()).unwrap()
}

#[test]
fn a_field_of_serde_that_is_not_finite_is_named() {
    let body = |x: f64| std::collections::BTreeMap::from([("a", 1.0), ("b", x)]);
    assert_eq!(whole(&body(2.5)).unwrap(), br#"{"a":1.0,"b":2.5}"#);
    assert_eq!(whole(&body(f64::NAN)), Err(NotFinite("b".to_owned())));
    assert_eq!(whole(&[None, Some(1.5)]).unwrap(), b"[null,1.5]", "a place of a list may be empty");
    let mut json = Json::with_capacity(0);
    json.object().field("list", &[body(1.0), body(f64::INFINITY)]).field("x", &1.0).end();
    assert_eq!(json.finish(), Err(NotFinite("b".to_owned())));
    let mut json = Json::with_capacity(0);
    json.object().field("x", &f64::NAN).end();
    assert_eq!(json.finish(), Err(NotFinite("x".to_owned())));
}

#[test]
fn written_objects_are_valid_json() {
    let text = written(|object| {
        object
            .field("a", &"x\"y")
            .list("d", [1, 2], |object, n| {
                object.field("n", &n);
            })
            .list("e", [0_u8; 0], |_, _| {})
            .object("f", |object| {
                object.field("n", &12).field("m", &[3, 0]);
            });
    });
    assert_eq!(text, r#"{"a":"x\"y","d":[{"n":1},{"n":2}],"e":[],"f":{"n":12,"m":[3,0]}}"#);
}

#[test]
fn numbers_that_json_cannot_hold_are_reported() {
    for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut json = Json::with_capacity(0);
        json.object().numbers("a", &[1.0, wrong, 2.0]).end();
        assert_eq!(json.finish(), Err(NotFinite("a".to_owned())));
        let mut json = Json::with_capacity(0);
        json.object().number("a", 1.0).number("b", wrong).number("c", wrong).number("d", 2.0).end();
        assert_eq!(json.finish(), Err(NotFinite("b".to_owned())));
    }
}

proptest! {
    #[test]
    fn numbers_are_those_of_serde(
        values in proptest::collection::vec(any::<f64>().prop_filter("finite", |x| x.is_finite()), 0..40),
        bits in any::<u64>(),
    ) {
        let mut values = values;
        values.extend([0.0, -0.0, 1.0, 0.1, 1e16, 1e-7, f64::MAX, f64::MIN_POSITIVE, 5e-324]);
        values.extend(Some(f64::from_bits(bits)).filter(|x| x.is_finite()));
        let serde = serde_json::to_string(&values).unwrap();
        prop_assert_eq!(written(|object| { object.numbers("a", &values); }), format!(r#"{{"a":{serde}}}"#));
        let pair = [f64::from_bits(bits), -values[0]].map(|x| if x.is_finite() { x } else { 0.0 });
        let serde = serde_json::to_string(&pair).unwrap();
        prop_assert_eq!(written(|object| { object.numbers("a", &pair); }), format!(r#"{{"a":{serde}}}"#));
    }
}
