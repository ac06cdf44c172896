//! Schemas of values that take one of two forms.

use utoipa::openapi::{
    RefOr,
    schema::{ArrayBuilder, ObjectBuilder, Schema, Type},
};

/// A whole number from `minimum` on.
pub fn whole(minimum: u32) -> ObjectBuilder {
    ObjectBuilder::new().schema_type(Type::Integer).minimum(Some(minimum))
}

/// An array, of so many entries at least and at most.
pub fn list(items: impl Into<RefOr<Schema>>, lengths: Option<(usize, usize)>) -> ArrayBuilder {
    ArrayBuilder::new().items(items.into()).min_items(lengths.map(|l| l.0)).max_items(lengths.map(|l| l.1))
}

/// Documents a union of plain values under its name.
macro_rules! documented {
    ($body:ident, $name:literal, $description:literal, $first:expr, $second:expr $(,)?) => {
        impl utoipa::PartialSchema for $body {
            fn schema() -> utoipa::openapi::RefOr<utoipa::openapi::schema::Schema> {
                utoipa::openapi::schema::OneOfBuilder::new()
                    .description(Some($description))
                    .item($first)
                    .item($second)
                    .into()
            }
        }

        impl utoipa::ToSchema for $body {
            fn name() -> std::borrow::Cow<'static, str> {
                $name.into()
            }
        }
    };
}

pub(in crate::api) use documented;
