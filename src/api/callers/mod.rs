//! Keys, tenants, and who asks.

pub mod key;
pub mod names;
pub mod tenant;
pub mod whoami;
