//! The stores that there are.

pub mod postgres;
pub mod sqlite;
