//! One declaration of an object of an answer: from it come the struct that clients read and tests
//! compare, its schema, and the writer that goes from the domain's value to text at once.
//!
//! `answer!` takes the wire struct, the domain type with a pattern that takes it apart completely
//! (so a field that is added there and not written does not compile), and for each field its
//! documentation, name, wire type and the expression that is written. `name?` is a field that is
//! left out when its value does not exist; `name as "key"` has another name on the wire; what is
//! included is at hand as the name after `with`, the value itself as the one after `as`. `names!`
//! does the same for an enum of names.
//!
//! How an expression is written follows from its type alone ([`WriteAs`]), without dispatch at run
//! time and without an allocation.

use std::borrow::Cow;

use serde::Serialize;

use crate::api::json::writer::Object;
use flankfit_engine::estimation::spec::Include;

/// A value of the domain that is written as the wire type `W`.
pub trait WriteAs<W> {
    fn write_as(&self, object: &mut Object<'_>, name: &'static str, include: &Include);
}

/// A value of the domain that is written as an entry `W` of a list.
pub trait ListAs<W>: Sized {
    fn list_as(items: &[Self], object: &mut Object<'_>, name: &'static str, include: &Include);
}

/// A value of the domain whose fields are those of the object `W`.
pub trait FieldsAs<W> {
    fn fields_as(&self, object: &mut Object<'_>, include: &Include);
}

/// Declares an object of an answer, see the module's documentation.
macro_rules! answer {
    (
        $(#[$meta:meta])*
        pub struct $wire:ident from $domain:ident $(<$life:lifetime>)? $(as $whole:ident)? { $($pattern:tt)* }
        $(with $include:ident)? {
            $($fields:tt)*
        }
    ) => {
        answer! { @struct [$(#[$meta])*] $wire [] $($fields)* }

        impl $(<$life>)? FieldsAs<$wire> for $domain $(<$life>)? {
            fn fields_as(&self, object: &mut Object<'_>, include: &Include) {
                let $domain { $($pattern)* } = self;
                $(let $whole = self;)?
                $(let $include = include;)?
                answer! { @write object include $($fields)* }
            }
        }

        impl $(<$life>)? WriteAs<$wire> for $domain $(<$life>)? {
            fn write_as(&self, object: &mut Object<'_>, name: &'static str, include: &Include) {
                object.object(name, |object| FieldsAs::<$wire>::fields_as(self, object, include));
            }
        }

        impl $(<$life>)? ListAs<$wire> for $domain $(<$life>)? {
            fn list_as(items: &[Self], object: &mut Object<'_>, name: &'static str, include: &Include) {
                object.list(name, items, |object, item| FieldsAs::<$wire>::fields_as(item, object, include));
            }
        }
    };

    // The struct, field by field: those that may be left out, and those that may not.
    (@struct $meta:tt $wire:ident [$($done:tt)*]
        $(#[$field:meta])* $name:ident $(as $key:tt)? ?: $type:ty = $value:expr, $($rest:tt)*
    ) => {
        answer! { @struct $meta $wire [
            $($done)*
            #[serde(default, skip_serializing_if = "Option::is_none")]
            $(#[serde(rename = $key)])?
            $(#[$field])*
            pub $name: Option<$type>,
        ] $($rest)* }
    };
    (@struct $meta:tt $wire:ident [$($done:tt)*]
        $(#[$field:meta])* $name:ident $(as $key:tt)? : $type:ty = $value:expr, $($rest:tt)*
    ) => {
        answer! { @struct $meta $wire [
            $($done)*
            $(#[serde(rename = $key)])?
            $(#[$field])*
            pub $name: $type,
        ] $($rest)* }
    };
    (@struct [$($meta:tt)*] $wire:ident [$($done:tt)*]) => {
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, utoipa::ToSchema)]
        $($meta)*
        pub struct $wire {
            $($done)*
        }
    };

    // The writer, field by field.
    (@write $object:ident $include:ident
        $(#[$field:meta])* $name:ident $(as $key:tt)? ?: $type:ty = $value:expr, $($rest:tt)*
    ) => {
        WriteAs::<Option<$type>>::write_as(&$value, $object, answer!(@key $name $($key)?), $include);
        answer! { @write $object $include $($rest)* }
    };
    (@write $object:ident $include:ident
        $(#[$field:meta])* $name:ident $(as $key:tt)? : $type:ty = $value:expr, $($rest:tt)*
    ) => {
        WriteAs::<$type>::write_as(&$value, $object, answer!(@key $name $($key)?), $include);
        answer! { @write $object $include $($rest)* }
    };
    (@write $object:ident $include:ident) => {};

    (@key $name:ident $key:tt) => { $key };
    (@key $name:ident) => { stringify!($name) };
}
pub(super) use answer;

/// Declares an enum of names of an answer, from an enum of the domain with the same variants.
macro_rules! names {
    (
        $(#[$meta:meta])*
        pub enum $wire:ident from $domain:ty {
            $($(#[$variant_meta:meta])* $variant:ident = $name:tt,)*
        }
    ) => {
        #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, utoipa::ToSchema)]
        $(#[$meta])*
        pub enum $wire {
            $(
                $(#[$variant_meta])*
                #[serde(rename = $name)]
                $variant,
            )*
        }

        impl WriteAs<$wire> for $domain {
            fn write_as(&self, object: &mut Object<'_>, name: &'static str, _: &Include) {
                let text = match self {
                    $(<$domain>::$variant => $name,)*
                };
                object.word(name, text);
            }
        }
    };
}
pub(super) use names;

/// A name that is written as it is.
pub struct Name(pub &'static str);

/// Finished JSON.
pub struct Raw<'a>(pub &'a str);

/// What serde writes.
pub struct Serialized<T>(pub T);

/// Rows of a symmetric matrix, of which half is copied.
pub struct Symmetric<'a>(pub &'a [Vec<f64>]);

/// Writes one type as another by a method of [`Object`].
macro_rules! written {
    ($($domain:ty as $wire:ty: |$object:ident, $name:ident, $value:ident| $write:expr;)*) => {$(
        impl WriteAs<$wire> for $domain {
            fn write_as(&self, $object: &mut Object<'_>, $name: &'static str, _: &Include) {
                let $value = self;
                $write;
            }
        }
    )*};
}

written! {
    f64 as f64: |object, name, value| object.number(name, *value);
    usize as usize: |object, name, value| object.count(name, *value);
    bool as bool: |object, name, value| object.field(name, value);
    String as String: |object, name, value| object.string(name, value);
    str as String: |object, name, value| object.string(name, value);
    str as Cow<'static, str>: |object, name, value| object.string(name, value);
    [f64; 2] as [f64; 2]: |object, name, value| object.numbers(name, value);
    Symmetric<'_> as Vec<Vec<f64>>: |object, name, rows| object.symmetric_rows(name, rows.0);
}

impl<W> WriteAs<W> for Name {
    fn write_as(&self, object: &mut Object<'_>, name: &'static str, _: &Include) {
        object.word(name, self.0);
    }
}

impl<W> WriteAs<W> for Raw<'_> {
    fn write_as(&self, object: &mut Object<'_>, name: &'static str, _: &Include) {
        object.raw(name, self.0);
    }
}

impl<W: Serialize> WriteAs<W> for Serialized<W> {
    fn write_as(&self, object: &mut Object<'_>, name: &'static str, _: &Include) {
        object.field(name, &self.0);
    }
}

impl<W, T: WriteAs<W>> WriteAs<Option<W>> for Option<T> {
    fn write_as(&self, object: &mut Object<'_>, name: &'static str, include: &Include) {
        if let Some(value) = self {
            value.write_as(object, name, include);
        }
    }
}

impl<W, T: WriteAs<W> + ?Sized> WriteAs<W> for &T {
    fn write_as(&self, object: &mut Object<'_>, name: &'static str, include: &Include) {
        T::write_as(self, object, name, include);
    }
}

impl<W, T: ListAs<W>> WriteAs<Vec<W>> for Vec<T> {
    fn write_as(&self, object: &mut Object<'_>, name: &'static str, include: &Include) {
        T::list_as(self, object, name, include);
    }
}

/// Writes lists of one type by a method of [`Object`].
macro_rules! listed {
    ($($entry:ty: $method:ident;)*) => {$(
        impl ListAs<$entry> for $entry {
            fn list_as(items: &[Self], object: &mut Object<'_>, name: &'static str, _: &Include) {
                object.$method(name, items);
            }
        }
    )*};
}

listed! {
    f64: numbers;
    usize: counts;
    String: strings;
    Vec<f64>: rows;
    [f64; 2]: pairs;
    Option<f64>: numbers_or_null;
}
