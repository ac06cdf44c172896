//! Requests that are declared once, as a table of their members.
//!
//! Of the table come the struct that the document shows and the members that a text is read into
//! (see [`super::members`]): their names, their types, and which must be there.

use super::members::Members;
use crate::api::faults::Faults;

/// A request, or an object within one, that `request!` declares.
pub trait Request {
    type Members<'a>: Members<'a>;
}

/// A request of small members, which are all read together.
pub trait ReadWhole: Request + Sized {
    /// The values, when none of them has a fault.
    fn read(members: &Self::Members<'_>, faults: &mut Faults) -> Option<Self>;
}

impl Request for () {
    type Members<'a> = ();
}

impl ReadWhole for () {
    fn read((): &(), _: &mut Faults) -> Option<Self> {
        Some(())
    }
}

/// Declares a request (or an object within one) and its members.
///
/// ```text
/// request! {
///     /// A curve to build.
///     pub struct CurveRequest as CurveMembers {
///         required points: CurvePointsBody,
///         /// Default 0.
///         optional seed: u64,
///         flatten fit: FitFields,
///     }
/// }
/// ```
///
/// `as CurveMembers, read whole` reads the values of all members into the struct itself. A member
/// whose JSON name is no name of Rust is `required kind as "type": …`; one that is read while the
/// cursor passes over it is `required nodes: NodesBody as RawNodes`, by [`ReadInPassing`].
///
/// [`ReadInPassing`]: super::members::ReadInPassing
macro_rules! request {
    (
        $(#[$meta:meta])*
        pub struct $request:ident as $members:ident $(, read $whole:ident)? {
            $(
                $(#[$field_meta:meta])*
                $kind:ident $name:ident $(as $key:tt)? : $type:ty $(as $reader:ident)?
            ),* $(,)?
        }
    ) => {
        request! { @struct [$(#[$meta])*] $request []
            $($(#[$field_meta])* $kind $name $(as $key)? : $type,)*
        }

        /// Members of it found in a text.
        pub struct $members<'a> {
            $(pub $name: request!(@type 'a $kind $type $(, $reader)?),)*
        }

        impl $crate::api::json::request::Request for $request {
            type Members<'a> = $members<'a>;
        }

        impl<'a> $crate::api::json::members::Members<'a> for $members<'a> {
            fn at(at: &'a str) -> Self {
                $members {
                    $($name: request!(@new $request $kind at, request!(@key $name $($key)?) $(, $reader)?),)*
                }
            }

            fn take(
                &mut self,
                name: &str,
                cursor: &mut $crate::api::json::cursor::Cursor<'a>,
            ) -> Result<$crate::api::json::members::Taken, $crate::api::json::cursor::Syntax> {
                $(request!(@take $kind (self.$name), request!(@key $name $($key)?), name, cursor $(, $reader)?);)*
                Ok($crate::api::json::members::Taken::Unknown)
            }

            fn list(&self, names: &mut Vec<(&'static str, bool)>) {
                $(request!(@list $kind (self.$name), request!(@key $name $($key)?), names $(, $reader)?);)*
            }
        }

        request! { @whole [$($whole)?] $request $members $($kind $name)* }
    };

    // The struct of the document, member by member.
    (@struct $meta:tt $request:ident [$($done:tt)*]
        $(#[$field:meta])* required $name:ident $(as $key:tt)? : $type:ty, $($rest:tt)*
    ) => {
        request! { @struct $meta $request [
            $($done)*
            $(#[serde(rename = $key)])?
            $(#[$field])*
            pub $name: $type,
        ] $($rest)* }
    };
    (@struct $meta:tt $request:ident [$($done:tt)*]
        $(#[$field:meta])* optional $name:ident $(as $key:tt)? : $type:ty, $($rest:tt)*
    ) => {
        request! { @struct $meta $request [
            $($done)*
            #[serde(skip_serializing_if = "Option::is_none")]
            $(#[serde(rename = $key)])?
            $(#[$field])*
            pub $name: Option<$type>,
        ] $($rest)* }
    };
    (@struct $meta:tt $request:ident [$($done:tt)*]
        $(#[$field:meta])* flatten $name:ident : $type:ty, $($rest:tt)*
    ) => {
        request! { @struct $meta $request [
            $($done)*
            #[serde(flatten)]
            #[schema(inline)]
            $(#[$field])*
            pub $name: $type,
        ] $($rest)* }
    };
    (@struct [$($meta:tt)*] $request:ident [$($done:tt)*]) => {
        #[derive(Clone, Debug, PartialEq, serde::Serialize, utoipa::ToSchema)]
        $($meta)*
        pub struct $request {
            $($done)*
        }
    };

    // What a text has of a member: members of its own, what was read in passing, or its text.
    (@type $life:lifetime flatten $type:ty) => {
        <$type as $crate::api::json::request::Request>::Members<$life>
    };
    (@type $life:lifetime $kind:ident $type:ty, $reader:ident) => { Option<$reader<$life>> };
    (@type $life:lifetime $kind:ident $type:ty) => { $crate::api::json::members::Member<$life, $type> };

    (@new $request:ident flatten $at:ident, $key:expr) => { $crate::api::json::members::Members::at($at) };
    (@new $request:ident $kind:ident $at:ident, $key:expr, $reader:ident) => {{
        let _: &str = $at;
        None
    }};
    (@new $request:ident $kind:ident $at:ident, $key:expr) => {
        $crate::api::json::members::Member::new($key, $at, $crate::api::json::check::schema_of::<$request>)
    };

    (@take flatten $member:tt, $key:expr, $name:ident, $cursor:ident) => {
        let taken = $crate::api::json::members::Members::take(&mut $member, $name, $cursor)?;
        if taken != $crate::api::json::members::Taken::Unknown {
            return Ok(taken);
        }
    };
    (@take $kind:ident $member:tt, $key:expr, $name:ident, $cursor:ident, $reader:ident) => {
        if $name == $key {
            let read = <$reader<'_> as $crate::api::json::members::ReadInPassing<'_>>::read($cursor)?;
            return Ok($crate::api::json::members::Taken::of($member.replace(read).is_some()));
        }
    };
    (@take $kind:ident $member:tt, $key:expr, $name:ident, $cursor:ident) => {
        if $name == $key {
            return Ok($crate::api::json::members::Taken::of($member.take($cursor)?));
        }
    };

    (@list flatten $member:tt, $key:expr, $names:ident) => {
        $crate::api::json::members::Members::list(&$member, $names)
    };
    (@list $kind:ident $member:tt, $key:expr, $names:ident, $reader:ident) => {
        $names.push(($key, $member.is_some()))
    };
    (@list $kind:ident $member:tt, $key:expr, $names:ident) => { $names.push(($key, $member.is_given())) };

    (@whole [] $($rest:tt)*) => {};
    (@whole [whole] $request:ident $members:ident $($kind:ident $name:ident)*) => {
        impl $crate::api::json::request::ReadWhole for $request {
            fn read(members: &$members<'_>, faults: &mut $crate::api::faults::Faults) -> Option<Self> {
                $(let $name = request!(@value $kind (members.$name), faults);)*
                Some($request { $($name: $name?),* })
            }
        }
    };
    (@value required $member:expr, $faults:ident) => { $member.required($faults) };
    (@value optional $member:expr, $faults:ident) => { $member.optional($faults) };
    (@value flatten $member:expr, $faults:ident) => {
        $crate::api::json::request::ReadWhole::read(&$member, $faults)
    };

    (@key $name:ident $key:tt) => { $key };
    (@key $name:ident) => { stringify!($name) };
}

pub(in crate::api) use request;
