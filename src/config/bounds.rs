//! Bounds of settings outside which they make no sense: a server that cannot respond, and times
//! that no clock reaches.

use std::{fmt::Display, ops::RangeInclusive, str::FromStr};

/// Seconds of a day, the upper bound of times to wait.
pub const DAY: u64 = 86_400;
/// Bytes of the body of a small fit.
pub const LEAST_BODY: usize = 1 << 10;
/// Least memory in bytes for the bodies of some requests at a time.
pub const LEAST_MEMORY: usize = 1 << 20;
/// Upper bound of memory in bytes.
pub const MOST_BYTES: usize = 1 << 40;
/// Upper bound of threads.
pub const MOST_WORKERS: usize = 4096;
/// Upper bound of waiting requests.
pub const MOST_WAITING: usize = 1 << 20;
/// Upper bound of connections: the most open files of a system.
pub const MOST_CONNECTIONS: usize = 1 << 20;

/// Reads a whole number within bounds.
pub fn within<T>(bounds: RangeInclusive<T>) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static
where
    T: FromStr + PartialOrd + Display + Clone + Send + Sync + 'static,
{
    move |text| {
        let number = text.parse().ok().filter(|number| bounds.contains(number));
        number.ok_or_else(|| format!("write a whole number from {} to {}", bounds.start(), bounds.end()))
    }
}

/// Reads a part of a whole, from 0 to 1.
pub fn parse_part(text: &str) -> Result<f64, String> {
    let part = text.parse::<f64>().ok().filter(|part| (0.0..=1.0).contains(part));
    part.ok_or_else(|| "write a number from 0 to 1".into())
}

/// Reads values separated by commas; an empty text has none.
pub fn parse_list<T>(text: &str, read: impl Fn(&str) -> Result<T, String>) -> Result<Vec<T>, String> {
    match text.trim() {
        "" => Ok(Vec::new()),
        text => text.split(',').map(|one| read(one.trim())).collect(),
    }
}

#[cfg(test)]
mod tests {
    use clap::{Args as _, Command};

    use super::*;
    use crate::config::ServeSettings;

    /// Returns the error of a setting, `None` where it is valid.
    fn refusal(flag: &str, value: &str) -> Option<String> {
        let command = ServeSettings::augment_args(Command::new("serve")).mut_args(|arg| arg.env(None::<&'static str>));
        let arguments = ["serve".to_owned(), format!("{flag}={value}")];
        command.try_get_matches_from(arguments).err().map(|error| error.to_string())
    }

    #[test]
    fn settings_out_of_bounds_are_refused_with_the_bounds() {
        for (flag, least, most) in [
            ("--body-limit", 1024_u64, 1_099_511_627_776),
            ("--body-memory", 1_048_576, 1_099_511_627_776),
            ("--max-connections", 1, 1_048_576),
            ("--workers", 0, 4096),
            ("--queue", 1, 1_048_576),
            ("--body-timeout", 1, 86_400),
            ("--write-timeout", 1, 86_400),
            ("--request-timeout", 1, 86_400),
            ("--progress-timeout", 1, 86_400),
            ("--drain-delay", 0, 86_400),
            ("--shutdown-grace", 0, 86_400),
            ("--rate-limit", 1, 4_294_967_295),
        ] {
            let beyond = [most + 1, u64::MAX - 1].map(|value| value.to_string());
            let below = least.checked_sub(1).map(|value| value.to_string());
            for value in below.into_iter().chain(beyond).chain(["-1".into(), "1.5".into()]) {
                let said = refusal(flag, &value).unwrap_or_default();
                let bounds = format!("write a whole number from {least} to {most}");
                assert!(said.contains(flag) && said.contains(&bounds), "{flag}={value}: {said}");
            }
            for value in [least, most] {
                assert_eq!(refusal(flag, &value.to_string()), None);
            }
        }
    }

    #[test]
    fn a_part_is_from_nothing_to_everything() {
        assert_eq!((parse_part("0.5"), parse_part("1"), parse_part("0")), (Ok(0.5), Ok(1.0), Ok(0.0)));
        for wrong in ["-0.1", "1.1", "NaN", "half", ""] {
            assert!(parse_part(wrong).is_err(), "{wrong}");
        }
    }
}
