//! Secrets are compared in one place, by `subtle`: in constant time.

use super::{code, root, sources};

/// The only comparison of digests of keys.
const SAME: &str = "pubfnsame(kept:&[u8;32],presented:&[u8;32])->bool{kept.ct_eq(presented).into()}";

#[test]
fn digests_of_keys_are_compared_in_one_place_and_in_constant_time() {
    let own = root().join("src/jobs/callers/secret.rs");
    let (mut by_subtle, mut callers) = (Vec::new(), 0);
    for file in sources() {
        let code = code(&file);
        let dense: String = code.split_whitespace().collect();
        if code.contains("subtle::") {
            by_subtle.push(file.clone());
        }
        // who digests what somebody presents compares it there, too
        let service = dense.split("#[cfg(test)]").next().unwrap_or_default();
        if file != own && (service.contains("secret::digest(") || service.contains("&digest(presented)")) {
            callers += 1;
            assert!(service.contains("same(&"), "{} compares a key by itself", file.display());
            for word in ["digest==", "==digest", "digest!=", "!=digest", "sha256==", "sha256!="] {
                assert!(!service.contains(word), "{} holds {word}", file.display());
            }
        }
    }
    assert_eq!(by_subtle, std::slice::from_ref(&own));
    assert_eq!(callers, 2, "keys of the settings and keys of the store");
    let dense: String = code(&own).split_whitespace().collect();
    assert!(dense.contains("usesubtle::ConstantTimeEqas_;") && dense.contains(SAME));
    // and a key itself cannot be compared, printed or logged
    assert!(dense.contains("pubstructSecret(String);"));
    for word in ["forSecret{", "derive("] {
        assert!(!dense.contains(word), "{word}");
    }
}
