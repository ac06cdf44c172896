//! Changes to a JSON tree: what somebody, or a program of somebody, may get wrong.

use super::{contract::Contract, node::Node, rng::Rng};

/// Values that all mutations may draw from.
pub struct Stock<'a> {
    pub contract: &'a Contract,
    /// Bodies that are taken.
    pub bodies: &'a [Node],
}

/// Numbers at the ends of what a reader, a double or an index can hold.
const NUMBERS: [&str; 44] = [
    "0",
    "-0",
    "-0.0",
    "1",
    "-1",
    "2",
    "3",
    "0.5",
    "1.5",
    "10",
    "26",
    "100",
    "1000",
    "65536",
    "1000000",
    "5e-324",
    "-5e-324",
    "2.2250738585072014e-308",
    "1e-300",
    "1e-154",
    "1e-12",
    "1e12",
    "1e15",
    "1e16",
    "1e154",
    "1e300",
    "1e308",
    "1.7976931348623157e308",
    "-1.7976931348623157e308",
    "1e309",
    "-1e400",
    "1e-400",
    "2147483647",
    "2147483648",
    "4294967295",
    "4294967296",
    "9007199254740993",
    "9223372036854775807",
    "9223372036854775808",
    "18446744073709551615",
    "18446744073709551616",
    "340282366920938463463374607431768211456",
    "0.1000000000000000055511151231257827021181583404541015625",
    "123456789012345678901234567890e-20",
];

/// Words that are no value of JSON.
const GARBAGE: [&str; 16] = [
    "NaN",
    "Infinity",
    "-Infinity",
    "nan",
    "01",
    "+1",
    ".5",
    "1.",
    "1e",
    "0x10",
    "1_000",
    "1,5",
    "",
    "'a'",
    "undefined",
    "-",
];

const TEXTS: [&str; 15] = [
    "",
    " ",
    "a",
    "left",
    "right",
    "auto",
    "\u{0}",
    "\n",
    "µm",
    "\u{feff}",
    "\u{202e}abc",
    "😀",
    "../..",
    "%00",
    "1e999",
];

/// Between 0 and some changes at places that are drawn.
pub fn mutated(body: &Node, stock: &Stock, rng: &mut Rng) -> Node {
    let mut body = body.clone();
    let count = match rng.below(100) {
        0..8 => 0,
        8..58 => 1,
        58..80 => 2,
        80..95 => rng.within(3, 5),
        _ => rng.within(6, 25),
    };
    for _ in 0..count {
        change(&mut body, stock, rng);
    }
    body
}

/// A place in the tree: one stops everywhere on the way down, so that lists of numbers do not take
/// all draws.
fn place<'a>(body: &'a mut Node, rng: &mut Rng) -> &'a mut Node {
    let mut node = body;
    loop {
        let children = node.children();
        if children == 0 || rng.percent(18) {
            return node;
        }
        let child = rng.below(children);
        // children are there: the index is below their number
        node = node.child_mut(child).expect("a child");
    }
}

fn change(body: &mut Node, stock: &Stock, rng: &mut Rng) {
    let node = place(body, rng);
    if rng.percent(4) {
        *node = other(stock, rng);
        return;
    }
    match node {
        Node::Token(text) => *text = token(text, rng),
        Node::Text(text) => {
            if rng.percent(15) {
                *node = other(stock, rng);
            } else {
                *text = word(text, stock, rng);
            }
        }
        Node::Array(items) => {
            if let Some(new) = list(items, stock, rng) {
                *node = new;
            }
        }
        Node::Object(fields) => object(fields, stock, rng),
    }
}

