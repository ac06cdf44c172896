//! Ed25519 (RFC 8032): who has the key says that a seal is theirs, and everybody can check it.

use aws_lc_rs::signature::{ED25519, Ed25519KeyPair, KeyPair as _, UnparsedPublicKey};

/// Signs seals. It is a secret: it can be neither shown nor compared.
pub struct SigningKey(Ed25519KeyPair);

impl SigningKey {
    /// The key of a PKCS#8 document (version 1 or 2); `None` for another kind of key.
    pub fn from_pkcs8(document: &[u8]) -> Option<Self> {
        Ed25519KeyPair::from_pkcs8(document).ok().map(SigningKey)
    }

    pub fn sign(&self, message: &[u8]) -> Signed {
        let (mut signed, signature) = (Signed { public_key: [0; 32], signature: [0; 64] }, self.0.sign(message));
        signed.public_key.copy_from_slice(self.0.public_key().as_ref());
        signed.signature.copy_from_slice(signature.as_ref());
        signed
    }
}

/// A signature with the key that it is checked by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signed {
    pub public_key: [u8; 32],
    pub signature: [u8; 64],
}

impl Signed {
    /// Returns whether it is of this message.
    pub fn is_of(&self, message: &[u8]) -> bool {
        UnparsedPublicKey::new(&ED25519, self.public_key).verify(message, &self.signature).is_ok()
    }
}

/// Bytes before the 32 bytes of an Ed25519 public key in its `SubjectPublicKeyInfo` (RFC
/// 8410, section 4).
const PUBLIC_KEY: [u8; 12] = [0x30, 0x2a, 0x30, 0x05, 0x06, 0x03, 0x2b, 0x65, 0x70, 0x03, 0x21, 0x00];

/// The key of a `SubjectPublicKeyInfo`; `None` for another kind of key.
pub fn public_key(document: &[u8]) -> Option<[u8; 32]> {
    document.strip_prefix(&PUBLIC_KEY)?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(hex: &str) -> Vec<u8> {
        (0..hex.len() / 2).map(|k| u8::from_str_radix(&hex[2 * k..2 * k + 2], 16).unwrap()).collect()
    }

    /// RFC 8032, section 7.1, test 2; the keys in the documents of RFC 8410, section 7.
    #[test]
    fn signatures_are_those_of_the_standard() {
        let secret = "302e020100300506032b657004220420\
                      4ccd089b28ff96da9db6c346ec114e0f5b8a319f35aba624da8cf6ed4fb8a6fb";
        let public = "302a300506032b6570032100\
                      3d4017c3e843895a92b70aa74d1b7ebc9c982ccf2ec4968cc0cd55f12af4660c";
        let expected = "92a009a9f0d4cab8720e820b5f642540a2b27b5416503f8fb3762223ebdb69da\
                        085ac1e43e15996e458f3613d0f11d8c387b2eaeb4302aeeb00d291612bb0c00";
        let signed = SigningKey::from_pkcs8(&bytes(secret)).unwrap().sign(&[0x72]);
        assert_eq!(signed.signature.as_slice(), bytes(expected));
        assert_eq!(public_key(&bytes(public)), Some(signed.public_key));
        assert!(signed.is_of(&[0x72]) && !signed.is_of(&[0x73]));
        let mut other = signed;
        other.signature[3] ^= 1;
        assert!(!other.is_of(&[0x72]));
        assert!(SigningKey::from_pkcs8(&bytes(public)).is_none());
        assert_eq!(public_key(&bytes(secret)), None);
    }
}
