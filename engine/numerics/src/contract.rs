//! Parts of the contract that derives cannot express: values that are written as a name, as a
//! number or as an array, and types that are written in another form.

#[doc(hidden)]
pub use serde;
#[doc(hidden)]
pub use utoipa;

use serde::de::{Error, MapAccess};
use serde_json::Value;
use utoipa::openapi::{
    RefOr,
    schema::{ArrayBuilder, ObjectBuilder, Schema, Type},
};

use crate::check::Faults;

/// Returns the error of a deserializer for a value that is well-formed and cannot be used: a line
/// for each fault.
pub fn refused<E: Error>(faults: Faults) -> E {
    let lines: Vec<String> = faults.list().iter().map(ToString::to_string).collect();
    E::custom(lines.join("\n"))
}

/// Reads the rest of an object whose first member is not its `type`. Returns the type and the other
/// members.
#[doc(hidden)]
pub fn tag_and_rest<'de, A: MapAccess<'de>>(first: Option<String>, mut map: A) -> Result<(String, Value), A::Error> {
    let mut members = serde_json::Map::new();
    let mut next = first;
    while let Some(name) = next {
        members.insert(name, map.next_value()?);
        next = map.next_key()?;
    }
    match members.remove("type") {
        Some(Value::String(tag)) => Ok((tag, Value::Object(members))),
        Some(_) => Err(A::Error::custom("`type` is not a string")),
        None => Err(A::Error::missing_field("type")),
    }
}

/// Implements `Deserialize` for an enum that is written with the member `type`, and whose variants
/// hold one struct each.
///
/// The implementation that serde derives keeps a copy of the whole object until it knows the type,
/// which takes several times the memory of long arrays. This one keeps nothing where `type` is the
/// first member. It asks its deserializer for a struct with `type` as only field, so that one which
/// can look ahead may begin with this member.
///
/// ```text
/// tagged!(Shape { "circle" => Circle, "square" => Square });
/// // with a method that returns the type
/// tagged!(Shape as name { "circle" => Circle, "square" => Square });
/// ```
#[macro_export]
macro_rules! tagged {
    ($union:ident as $tag:ident { $($name:literal => $variant:ident),+ $(,)? }) => {
        $crate::tagged!($union { $($name => $variant),+ });

        impl $union {
            /// Returns the value of `type`.
            pub fn $tag(&self) -> &'static str {
                match self {
                    $($union::$variant(_) => $name,)+
                }
            }
        }
    };
    ($union:ident { $($name:literal => $variant:ident),+ $(,)? }) => {
        const _: () = {
            use $crate::contract::serde::{
                Deserialize, Deserializer,
                de::{Error, MapAccess, Visitor, value::MapAccessDeserializer},
            };

            fn variant<'de, D: Deserializer<'de>>(name: &str, members: D) -> Result<$union, D::Error> {
                match name {
                    $($name => Deserialize::deserialize(members).map($union::$variant),)+
                    other => Err(D::Error::unknown_variant(other, &[$($name),+])),
                }
            }

            struct Union;

            impl<'de> Visitor<'de> for Union {
                type Value = $union;

                fn expecting(&self, f: &mut ::std::fmt::Formatter) -> ::std::fmt::Result {
                    f.write_str("an object")
                }

                fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<$union, A::Error> {
                    let first: Option<String> = map.next_key()?;
                    if first.as_deref() == Some("type") {
                        let name: String = map.next_value()?;
                        return variant(&name, MapAccessDeserializer::new(map));
                    }
                    let (name, members) = $crate::contract::tag_and_rest(first, map)?;
                    variant(&name, members).map_err(A::Error::custom)
                }
            }

            impl<'de> Deserialize<'de> for $union {
                fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                    deserializer.deserialize_struct(stringify!($union), &["type"], Union)
                }
            }
        };
    };
}

/// Reads a list of numbers in which `null` is no number.
pub fn with_gaps<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Vec<f64>, D::Error> {
    let list: Vec<Option<f64>> = serde::Deserialize::deserialize(deserializer)?;
    Ok(list.into_iter().map(|x| x.unwrap_or(f64::NAN)).collect())
}

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

/// Gives a type the schema of a union of plain values, under its own name or another one.
///
/// ```text
/// alternatives!(Count, "Number of eigenvalues: a number or `auto`.", name("auto"), whole(0));
/// alternatives!(CountBody as "Count", "…", name("auto"), whole(0));
/// // with the value where it is left out
/// alternatives!(Count = "auto", "…", name("auto"), whole(0));
/// ```
#[macro_export]
macro_rules! alternatives {
    ($type:ident $(as $name:literal)? $(= $default:literal)?, $description:expr, $($item:expr),+ $(,)?) => {
        impl $crate::contract::utoipa::PartialSchema for $type {
            fn schema() -> $crate::contract::utoipa::openapi::RefOr<$crate::contract::utoipa::openapi::schema::Schema> {
                $crate::contract::utoipa::openapi::schema::OneOfBuilder::new()
                    .description(Some($description))
                    $(.default(Some($default.into())))?
                    $(.item($item))+
                    .into()
            }
        }

        impl $crate::contract::utoipa::ToSchema for $type {
            fn name() -> ::std::borrow::Cow<'static, str> {
                [$($name,)? stringify!($type)][0].into()
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
