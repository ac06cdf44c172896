//! Reasons for which tokens are refused.

/// Reason for refusing a token. Its contents are never returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TokenError {
    #[error("it cannot be read")]
    Malformed,
    #[error("it is signed by none of RS256, PS256, ES256 and EdDSA")]
    Algorithm,
    #[error("its header has a critical extension that is not supported")]
    Critical,
    #[error("the provider has no key of this name for its algorithm")]
    UnknownKey,
    #[error("its signature is not the provider's")]
    Signature,
    #[error("it is of another issuer")]
    Issuer,
    #[error("it is for another audience")]
    Audience,
    #[error("it has expired")]
    Expired,
    #[error("it is not valid yet")]
    NotYet,
    #[error("it lacks the claim `{0}`, or has it in another form")]
    Claim(&'static str),
    #[error("its role claim has no role of this server")]
    Role,
    #[error("its tenant claim is no valid tenant name")]
    Tenant,
    /// The provider has never been reached.
    #[error("the keys of the identity provider are not known")]
    Unavailable,
}
