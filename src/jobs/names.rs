//! Enumerations whose values have names in requests, responses and columns.

/// Gives enumerations the list of their values, and their names.
macro_rules! names {
    ($($Of:ident { $($Value:ident $name:literal),+ $(,)? })+) => {
        $(impl $Of {
            pub const ALL: [Self; [$($name),+].len()] = [$(Self::$Value),+];

            /// Returns the name in requests, responses and columns.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$Value => $name,)+
                }
            }

            /// Returns the value of a name.
            pub fn named(name: &str) -> Option<Self> {
                Self::ALL.into_iter().find(|value| value.name() == name)
            }
        })+
    };
}
