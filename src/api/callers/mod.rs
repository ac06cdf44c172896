//! Keys, tenants, and who asks.

pub mod key;
pub mod names;
mod offered;
pub mod tenant;
pub mod whoami;
