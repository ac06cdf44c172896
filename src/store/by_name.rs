//! Declares rows that are read by the names of their columns.

/// Declares a struct with a field for each column, and after `@` rows that take further columns of
/// the same row.
///
/// (sqlx derives the same; its procedural macros build sqlx and all that it depends on a second
/// time.)
macro_rules! row {
    (
        $(#[$meta:meta])*
        $vis:vis struct $name:ident $(<$T:ident>)? {
            $(@ $inner_vis:vis $inner:ident: $Inner:ty,)*
            $($(#[$field_meta:meta])* $field_vis:vis $field:ident: $Field:ty),* $(,)?
        }
    ) => {
        $(#[$meta])*
        $vis struct $name $(<$T>)? {
            $($inner_vis $inner: $Inner,)*
            $($(#[$field_meta])* $field_vis $field: $Field,)*
        }

        impl<'r, R: sqlx::Row $(, $T)?> sqlx::FromRow<'r, R> for $name $(<$T>)?
        where
            &'static str: sqlx::ColumnIndex<R>,
            $($Inner: sqlx::FromRow<'r, R>,)*
            $($Field: sqlx::Decode<'r, R::Database> + sqlx::Type<R::Database>,)*
        {
            fn from_row(row: &'r R) -> Result<Self, sqlx::Error> {
                Ok($name {
                    $($inner: sqlx::FromRow::from_row(row)?,)*
                    $($field: row.try_get(stringify!($field))?,)*
                })
            }
        }
    };
}
