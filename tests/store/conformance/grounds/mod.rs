//! The stores that there are.

pub mod sqlite;
