//! Pages of a list. A cursor names the last item seen, not a position, so a page neither repeats
//! nor skips an item when others are added or deleted meanwhile.

use uuid::Uuid;

/// The lists that come in pages. A cursor of one says nothing of another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum List {
    Jobs,
    Iterations,
    Fits,
    Records,
    Keys,
    Tenants,
    Audit,
    Seals,
    Streams,
}

impl List {
    /// Every list, with the first byte of its cursors and the name of its items. (11 and 12 are
    /// orders of jobs.)
    const ALL: [(List, u8, &str); 9] = [
        (List::Jobs, 1, "jobs"),
        (List::Iterations, 2, "iterations"),
        (List::Fits, 3, "fits"),
        (List::Records, 4, "records"),
        (List::Keys, 5, "keys"),
        (List::Tenants, 6, "tenants"),
        (List::Audit, 8, "entries of the audit"),
        (List::Seals, 10, "seals"),
        (List::Streams, 13, "streams"),
    ];

    fn row(self) -> (u8, &'static str) {
        Self::ALL.into_iter().find(|(list, ..)| *list == self).map_or((0, ""), |(_, kind, items)| (kind, items))
    }

    /// Returns the name of its items.
    pub fn items(self) -> &'static str {
        self.row().1
    }
}

/// First digits of cursors of jobs in another order than that of their creation.
pub const JOBS_BY_CHANGE: &str = "0b";
pub const JOBS_BY_NAME: &str = "0c";

/// Why a text is no cursor of a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CursorError {
    /// No list answered it.
    Unknown,
    /// It is one of another list.
    OtherList(List),
}

/// Start of the next page: after the item of this id.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cursor(pub Uuid);

impl Cursor {
    /// After the item of this number, where items are known by numbers.
    pub fn after_number(number: u64) -> Self {
        Cursor(Uuid::from_u128(number.into()))
    }

    /// The number of [`Cursor::after_number`]; the greatest for one that no list answered, after
    /// which nothing comes.
    pub fn number(self) -> u64 {
        u64::try_from(self.0.as_u128()).unwrap_or(u64::MAX)
    }

    /// The cursor as it travels: two digits for its list, and the id.
    pub fn encode(self, list: List) -> String {
        format!("{:02x}{}", list.row().0, self.0.simple())
    }

    /// The cursor of that text, if it is one of this list.
    pub fn decode(text: &str, list: List) -> Result<Self, CursorError> {
        let id = |(_, id): (&str, &str)| (id.len() == 32).then(|| Uuid::try_parse(id).ok())?;
        let parts = text.split_at_checked(2);
        let of = parts.and_then(|(kind, _)| List::ALL.into_iter().find(|list| format!("{:02x}", list.1) == kind));
        if parts.is_some_and(|(kind, _)| [JOBS_BY_CHANGE, JOBS_BY_NAME].contains(&kind)) {
            return Err(CursorError::OtherList(List::Jobs));
        }
        match (of, parts.and_then(id)) {
            (Some((of, ..)), Some(id)) if of == list => Ok(Cursor(id)),
            (Some((of, ..)), Some(_)) => Err(CursorError::OtherList(of)),
            _ => Err(CursorError::Unknown),
        }
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
    /// Makes a page of at most `limit` items. One item more shows that there is a next
    /// page.
    pub fn of(mut items: Vec<T>, limit: u32, cursor: impl Fn(&T) -> Cursor) -> Self {
        let limit = usize::try_from(limit).unwrap_or(usize::MAX);
        let more = items.len() > limit;
        items.truncate(limit);
        let next = if more { items.last().map(cursor) } else { None };
        Page { items, next }
    }

    /// The same page of other items.
    pub fn map<U>(self, form: impl FnMut(T) -> U) -> Page<U> {
        Page { items: self.items.into_iter().map(form).collect(), next: self.next }
    }
}
