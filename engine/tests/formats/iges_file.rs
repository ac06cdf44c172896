//! A reader of IGES files by the standard's text: cards, sections, pointers, free format.

use std::collections::HashMap;

/// A field of free-format data.
#[derive(Clone, Debug, PartialEq)]
pub enum Field {
    Empty,
    Integer(i64),
    Real(f64),
    Text(String),
}

impl Field {
    pub fn integer(&self) -> usize {
        match self {
            Field::Integer(n) => usize::try_from(*n).expect("a count"),
            other => panic!("{other:?} is not an integer"),
        }
    }

    /// Reals, and integers where a real may be one, do not mix: the writer has to write points.
    pub fn real(&self) -> f64 {
        match self {
            Field::Real(x) => *x,
            other => panic!("{other:?} is not a real"),
        }
    }
}

#[derive(Debug)]
pub struct Entity {
    pub kind: usize,
    pub form: usize,
    pub label: String,
    pub parameters: Vec<Field>,
}

#[derive(Debug)]
pub struct File {
    pub global: Vec<Field>,
    /// Entities by the number of the directory entry's first card.
    pub entities: HashMap<usize, Entity>,
    pub order: Vec<usize>,
}

pub fn read(text: &str) -> File {
    assert!(text.is_ascii() && text.ends_with('\n') && !text.contains('\r'));
    let mut sections: HashMap<char, Vec<&str>> = HashMap::new();
    let mut order = String::new();
    for card in text.lines() {
        assert_eq!(card.len(), 80, "{card:?}");
        let section = card[72..73].chars().next().expect("a section");
        if !order.ends_with(section) {
            order.push(section);
        }
        let cards = sections.entry(section).or_default();
        cards.push(&card[..72]);
        assert_eq!(number(&card[73..80]), cards.len(), "{card:?}");
    }
    assert_eq!(order, "SGDPT");
    let counts = ['S', 'G', 'D', 'P'].map(|s| format!("{s}{:07}", sections[&s].len())).concat();
    assert_eq!(sections[&'T'], [format!("{counts:<72}")]);

    let global = fields(&sections[&'G'].concat(), true);
    let parameters = &sections[&'P'];
    let mut entities = HashMap::new();
    let mut entries = Vec::new();
    assert_eq!(sections[&'D'].len() % 2, 0);
    for (i, pair) in sections[&'D'].chunks(2).enumerate() {
        let at = 2 * i + 1;
        let [first, second] =
            [pair[0], pair[1]].map(|card| (0..9).map(|k| card[8 * k..8 * k + 8].trim()).collect::<Vec<_>>());
        let kind = number(first[0]);
        assert_eq!(number(second[0]), kind);
        assert_eq!(first[8].len(), 8, "status");
        let (start, lines) = (number(first[1]), number(second[3]));
        assert!(lines >= 1);
        let cards = &parameters[start - 1..start - 1 + lines];
        for card in cards {
            assert_eq!((&card[64..65], number(&card[65..72])), (" ", at), "{card:?}");
        }
        let data: String = cards.iter().map(|card| &card[..64]).collect();
        let parameters = fields(&data, false);
        assert_eq!(parameters[0].integer(), kind);
        let label = second[7].to_owned();
        entities.insert(at, Entity { kind, form: number(second[4]), label, parameters });
        entries.push(at);
    }
    // every parameter card belongs to an entity, in order
    let total: usize = sections[&'D'].chunks(2).map(|pair| number(pair[1][24..32].trim())).sum();
    assert_eq!(total, parameters.len());
    File { global, entities, order: entries }
}

fn number(text: &str) -> usize {
    text.trim().parse().unwrap_or_else(|_| panic!("{text:?} is not a number"))
}

/// Comma-separated fields up to the semicolon; what follows is blank. The global section begins
/// with its delimiters.
fn fields(data: &str, global: bool) -> Vec<Field> {
    let mut fields = Vec::new();
    let mut rest = data;
    loop {
        let (field, after) = field(rest);
        fields.push(field);
        let end = after.chars().next().expect("a delimiter");
        rest = &after[1..];
        match end {
            ',' => {}
            ';' => break,
            other => panic!("{other:?} ends a field of {data:?}"),
        }
    }
    assert_eq!(rest.trim(), "");
    if global {
        assert_eq!(fields[..2], [Field::Text(",".into()), Field::Text(";".into())]);
    }
    fields
}

fn field(text: &str) -> (Field, &str) {
    // blanks are not significant before a field
    let text = text.trim_start();
    let digits = text.bytes().take_while(u8::is_ascii_digit).count();
    if digits > 0 && text[digits..].starts_with('H') {
        let (start, length) = (digits + 1, number(&text[..digits]));
        return (Field::Text(text[start..start + length].to_owned()), text[start + length..].trim_start());
    }
    let end = text.find([',', ';']).expect("a delimiter");
    let (word, rest) = (text[..end].trim(), &text[end..]);
    let value = if word.is_empty() {
        Field::Empty
    } else if word.contains(['.', 'D', 'E']) {
        assert!(word.contains('.') && !word.contains('e'), "{word}");
        let double = word.contains('D');
        let x: f64 = word.replace('D', "E").parse().unwrap_or_else(|_| panic!("{word:?}"));
        assert!(x.is_finite());
        // a constant without D is of single precision: it must not need more
        let digits = word.bytes().filter(u8::is_ascii_digit).count();
        assert!(double || digits <= 7, "{word}");
        Field::Real(x)
    } else {
        Field::Integer(word.parse().unwrap_or_else(|_| panic!("{word:?}")))
    };
    (value, rest)
}