fn token(text: &str, rng: &mut Rng) -> String {
    let value = text.parse::<f64>().unwrap_or(1.0);
    match rng.below(100) {
        0..40 => rng.one(NUMBERS).to_owned(),
        40..44 => rng.one(GARBAGE).to_owned(),
        44..48 => rng.one(["null", "true", "false", "{}", "[]", "[[]]", "\"1\"", "\"\""]).to_owned(),
        48..60 => written(value * rng.one([-1.0, 0.5, 2.0, 10.0, 1e3, 1e6, 1e12, 1e100, 1e-3, 1e-9, 1e-100, 1e-320])),
        60..68 => written(value + rng.one([-1.0, 1.0, 1e-9, -1e-15, 1e9])),
        68..76 => (value as i64).saturating_add(rng.one([-1, 1, 0, 2])).to_string(),
        76..84 => rng.within(0, 40).to_string(),
        84..90 => written(f64::from_bits(rng.bits())),
        90..94 => written(f64::from_bits(value.to_bits() ^ (1 << rng.below(64)))),
        94..97 => format!("{text}{}", "0".repeat(rng.within(1, 400))),
        _ => format!("{text}{}", rng.one([".0", "e0", "e1", "e-1", "E+00", ".5"])),
    }
}

fn written(value: f64) -> String {
    format!("{value:e}")
}

fn word(text: &str, stock: &Stock, rng: &mut Rng) -> String {
    match rng.below(10) {
        0..5 => {
            let mut words = Vec::new();
            if let Some(body) = rng.pick(stock.bodies) {
                body.visit("", &mut |_, node| {
                    words.extend(if let Node::Text(word) = node { Some(word.clone()) } else { None })
                });
            }
            rng.pick(&words).cloned().unwrap_or_default()
        }
        5 => text.to_uppercase(),
        // a text that is repeated again and again must not fill the memory of the fuzzer itself
        6 => text.repeat(rng.one([2, 10, 300, 5000]).min(100_000 / text.len().max(1))),
        7 => format!("{text}{}", rng.one(TEXTS)),
        _ => rng.one(TEXTS).to_owned(),
    }
}

/// Something of another body, of the contract, or nothing sensible.
fn other(stock: &Stock, rng: &mut Rng) -> Node {
    match rng.below(8) {
        0 => Node::token("null"),
        1 => Node::Object(Vec::new()),
        2 => Node::Array(Vec::new()),
        3 => Node::token(rng.one(NUMBERS)),
        4 => Node::text(rng.one(TEXTS)),
        5 => {
            let mut node = Node::token("1");
            for _ in 0..rng.one([1, 3, 31, 33, 130, 3000]) {
                node =
                    if rng.percent(80) { Node::Array(vec![node]) } else { Node::Object(vec![("a".to_owned(), node)]) };
            }
            node
        }
        6 => stock.contract.any_field(rng).map_or(Node::token("0"), |(_, value)| value),
        _ => {
            let mut body = rng.pick(stock.bodies).cloned().unwrap_or(Node::token("1"));
            place(&mut body, rng).clone()
        }
    }
}

/// Changes a list; `Some` with the node that replaces it.
fn list(items: &mut Vec<Node>, stock: &Stock, rng: &mut Rng) -> Option<Node> {
    let count = items.len();
    match rng.below(16) {
        0 => items.clear(),
        1 => items.truncate(rng.below(count + 1)),
        2 => items.truncate(1),
        3 | 4 if count > 0 => drop(items.remove(rng.below(count))),
        5 if count > 0 => items.insert(rng.below(count), items[rng.below(count)].clone()),
        6 => {
            // longer, up to some thousand entries
            let times = rng.one([2, 3, 10, 40]).min(3000 / count.max(1)).max(1);
            *items = std::iter::repeat_n(items.clone(), times).flatten().collect();
        }
        7 => items.reverse(),
        8 if count > 1 => items.swap(rng.below(count), rng.below(count)),
        9 if count > 0 => {
            let same = items[rng.below(count)].clone();
            items.fill(same);
        }
        10 => {
            // all of it in another unit, or with nothing left of the differences
            let (by, plus) = (
                rng.one([1e-320, 1e-160, 1e-9, 1e9, 1e160, 1e305, 0.0, -1.0, 1.0]),
                rng.one([0.0, 0.0, 1e9, 1e16, -1e300]),
            );
            let mut whole = Node::Array(std::mem::take(items));
            whole.visit_mut(&mut |node| {
                if let Node::Token(text) = node
                    && let Ok(value) = text.parse::<f64>()
                {
                    *text = written(value * by + plus);
                }
            });
            return Some(whole);
        }
        11 => items.push(other(stock, rng)),
        12 => return Some(Node::Array(vec![Node::Array(std::mem::take(items))])),
        13 if count > 0 => return Some(items.swap_remove(rng.below(count))),
        14 if count > 0 => items[rng.below(count)] = Node::token("null"),
        _ => {
            let at = rng.below(count);
            if let Some(item) = items.get_mut(at) {
                *item = other(stock, rng);
            }
        }
    }
    None
}

