//! Origin of requests.

use std::{net::IpAddr, sync::Arc};

/// Where a request came from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Origin {
    pub request_id: Option<Arc<str>>,
    pub peer: Option<IpAddr>,
}
