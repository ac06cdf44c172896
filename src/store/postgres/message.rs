//! Messages on the channel on which processes wake each other: the sender, its time by its own
//! clock, and the changes, in words.

use std::time::Duration;

use uuid::Uuid;

use crate::jobs::{Owned, Tenant, Wake};

/// PostgreSQL takes less than 8,000 bytes at a time.
const MOST_BYTES: usize = 7900;
const STREAM_END: &str = ".";
const KEYS: &str = "!";
const ANYTHING: &str = "*";

/// A message that was heard.
#[derive(Debug, PartialEq, Eq)]
pub struct Message {
    pub from: Uuid,
    /// Since its process began.
    pub sent: Duration,
    pub wakes: Vec<Wake>,
}

impl Message {
    /// The texts that say all of this, of which none is too long.
    pub fn write<'a>(from: Uuid, sent: Duration, wakes: impl IntoIterator<Item = &'a Wake>) -> Vec<String> {
        let begin = format!("{} {}", from.simple(), sent.as_micros());
        let mut texts: Vec<String> = Vec::new();
        for wake in wakes {
            let word = match wake {
                Wake::Job(Owned { tenant, id }) => format!(" {}/{}", tenant.as_str(), id.simple()),
                Wake::StreamEnd => format!(" {STREAM_END}"),
                Wake::Keys => format!(" {KEYS}"),
                Wake::Anything => format!(" {ANYTHING}"),
            };
            match texts.last_mut() {
                Some(text) if text.len() + word.len() <= MOST_BYTES => text.push_str(&word),
                _ => texts.push(begin.clone() + &word),
            }
        }
        texts
    }

    /// Reads a text. A word of another version may mean anything.
    pub fn read(text: &str) -> Option<Self> {
        let mut words = text.split(' ');
        let from = words.next()?.parse().ok()?;
        let sent = Duration::from_micros(words.next()?.parse().ok()?);
        let wake = |word: &str| match word {
            STREAM_END => Wake::StreamEnd,
            KEYS => Wake::Keys,
            job => owned(job).map_or(Wake::Anything, Wake::Job),
        };
        Some(Message { from, sent, wakes: words.map(wake).collect() })
    }
}

fn owned(word: &str) -> Option<Owned> {
    let (tenant, id) = word.split_once('/')?;
    Some(Owned { tenant: Tenant::named(tenant)?, id: id.parse().ok()? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_round_trip_in_texts_of_limited_length() {
        let job = |id| Wake::Job(Owned { tenant: Tenant::named(&"t".repeat(63)).unwrap(), id: Uuid::from_u128(id) });
        let wakes: Vec<Wake> = (0..500).map(job).chain([Wake::StreamEnd, Wake::Keys, Wake::Anything]).collect();
        let (from, sent) = (Uuid::from_u128(7), Duration::from_micros(1_234_567));
        let texts = Message::write(from, sent, &wakes);
        assert!(texts.iter().all(|text| text.len() < 8000) && texts.len() > 1, "{}", texts.len());
        let read: Vec<Message> = texts.iter().map(|text| Message::read(text).unwrap()).collect();
        assert!(read.iter().all(|message| (message.from, message.sent) == (from, sent)));
        assert_eq!(read.into_iter().flat_map(|message| message.wakes).collect::<Vec<_>>(), wakes);
        assert!(Message::write(from, sent, []).is_empty());
    }

    #[test]
    fn unknown_wakes_are_read_as_anything() {
        let text = format!("{} 5 what/ever? . default/{}", Uuid::max().simple(), Uuid::nil());
        let job = Wake::Job(Owned { tenant: Tenant::default(), id: Uuid::nil() });
        assert_eq!(Message::read(&text).unwrap().wakes, [Wake::Anything, Wake::StreamEnd, job]);
        for foreign in ["", "hello", "hello world", "00000000-0000-0000-0000-000000000000"] {
            assert_eq!(Message::read(foreign), None, "{foreign}");
        }
    }
}
