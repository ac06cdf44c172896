//! Warnings that intervals may not hold.

/// Codes of the warnings that intervals may not hold.
const CODES: [&str; 12] = [
    "outliers_suspected",
    "correlated_residuals",
    "uneven_variance",
    "lack_of_fit",
    "clustered_low_weights",
    "uncertainty_contradicted",
    "filtered_noise",
    "post_selection",
    "positions_uncertain",
    "power_uncertain",
    "norm_limit_contradicted",
    "correlated_noise",
];

/// A set of codes of warnings that intervals may not hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize),
    serde(from = "Vec<String>", into = "Vec<&'static str>")
)]
pub struct Doubts(u16);

impl Doubts {
    /// Returns the codes in order.
    pub fn codes(self) -> impl Iterator<Item = &'static str> {
        CODES.into_iter().enumerate().filter(move |(bit, _)| self.0 >> bit & 1 == 1).map(|(_, code)| code)
    }

    /// True if there is no code.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Returns the codes of either.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Doubts(self.0 | other.0)
    }
}

impl<'a> FromIterator<&'a str> for Doubts {
    /// Codes of other warnings are left out.
    fn from_iter<I: IntoIterator<Item = &'a str>>(codes: I) -> Self {
        let bits = codes.into_iter().filter_map(|code| CODES.iter().position(|one| *one == code));
        Doubts(bits.fold(0, |bits, bit| bits | 1 << bit))
    }
}

impl From<Vec<String>> for Doubts {
    fn from(codes: Vec<String>) -> Self {
        codes.iter().map(String::as_str).collect()
    }
}

impl From<Doubts> for Vec<&'static str> {
    fn from(doubts: Doubts) -> Self {
        doubts.codes().collect()
    }
}
