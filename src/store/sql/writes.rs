//! The writes of callers as data. What each does is in the file of its table, as an `impl Write`.

use std::sync::Arc;

use jiff::Timestamp;
use uuid::Uuid;

use crate::{jobs::*, key_operations, repository_operations};

/// Makes a struct of each write.
macro_rules! declare {
    (
        $Trait:ident
        reads { $($(#[$about:meta])* $Read:ident = $read:ident($($of:ident: $what:ty),*) -> $found:ty;)* }
        writes { $($(#[$on:meta])* $Write:ident = $write:ident($($with:ident: $given:ty),*) -> $reply:ty;)* }
    ) => {
        $(
            $(#[$on])*
            pub struct $Write {
                $(pub $with: $given,)*
            }
        )*
    };
}

repository_operations!(declare);
key_operations!(declare);
