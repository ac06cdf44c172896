//! Warnings that intervals may not hold, or that there are none.

/// A set of codes of warnings that intervals may not hold, or that there are none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize),
    serde(from = "Vec<String>", into = "Vec<&'static str>")
)]
pub struct Doubts(u16);

impl Doubts {
    /// Codes of the warnings that intervals may not hold, and of those why there is no interval.
    pub const CODES: [&'static str; 16] = [
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
        "too_few_nodes",
        "no_degrees_of_freedom",
        "exact_fit",
        "no_scale",
    ];

    /// Returns the codes in order.
    pub fn codes(self) -> impl Iterator<Item = &'static str> {
        Self::CODES.into_iter().enumerate().filter(move |(bit, _)| self.0 >> bit & 1 == 1).map(|(_, code)| code)
    }

    /// True if there is no code.
    pub fn is_empty(&self) -> bool {
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
        let bits = codes.into_iter().filter_map(|code| Self::CODES.iter().position(|one| *one == code));
        Doubts(bits.fold(0, |bits, bit| bits | 1 << bit))
    }
}

#[cfg(feature = "contract")]
impl utoipa::PartialSchema for Doubts {
    fn schema() -> utoipa::openapi::RefOr<utoipa::openapi::Schema> {
        let code = utoipa::openapi::ObjectBuilder::new().schema_type(utoipa::openapi::Type::String);
        let codes = utoipa::openapi::ArrayBuilder::new().items(code.enum_values(Some(Self::CODES)));
        codes.description(Some("Codes of warnings that intervals may not hold, or that there are none.")).into()
    }
}

#[cfg(feature = "contract")]
impl utoipa::ToSchema for Doubts {}

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
