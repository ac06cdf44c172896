//! Which products of powers a polynomial model has, as it is written.

use std::fmt;

use serde::{
    Deserialize, Deserializer, Serialize,
    de::{self, SeqAccess, Visitor, value::StrDeserializer},
};

use utoipa::ToSchema;

use crate::api::json::union_schema::{documented, list, whole};
use flankfit_engine::estimation::spec::Terms;

/// A name, or the products one by one.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum TermsBody {
    Name(TermsName),
    Listed(Vec<[usize; 2]>),
}

documented!(
    TermsBody,
    "PolynomialTerms",
    "`tensor`: every product up to the degree of each axis; `total`: those whose degrees add up to at most the degree; \
        or a list of products of a surface, as degrees along u and v within `degree`, each with all its divisors: \
        `[[0, 0], [1, 0], [0, 1]]`.",
    TermsName::schema(),
    list(list(whole(0), Some((2, 2))), None),
);

impl<'de> Deserialize<'de> for TermsBody {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Read;

        impl<'de> Visitor<'de> for Read {
            type Value = TermsBody;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("`tensor`, `total` or a list of pairs of degrees")
            }

            fn visit_str<E: de::Error>(self, name: &str) -> Result<TermsBody, E> {
                TermsName::deserialize(StrDeserializer::new(name)).map(TermsBody::Name)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<TermsBody, A::Error> {
                let mut listed = Vec::new();
                while let Some(pair) = entries.next_element()? {
                    listed.push(pair);
                }
                Ok(TermsBody::Listed(listed))
            }
        }

        deserializer.deserialize_any(Read)
    }
}

impl From<&Terms> for TermsBody {
    fn from(terms: &Terms) -> Self {
        match terms {
            Terms::Tensor => TermsBody::Name(TermsName::Tensor),
            Terms::Total => TermsBody::Name(TermsName::Total),
            Terms::Listed(listed) => TermsBody::Listed(listed.clone()),
        }
    }
}

impl From<TermsBody> for Terms {
    fn from(terms: TermsBody) -> Self {
        match terms {
            TermsBody::Name(TermsName::Tensor) => Terms::Tensor,
            TermsBody::Name(TermsName::Total) => Terms::Total,
            TermsBody::Listed(listed) => Terms::Listed(listed),
        }
    }
}

/// Products of powers: all up to the degree of each axis, or those whose degrees add up to at most
/// the degree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum TermsName {
    Tensor,
    Total,
}
