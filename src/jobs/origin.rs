//! Origin of requests.

use std::{net::IpAddr, sync::Arc};

/// Origin of a request.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Origin {
    pub request_id: Option<Arc<str>>,
    pub peer: Option<IpAddr>,
}
