//! Pages of a list. A cursor names the last item seen, not a position, so a page neither repeats nor skips an item when
//! others are added or deleted meanwhile.

use uuid::Uuid;

/// Where the next page begins: after the item of this id.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cursor(pub Uuid);

impl Cursor {
    /// After the item of this number, where items are known by numbers.
    pub fn after_number(number: u64) -> Self {
        Cursor(Uuid::from_u128(number.into()))
    }

    /// The number of [`Cursor::after_number`]; the greatest for a cursor of another kind, after which nothing comes.
    pub fn number(self) -> u64 {
        u64::try_from(self.0.as_u128()).unwrap_or(u64::MAX)
    }

    /// The cursor as it travels.
    pub fn encode(self) -> String {
        self.0.simple().to_string()
    }

    /// The cursor of that text.
    pub fn decode(text: &str) -> Option<Self> {
        if text.len() != 32 {
            return None;
        }
        Uuid::try_parse(text).ok().map(Cursor)
    }
}

/// How much of a list is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PageRequest {
    pub limit: u32,
    pub after: Option<Cursor>,
}

impl PageRequest {
    pub const DEFAULT_LIMIT: u32 = 50;
    pub const MOST: u32 = 200;
}

/// Some items, and where to go on.
#[derive(Clone, Debug, PartialEq)]
pub struct Page<T> {
    pub items: Vec<T>,
    pub next: Option<Cursor>,
}

impl<T> Page<T> {
    /// A page of at most `limit` items. One item more was asked for: it tells that there is a next page.
    pub fn of(mut items: Vec<T>, limit: u32, id: impl Fn(&T) -> Uuid) -> Self {
        let limit = usize::try_from(limit).unwrap_or(usize::MAX);
        let more = items.len() > limit;
        items.truncate(limit);
        let next = if more { items.last().map(|last| Cursor(id(last))) } else { None };
        Page { items, next }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cursor_travels() {
        let cursor = Cursor(Uuid::from_u128(0x0123_4567_89ab));
        assert_eq!(Cursor::decode(&cursor.encode()), Some(cursor));
        assert_eq!(Cursor::decode("next"), None);
    }
}
