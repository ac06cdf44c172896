//! Declaration of warnings.

/// Declares an enum of warnings. Each variant has a stable code, a message (`#[error]`, as in
/// thiserror) and fields, whose names are those of the values in JSON.
///
/// The enum gets `CODES`, `code()` and `Display`. With the feature `contract` of its crate it is
/// serialised as its values alone. `in FIELD` in place of a code means the code of this field.
///
/// ```text
/// warnings! {
///     /// Something that the reader of a gear must know.
///     pub enum Warning {
///         /// Fewer teeth than the standard covers.
///         #[error("{teeth} teeth: ISO 1328-1 has tolerances from 5 teeth on")]
///         "few_teeth" => FewTeeth { teeth: u32 },
///     }
/// }
/// ```
#[macro_export]
macro_rules! warnings {
    ($(#[$($meta:tt)*])* pub enum $name:ident {
        $(
            $(#[$($about:tt)*])*
            $($code:literal)? $(in $inner:ident)? => $variant:ident $({ $($fields:tt)* })? $(($($parts:tt)*))?
        ),+ $(,)?
    }) => {
        $(#[$($meta)*])*
        #[derive(Clone, Debug, PartialEq, thiserror::Error)]
        #[non_exhaustive]
        #[cfg_attr(feature = "contract", derive(serde::Serialize), serde(untagged))]
        #[allow(missing_docs, reason = "the variant says what its fields are, where their names do not")]
        pub enum $name {
            $($(#[$($about)*])* $variant $({ $($fields)* })? $(($($parts)*))?),+
        }

        impl $name {
            /// The codes of this enum's own variants.
            pub const CODES: &'static [&'static str] = &[$($($code,)?)+];

            /// Returns the stable code.
            pub fn code(&self) -> &'static str {
                match self {
                    $(
                        $($name::$variant { .. } => $code,)?
                        $($name::$variant { $inner, .. } => $inner.code(),)?
                    )+
                }
            }
        }
    };
}