fn object(fields: &mut Vec<(String, Node)>, stock: &Stock, rng: &mut Rng) {
    let count = fields.len();
    match rng.below(12) {
        0 | 1 if count > 0 => drop(fields.remove(rng.below(count))),
        2 if count > 0 => {
            let again = fields[rng.below(count)].clone();
            fields.push(again);
        }
        3 if count > 0 => {
            let at = rng.below(count);
            let name = fields[at].0.clone();
            fields[at].0 = match rng.below(6) {
                0 => format!("{name}s"),
                1 => name.to_uppercase(),
                2 => String::new(),
                3 => "~/ é\"".to_owned(),
                4 => name.chars().rev().collect(),
                _ => stock.contract.any_field(rng).map_or(name, |(name, _)| name),
            };
        }
        4 if count > 1 => {
            let (a, b) = (rng.below(count), rng.below(count));
            let (left, right) = (fields[a].1.clone(), fields[b].1.clone());
            (fields[a].1, fields[b].1) = (right, left);
        }
        5..9 => {
            // an optional field, or another value for one
            let Some((name, value)) = stock.contract.another_field(fields, rng) else { return };
            match fields.iter_mut().find(|(own, _)| *own == name) {
                Some((_, own)) => *own = value,
                None => fields.push((name, value)),
            }
        }
        9 => fields.extend(stock.contract.any_field(rng)),
        10 => {
            // the same field of another body
            let Some(body) = rng.pick(stock.bodies) else { return };
            let Some((name, own)) = fields.get_mut(rng.below(count)) else { return };
            let mut found = Vec::new();
            body.visit("", &mut |field, node| found.extend((field == name).then(|| node.clone())));
            if let Some(value) = rng.pick(&found) {
                *own = value.clone();
            }
        }
        _ => {
            if let Some((_, own)) = fields.get_mut(rng.below(count)) {
                *own = other(stock, rng);
            }
        }
    }
}

/// Changes bytes of what has been written.
pub fn bytes(body: &mut Vec<u8>, rng: &mut Rng) {
    for _ in 0..rng.within(1, 4) {
        let at = rng.below(body.len() + 1);
        match rng.below(6) {
            0 => body.truncate(at),
            1 => body.insert(at, rng.bits() as u8),
            2 => drop(body.drain(at..(at + rng.within(1, 8)).min(body.len()))),
            3 => {
                let end = (at + rng.within(1, 60)).min(body.len());
                let piece = body[at..end].to_vec();
                let to = rng.below(body.len() + 1);
                body.splice(to..to, piece);
            }
            4 => body
                .splice(
                    at..at,
                    rng.one([&b"\xff"[..], b"\xef\xbb\xbf", b"\0", b"\\u0000", b"\\ud800", b"\"", b",", b"}]"])
                        .iter()
                        .copied(),
                )
                .for_each(drop),
            _ => {
                if let Some(byte) = body.get_mut(at) {
                    *byte ^= 1 << rng.below(8);
                }
            }
        }
    }
}
