//! The `type` of the alternatives of a union.

use serde::Deserialize;

use super::value::read_object;
use crate::api::faults::Faults;

/// Declares the only value of a variant's `type`.
macro_rules! tags {
    ($($name:ident = $value:ident),* $(,)?) => {$(
        /// The variant.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum $name {
            $value,
        }
    )*};
}

pub(in crate::api) use tags;

/// The `type` of a union.
#[derive(Deserialize)]
struct Tag {
    #[serde(rename = "type")]
    kind: String,
}

pub fn read_tag(slice: &[u8], pointer: &str, faults: &mut Faults) -> Option<String> {
    read_object::<Tag>(slice, pointer, faults).map(|tag| tag.kind)
}

pub fn unknown_type(pointer: &str, got: &str, known: &str, faults: &mut Faults) {
    let got: String = got.chars().take(64).collect();
    faults.push(format!("{pointer}/type"), format!("`{got}` is not offered by this version; {known}"));
}
