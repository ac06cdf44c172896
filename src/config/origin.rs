//! Origins of web pages that may call.

/// Origin of a web page as browsers write it: scheme, host, and the port unless it is the default
/// of the scheme.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin(String);

/// Origins of all pages that may call.
pub type Origins = Vec<Origin>;

impl Origin {
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

/// Origins separated by commas; an empty text has none.
pub fn parse_origins(text: &str) -> Result<Origins, String> {
    if text.trim().is_empty() {
        return Ok(Vec::new());
    }
    text.split(',').map(|origin| parse_origin(origin.trim())).collect()
}

fn parse_origin(text: &str) -> Result<Origin, String> {
    const FORM: &str =
        "write SCHEME://HOST or SCHEME://HOST:PORT, such as https://cell.example or http://localhost:3000";
    let refused = |why: &str| format!("`{text}` is not an origin: {why}; {FORM}");
    let lower = text.to_ascii_lowercase();
    let (scheme, authority) = lower.split_once("://").ok_or_else(|| refused("it has no scheme"))?;
    if !matches!(scheme, "http" | "https") {
        return Err(refused("its scheme is neither http nor https"));
    }
    if authority.contains(['/', '?', '#']) {
        return Err(refused("it has a path"));
    }
    if authority.contains('*') {
        return Err(refused("origins are named, there are no wildcards"));
    }
    let (host, port) = match authority.rsplit_once(':') {
        // the colons of an IPv6 address are its own
        Some((host, port)) if !port.ends_with(']') => {
            let port = port.parse::<u16>().map_err(|_| refused("its port is not a number up to 65535"))?;
            (host, Some(port))
        }
        _ => (authority, None),
    };
    let of_name = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_');
    let address = host.strip_prefix('[').and_then(|host| host.strip_suffix(']'));
    let valid = match address {
        Some(address) => address.parse::<std::net::Ipv6Addr>().is_ok(),
        None => !host.is_empty() && host.chars().all(of_name),
    };
    if !valid {
        return Err(refused("its host is not a name or an address"));
    }
    let usual = if scheme == "https" { 443 } else { 80 };
    let port = port.filter(|port| *port != usual).map_or(String::new(), |port| format!(":{port}"));
    Ok(Origin(format!("{scheme}://{host}{port}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn origins_are_those_that_browsers_send() {
        let of =
            |text: &str| parse_origins(text).map(|all| all.into_iter().map(|Origin(text)| text).collect::<Vec<_>>());
        assert_eq!(of(" "), Ok(vec![]));
        assert_eq!(
            of("https://Cell.example:443, http://localhost:3000,http://[::1]:80"),
            Ok(vec!["https://cell.example".into(), "http://localhost:3000".into(), "http://[::1]".into()])
        );
        for (text, why) in [
            ("*", "no scheme"),
            ("null", "no scheme"),
            ("cell.example", "no scheme"),
            ("ftp://cell.example", "neither http nor https"),
            ("https://cell.example/", "a path"),
            ("https://*.example", "no wildcards"),
            ("https://cell.example:x", "not a number"),
            ("https://", "not a name"),
            ("https://a b", "not a name"),
            ("https://a@b", "not a name"),
            ("https://cell.example,", "no scheme"),
        ] {
            assert!(of(text).unwrap_err().contains(why), "{text}");
        }
    }
}
