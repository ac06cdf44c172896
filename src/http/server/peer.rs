//! Address of the client: the connected one, or the one that a trusted proxy names.

use std::{
    net::{IpAddr, SocketAddr},
    sync::Arc,
};

use axum::http::HeaderMap;

use crate::{config::Networks, jobs::San};

/// Header to which proxies append the addresses of their clients.
const FORWARDED_FOR: &str = "x-forwarded-for";

/// The names in the certificate that the client has shown (a request extension).
#[derive(Clone, Debug)]
pub struct PeerNames(pub Arc<[San]>);

/// The address of the client (a request extension).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Peer(pub IpAddr);

impl Peer {
    /// Goes back from the one who is `connected`, as long as a trusted proxy speaks.
    pub fn of(connected: IpAddr, headers: &HeaderMap, trusted: &Networks) -> Self {
        let mut peer = connected.to_canonical();
        let lists: Vec<&str> = headers.get_all(FORWARDED_FOR).iter().filter_map(|list| list.to_str().ok()).collect();
        for before in lists.iter().rev().flat_map(|list| list.rsplit(',')) {
            if !trusted.contain(peer) {
                break;
            }
            match address(before.trim()) {
                Some(address) => peer = address.to_canonical(),
                None => break,
            }
        }
        Peer(peer)
    }
}

/// An address, perhaps with a port behind it.
fn address(text: &str) -> Option<IpAddr> {
    let bare = text.strip_prefix('[').and_then(|text| text.strip_suffix(']')).unwrap_or(text);
    bare.parse().ok().or_else(|| text.parse::<SocketAddr>().ok().map(|address| address.ip()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::parse_networks;

    fn peer(connected: &str, forwarded: &[&'static str]) -> String {
        let mut headers = HeaderMap::new();
        for list in forwarded {
            headers.append(FORWARDED_FOR, list.parse().unwrap());
        }
        let trusted = parse_networks("10.0.0.0/8").unwrap();
        Peer::of(connected.parse().unwrap(), &headers, &trusted).0.to_string()
    }

    #[test]
    fn only_trusted_proxies_are_believed() {
        assert_eq!(peer("192.0.2.1", &["198.51.100.7"]), "192.0.2.1");
        assert_eq!(peer("10.0.0.1", &["198.51.100.7"]), "198.51.100.7");
        assert_eq!(peer("::ffff:10.0.0.1", &["198.51.100.7:4711"]), "198.51.100.7");
        assert_eq!(peer("10.0.0.1", &["[2001:db8::1]:80"]), "2001:db8::1");
        assert_eq!(peer("10.0.0.1", &[]), "10.0.0.1");
    }

    #[test]
    fn the_last_forwarded_address_is_the_peer() {
        assert_eq!(peer("10.0.0.1", &["127.0.0.1, 198.51.100.7, 10.0.0.2"]), "198.51.100.7");
        assert_eq!(peer("10.0.0.1", &["127.0.0.1", "198.51.100.7"]), "198.51.100.7");
        assert_eq!(peer("10.0.0.1", &["198.51.100.7, unknown"]), "10.0.0.1");
    }
}
