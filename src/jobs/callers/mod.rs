//! Who may do what: callers and their tenants, scopes and the roles that are made of them.

mod caller;
mod role;
mod scope;

pub use caller::{Caller, Owned, Tenant};
pub use role::Role;
pub use scope::{Scope, Scopes};
