//! Addresses to listen on.

use std::net::{SocketAddr, ToSocketAddrs};

/// An address with a port, or a name with one. Of a name's addresses the first of IPv4 is taken,
/// else the first.
pub fn parse_address(text: &str) -> Result<SocketAddr, String> {
    const FORM: &str = "write ADDRESS:PORT, such as 127.0.0.1:8080, [::1]:8080 or localhost:8080";
    let found = text.to_socket_addrs().map_err(|error| match error.kind() {
        std::io::ErrorKind::InvalidInput => FORM.to_owned(),
        _ => format!("the name is not known here ({error}); {FORM}"),
    })?;
    let found: Vec<SocketAddr> = found.collect();
    found.iter().find(|address| address.is_ipv4()).or(found.first()).copied().ok_or_else(|| FORM.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_addresses_too() {
        assert_eq!(parse_address("[::1]:80").map(|address| address.port()), Ok(80));
        assert!(
            parse_address("localhost:8080").is_ok_and(|address| address.ip().is_loopback() && address.port() == 8080)
        );
        for wrong in ["", "8080", "127.0.0.1", "localhost:", "localhost:99999"] {
            assert!(parse_address(wrong).unwrap_err().contains("ADDRESS:PORT"), "{wrong}");
        }
    }
}
