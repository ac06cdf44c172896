//! Hosts that requests may name.

use super::bounds::parse_list;

/// A host as requests name it, with or without its port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Host {
    pub(super) name: String,
    pub(super) port: Option<u16>,
}

/// Hosts that requests may name; by default the usual ones.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Hosts {
    /// Hosts of this machine if it alone can call and needs no key, else all.
    #[default]
    Usual,
    Any,
    Named(Vec<Host>),
}

impl Host {
    /// Reads a header `Host`.
    pub fn read(text: &str) -> Option<Self> {
        let lower = text.trim().to_ascii_lowercase();
        let (name, port) = match lower.rsplit_once(':') {
            // the colons of an IPv6 address are its own
            Some((name, port)) if !port.ends_with(']') => (name, Some(port.parse().ok()?)),
            _ => (lower.as_str(), None),
        };
        let of_name = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_');
        let valid = match name.strip_prefix('[').and_then(|name| name.strip_suffix(']')) {
            Some(address) => address.parse::<std::net::Ipv6Addr>().is_ok(),
            None => !name.is_empty() && name.chars().all(of_name),
        };
        valid.then(|| Host { name: name.to_owned(), port })
    }

    /// True if a request to `asked` is one to this host: of a host without a port to any.
    pub fn is(&self, asked: &Host) -> bool {
        self.name == asked.name && (self.port.is_none() || self.port == asked.port)
    }

    /// True if the host is this machine by its address or name alone, whatever a name server says.
    pub fn is_this_machine(&self) -> bool {
        let address = self.name.trim_start_matches('[').trim_end_matches(']').parse::<std::net::IpAddr>();
        self.name == "localhost" || address.is_ok_and(|address| address.is_loopback())
    }
}

/// Reads hosts separated by commas, or `*` for all.
pub fn parse_hosts(text: &str) -> Result<Hosts, String> {
    let host = |text: &str| {
        let refused = || format!("`{text}` is not a host: write HOST or HOST:PORT, such as cell.example, or * for all");
        Host::read(text).ok_or_else(refused)
    };
    match text.trim() {
        "" => Ok(Hosts::Usual),
        "*" => Ok(Hosts::Any),
        text => parse_list(text, host).map(Hosts::Named),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hosts_are_read_as_requests_name_them() {
        let named = parse_hosts("Cell.example, 10.0.0.7:8080,[::1]").unwrap();
        let Hosts::Named(hosts) = &named else { panic!("{named:?}") };
        let among = |text: &str| Host::read(text).is_some_and(|asked| hosts.iter().any(|host| host.is(&asked)));
        for good in ["cell.example", "CELL.EXAMPLE:1234", "10.0.0.7:8080", "[::1]:80"] {
            assert!(among(good), "{good}");
        }
        for bad in ["cell.example.evil", "10.0.0.7", "10.0.0.7:80", "[::2]", "", "a b", "cell.example:x", "[::1"] {
            assert!(!among(bad), "{bad}");
        }
        assert_eq!((parse_hosts(" "), parse_hosts("*")), (Ok(Hosts::Usual), Ok(Hosts::Any)));
        assert!(parse_hosts("http://cell.example").unwrap_err().contains("HOST:PORT"));
    }

    #[test]
    fn this_machine_has_names_of_its_own() {
        let own = |text: &str| Host::read(text).unwrap().is_this_machine();
        assert!(own("localhost:8080") && own("127.0.0.1") && own("127.0.0.2:80") && own("[::1]:9"));
        assert!(!own("localhost.evil.example") && !own("127.0.0.1.evil.example") && !own("10.0.0.1"));
    }
}
