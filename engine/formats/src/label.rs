//! Name, author and time of a file.

/// A moment in UTC, handed in by the caller: writers have no clock, so that the same input gives
/// the same bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct UtcTime {
    year: u16,
    month: u8,
    day: u8,
    hour: u8,
    minute: u8,
    second: u8,
}

impl UtcTime {
    /// Date (year 0 to 9999, month and day from 1) and time of day; `None` for what no calendar or
    /// clock shows.
    pub fn new([year, month, day]: [u16; 3], [hour, minute, second]: [u8; 3]) -> Option<Self> {
        let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
        let days = match month {
            2 => 28 + u16::from(leap),
            4 | 6 | 9 | 11 => 30,
            1..=12 => 31,
            _ => return None,
        };
        let valid = year <= 9999 && (1..=days).contains(&day) && hour < 24 && minute < 60 && second < 60;
        // both are small by now
        valid.then_some(UtcTime { year, month: month as u8, day: day as u8, hour, minute, second })
    }

    /// The first moment of 1970, for a time that no calendar shows.
    pub fn epoch() -> Self {
        UtcTime { year: 1970, month: 1, day: 1, hour: 0, minute: 0, second: 0 }
    }

    /// `2026-11-21T16:05:09Z`.
    pub fn iso_8601(&self) -> String {
        let UtcTime { year, month, day, hour, minute, second } = self;
        format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
    }

    /// `21.11.2026/16:05:09`, the date of Q-DAS.
    pub(super) fn day_first(&self) -> String {
        let UtcTime { year, month, day, hour, minute, second } = self;
        format!("{day:02}.{month:02}.{year:04}/{hour:02}:{minute:02}:{second:02}")
    }

    /// `20261121.160509`, the date of IGES 5.3.
    pub(super) fn iges(&self) -> String {
        let UtcTime { year, month, day, hour, minute, second } = self;
        format!("{year:04}{month:02}{day:02}.{hour:02}{minute:02}{second:02}")
    }
}

/// Description of a file by itself. Texts may hold any characters: each format writes them in its
/// own way.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// Name of the product or mesh, for instance the name of the gear.
    pub name: String,
    /// Person who wrote it.
    pub author: String,
    /// Organisation of that person.
    pub organization: String,
    /// Time of writing, UTC.
    pub written_at: UtcTime,
}

/// The program that wrote a file.
pub(super) const SYSTEM: &str = concat!("flankfit ", env!("CARGO_PKG_VERSION"));

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_that_exist() {
        assert!(UtcTime::new([2024, 2, 29], [0, 0, 0]).is_some());
        assert!(UtcTime::new([2000, 2, 29], [23, 59, 59]).is_some());
        for (date, time) in [
            ([2023, 2, 29], [0, 0, 0]),
            ([1900, 2, 29], [0, 0, 0]),
            ([2023, 13, 1], [0, 0, 0]),
            ([2023, 4, 31], [0, 0, 0]),
            ([2023, 4, 0], [0, 0, 0]),
            ([2023, 4, 1], [24, 0, 0]),
            ([10000, 1, 1], [0, 0, 0]),
        ] {
            assert!(UtcTime::new(date, time).is_none(), "{date:?} {time:?}");
        }
        let moment = UtcTime::new([2026, 1, 2], [3, 4, 5]).unwrap();
        assert_eq!(moment.iso_8601(), "2026-01-02T03:04:05Z");
        assert_eq!(moment.iges(), "20260102.030405");
    }
}
