//! Reads rows by the names of their columns.

/// Makes types readable from the rows of both databases: each field from the column of its name, or
/// of the name after `=`. Fields after `@` are read from further columns of the same row; those
/// after `;` are empty.
///
/// (sqlx derives the same; its procedural macros build sqlx and all that it depends on a second
/// time.)
macro_rules! from_row {
    ($($Of:ident $(<$T:ident>)? {
        $(@ $inner:ident,)* $($field:ident $(= $column:literal)?),* $(,)? $(; $($empty:ident),*)?
    })*) => {
        $(
            from_row!(@of sqlx::sqlite::SqliteRow, $Of $(<$T>)? {
                $($inner,)*
            } { $($field $(= $column)?),* } { $($($empty),*)? });
            from_row!(@of sqlx::postgres::PgRow, $Of $(<$T>)? {
                $($inner,)*
            } { $($field $(= $column)?),* } { $($($empty),*)? });
        )*
    };
    (@of $Row:ty, $Of:ident $(<$T:ident>)? {
        $($inner:ident,)*
    } { $($field:ident $(= $column:literal)?),* } { $($empty:ident),* }) => {
        impl<'r $(, $T: sqlx::FromRow<'r, $Row>)?> sqlx::FromRow<'r, $Row> for $Of $(<$T>)? {
            fn from_row(row: &'r $Row) -> Result<Self, sqlx::Error> {
                Ok($Of {
                    $($inner: sqlx::FromRow::from_row(row)?,)*
                    $($field: $crate::store::sql::column(row, from_row!(@name $field $(= $column)?))?,)*
                    $($empty: Default::default(),)*
                })
            }
        }
    };
    (@name $field:ident) => { stringify!($field) };
    (@name $field:ident = $column:literal) => { $column };
}

/// Declares a struct that is read by the names of its columns, and of those after `@`.
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

        from_row! { $name $(<$T>)? { $(@ $inner,)* $($field),* } }
    };
}
