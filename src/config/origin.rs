//! Origins of web pages that may call.

use super::{bounds::parse_list, host::Host};

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

/// Reads origins separated by commas; an empty text has none.
pub fn parse_origins(text: &str) -> Result<Origins, String> {
    parse_list(text, parse_origin)
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
    let host = Host::read(authority).ok_or_else(|| refused("its host is not a name or an address with a port"));
    let Host { name, port } = host?;
    let usual = if scheme == "https" { 443 } else { 80 };
    let port = port.filter(|port| *port != usual).map_or(String::new(), |port| format!(":{port}"));
    Ok(Origin(format!("{scheme}://{name}{port}")))
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
            ("https://cell.example:x", "not a name"),
            ("https://", "not a name"),
            ("https://a b", "not a name"),
            ("https://a@b", "not a name"),
            ("https://cell.example,", "no scheme"),
        ] {
            assert!(of(text).unwrap_err().contains(why), "{text}");
        }
    }
}
