//! Settings of the identity provider.

use std::{path::PathBuf, time::Duration};

use clap::Args;

/// Interval between requests for the provider's keys.
const REFRESH: Duration = Duration::from_secs(600);

/// Accepted audiences of tokens; a token must have one of them.
pub type Audiences = Vec<String>;

#[derive(Clone, Debug, PartialEq, Eq, Args)]
pub struct OidcSettings {
    /// Issuer URL of the identity provider whose tokens (JWT) are accepted in addition to keys; its
    /// keys are found by `/.well-known/openid-configuration` there.
    #[arg(
        long = "oidc-issuer",
        env = "FLANKFIT_OIDC_ISSUER",
        requires = "audience",
        value_parser = parse_issuer,
        hide_env_values = true
    )]
    pub issuer: Option<String>,
    /// Audience that tokens must have; of several, comma-separated, one.
    #[arg(
        long = "oidc-audience",
        env = "FLANKFIT_OIDC_AUDIENCE",
        requires = "issuer",
        value_parser = parse_audiences
    )]
    pub audience: Option<Audiences>,
    /// Claim with the role of a token's holder (a name or a list of names; `a.b` is `b` within
    /// `a`).
    #[arg(long = "oidc-role-claim", env = "FLANKFIT_OIDC_ROLE_CLAIM", default_value = "role")]
    pub role_claim: String,
    /// Claim with the tenant of a token's holder; without it the tenant is `default`.
    #[arg(long = "oidc-tenant-claim", env = "FLANKFIT_OIDC_TENANT_CLAIM", requires = "issuer")]
    pub tenant_claim: Option<String>,
    /// URL of the provider's keys (JWKS), if the issuer does not publish it.
    #[arg(
        long = "oidc-jwks-url",
        env = "FLANKFIT_OIDC_JWKS_URL",
        requires = "issuer",
        value_parser = parse_issuer,
        hide_env_values = true
    )]
    pub jwks_url: Option<String>,
    /// File (PEM) with the certificate authorities of the provider; default those that browsers
    /// trust.
    #[arg(long = "oidc-ca", env = "FLANKFIT_OIDC_CA", requires = "issuer")]
    pub authorities: Option<PathBuf>,
    /// Interval between requests for the provider's keys; not an option, shorter in tests.
    #[arg(skip = REFRESH)]
    pub refresh: Duration,
}

/// Reads a URL with TLS; without TLS for this machine only.
fn parse_issuer(text: &str) -> Result<String, String> {
    let text = text.trim();
    let secure = text.strip_prefix("https://").is_some_and(|rest| !rest.is_empty());
    let plain = |host: &str| {
        let rest = text.strip_prefix("http://").and_then(|rest| rest.strip_prefix(host));
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with([':', '/']))
    };
    if text.contains(['?', '#', '@']) || text.contains(char::is_whitespace) {
        return Err("write a URL without query, fragment and user".into());
    }
    if secure || ["localhost", "127.0.0.1", "[::1]"].into_iter().any(plain) {
        return Ok(text.to_owned());
    }
    Err("write https://HOST/…; http:// is for a provider on this machine alone".into())
}

fn parse_audiences(text: &str) -> Result<Audiences, String> {
    let audiences: Audiences = text.split(',').map(|audience| audience.trim().to_owned()).collect();
    if audiences.iter().any(String::is_empty) {
        return Err("write what tokens for this server have as their audience".into());
    }
    Ok(audiences)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_that_is_taken_back_is_refused_within_ten_minutes() {
        assert_eq!(OidcSettings::default().refresh, Duration::from_secs(10 * 60));
    }

    #[test]
    fn issuers_need_https_except_on_this_machine() {
        for good in ["https://id.example/realms/plant", "http://127.0.0.1:8080/x", "http://localhost", "http://[::1]:1"]
        {
            assert_eq!(parse_issuer(good).as_deref(), Ok(good));
        }
        for bad in [
            "",
            "id.example",
            "http://id.example",
            "http://localhost.example",
            "http://127.0.0.1.example",
            "https://",
            "https://a b",
            "https://u:p@id.example",
            "https://id.example/?x",
            "ftp://id.example",
        ] {
            assert!(parse_issuer(bad).is_err(), "{bad}");
        }
        assert_eq!(parse_audiences("flankfit, cell"), Ok(vec!["flankfit".to_owned(), "cell".to_owned()]));
        assert!(parse_audiences("a,").is_err() && parse_audiences("").is_err());
    }
}
