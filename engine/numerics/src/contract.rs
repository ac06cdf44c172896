//! Parts of the contract that derives cannot express: values that are written as a name, as a
//! number or as an array, and types that are written in another form.

#[doc(hidden)]
pub use serde;
#[doc(hidden)]
pub use utoipa;

use utoipa::openapi::{
    RefOr,
    schema::{ArrayBuilder, ObjectBuilder, Schema, Type},
};

/// Returns the schema of one name.
pub fn name(name: &str) -> ObjectBuilder {
    names([name])
}

/// Returns the schema of one of several names.
pub fn names<'a>(names: impl IntoIterator<Item = &'a str>) -> ObjectBuilder {
    ObjectBuilder::new().schema_type(Type::String).enum_values(Some(names))
}

/// Returns the schema of a number.
pub fn number() -> ObjectBuilder {
    ObjectBuilder::new().schema_type(Type::Number)
}

/// Returns the schema of a whole number of at least `minimum`.
pub fn whole(minimum: u32) -> ObjectBuilder {
    ObjectBuilder::new().schema_type(Type::Integer).minimum(Some(minimum))
}

/// Returns the schema of an array, with its least and greatest length.
pub fn list(items: impl Into<RefOr<Schema>>, lengths: Option<(usize, usize)>) -> ArrayBuilder {
    ArrayBuilder::new().items(items.into()).min_items(lengths.map(|l| l.0)).max_items(lengths.map(|l| l.1))
}

/// Gives a type the schema of a union of plain values.
///
/// ```text
/// alternatives!(Count, "Number of eigenvalues: a number or `auto`.", name("auto"), whole(0));
/// ```
#[macro_export]
macro_rules! alternatives {
    ($type:ident, $description:expr, $($item:expr),+ $(,)?) => {
        impl $crate::contract::utoipa::PartialSchema for $type {
            fn schema() -> $crate::contract::utoipa::openapi::RefOr<$crate::contract::utoipa::openapi::schema::Schema> {
                $crate::contract::utoipa::openapi::schema::OneOfBuilder::new()
                    .description(Some($description))
                    $(.item($item))+
                    .into()
            }
        }

        impl $crate::contract::utoipa::ToSchema for $type {
            fn name() -> ::std::borrow::Cow<'static, str> {
                stringify!($type).into()
            }
        }
    };
}

/// Declares a module for `#[serde(with = "…")]` of a unit variant that is written as a name, in an
/// enum without tag.
#[macro_export]
macro_rules! constant {
    ($module:ident = $name:literal) => {
        mod $module {
            use $crate::contract::serde::{self, Deserialize, Deserializer, Serializer};

            #[derive(Deserialize)]
            #[serde(crate = "serde")]
            enum Name {
                #[serde(rename = $name)]
                Name,
            }

            pub(super) fn serialize<S: Serializer>(serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str($name)
            }

            pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<(), D::Error> {
                Name::deserialize(deserializer).map(|Name::Name| ())
            }
        }
    };
}

/// Gives a type the schema of the form that it is written in.
#[macro_export]
macro_rules! written_as {
    ($type:ty, $form:ty) => {
        impl $crate::contract::utoipa::PartialSchema for $type {
            fn schema() -> $crate::contract::utoipa::openapi::RefOr<$crate::contract::utoipa::openapi::schema::Schema> {
                <$form as $crate::contract::utoipa::PartialSchema>::schema()
            }
        }

        impl $crate::contract::utoipa::ToSchema for $type {
            fn name() -> ::std::borrow::Cow<'static, str> {
                <$form as $crate::contract::utoipa::ToSchema>::name()
            }

            fn schemas(
                schemas: &mut Vec<(
                    String,
                    $crate::contract::utoipa::openapi::RefOr<$crate::contract::utoipa::openapi::schema::Schema>,
                )>,
            ) {
                <$form as $crate::contract::utoipa::ToSchema>::schemas(schemas);
            }
        }
    };
}
