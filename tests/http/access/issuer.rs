//! An identity provider of the tests: a server on this machine, with keys of its own.

use std::{
    io::{Read, Write},
    net::{TcpListener, TcpStream},
    sync::{Arc, Mutex},
    time::{SystemTime, UNIX_EPOCH},
};

use aws_lc_rs::{
    encoding::AsDer as _,
    hmac,
    rand::SystemRandom,
    rsa::KeySize,
    signature::{
        ECDSA_P256_SHA256_FIXED_SIGNING, EcdsaKeyPair, Ed25519KeyPair, KeyPair as _, RSA_PKCS1_SHA256,
        RSA_PKCS1_SHA512, RSA_PSS_SHA256, RsaEncoding, RsaKeyPair,
    },
};
use serde_json::{Value, json};
use tokio_rustls::rustls::{
    ServerConfig, ServerConnection, StreamOwned,
    crypto::aws_lc_rs::default_provider,
    pki_types::{PrivateKeyDer, pem::PemObject as _},
};

/// Base64 for URLs (RFC 4648, 5), without padding.
pub fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
    let mut text = String::new();
    for group in bytes.chunks(3) {
        let bits = group.iter().enumerate().fold(0_u32, |bits, (i, byte)| bits | u32::from(*byte) << (16 - 8 * i));
        for digit in 0..=group.len() {
            text.push(DIGITS[(bits >> (18 - 6 * digit)) as usize % 64] as char);
        }
    }
    text
}

#[expect(clippy::disallowed_methods, reason = "tokens end by the clock of whoever reads them")]
pub fn now() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_secs()
}

enum Pair {
    Rsa(RsaKeyPair),
    Ec(EcdsaKeyPair),
    Ed(Ed25519KeyPair),
}

/// A key that tokens are signed with.
pub struct SigningKey {
    pub name: String,
    pub algorithm: &'static str,
    pair: Pair,
}

impl SigningKey {
    pub fn rsa(name: &str, algorithm: &'static str) -> Self {
        SigningKey { name: name.into(), algorithm, pair: Pair::Rsa(RsaKeyPair::generate(KeySize::Rsa2048).unwrap()) }
    }

    pub fn es256(name: &str) -> Self {
        let pair = EcdsaKeyPair::generate(&ECDSA_P256_SHA256_FIXED_SIGNING).unwrap();
        SigningKey { name: name.into(), algorithm: "ES256", pair: Pair::Ec(pair) }
    }

    pub fn ed25519(name: &str) -> Self {
        SigningKey { name: name.into(), algorithm: "EdDSA", pair: Pair::Ed(Ed25519KeyPair::generate().unwrap()) }
    }

    /// Public half of the key, as a provider publishes it.
    pub fn public(&self) -> Value {
        match &self.pair {
            Pair::Rsa(pair) => {
                let (n, e) = modulus_and_exponent(pair.public_key().as_ref());
                json!({"kty": "RSA", "use": "sig", "kid": self.name, "n": base64(n), "e": base64(e)})
            }
            Pair::Ec(pair) => {
                let (x, y) = pair.public_key().as_ref()[1..].split_at(32);
                json!({"kty": "EC", "crv": "P-256", "kid": self.name, "x": base64(x), "y": base64(y)})
            }
            Pair::Ed(pair) => {
                let x = base64(pair.public_key().as_ref());
                json!({"kty": "OKP", "crv": "Ed25519", "alg": "EdDSA", "kid": self.name, "x": x})
            }
        }
    }

    /// The public half in every form that somebody might take for a shared secret.
    pub fn public_bytes(&self) -> Vec<Vec<u8>> {
        let der = match &self.pair {
            Pair::Rsa(pair) => pair.public_key().as_der().unwrap().as_ref().to_vec(),
            Pair::Ec(pair) => pair.public_key().as_ref().to_vec(),
            Pair::Ed(pair) => pair.public_key().as_ref().to_vec(),
        };
        let of = |name: &str| self.public()[name].as_str().unwrap_or_default().as_bytes().to_vec();
        vec![der, of("n"), of("x"), self.public().to_string().into_bytes()]
    }

    fn sign(&self, algorithm: &str, text: &[u8]) -> Vec<u8> {
        match &self.pair {
            Pair::Rsa(pair) => {
                let encoding: &dyn RsaEncoding = match algorithm {
                    "PS256" => &RSA_PSS_SHA256,
                    "RS512" => &RSA_PKCS1_SHA512,
                    _ => &RSA_PKCS1_SHA256,
                };
                let mut signature = vec![0; pair.public_modulus_len()];
                pair.sign(encoding, &SystemRandom::new(), text, &mut signature).unwrap();
                signature
            }
            Pair::Ec(pair) => pair.sign(&SystemRandom::new(), text).unwrap().as_ref().to_vec(),
            Pair::Ed(pair) => pair.sign(text).as_ref().to_vec(),
        }
    }

    /// A token with this header and these claims.
    pub fn token(&self, header: &Value, claims: &Value) -> String {
        let text = unsigned(header, claims);
        let algorithm = header["alg"].as_str().unwrap_or(self.algorithm);
        let signature = base64(&self.sign(algorithm, text.as_bytes()));
        format!("{text}.{signature}")
    }

    pub fn header(&self) -> Value {
        json!({"typ": "JWT", "alg": self.algorithm, "kid": self.name})
    }
}

/// Header and claims of a token.
pub fn unsigned(header: &Value, claims: &Value) -> String {
    format!("{}.{}", base64(header.to_string().as_bytes()), base64(claims.to_string().as_bytes()))
}

/// A token with a shared secret.
pub fn hs256(secret: &[u8], name: &str, claims: &Value) -> String {
    let text = unsigned(&json!({"alg": "HS256", "kid": name}), claims);
    let tag = hmac::sign(&hmac::Key::new(hmac::HMAC_SHA256, secret), text.as_bytes());
    format!("{text}.{}", base64(tag.as_ref()))
}

/// Modulus and exponent of an RSA public key in DER (RFC 8017, A.1.1): a sequence of two integers.
fn modulus_and_exponent(der: &[u8]) -> (&[u8], &[u8]) {
    fn content(der: &[u8], tag: u8) -> (&[u8], &[u8]) {
        assert_eq!(der[0], tag);
        let (length, from) = match der[1] {
            short @ 0..0x80 => (usize::from(short), 2),
            long => {
                let digits = usize::from(long & 0x7f);
                (der[2..2 + digits].iter().fold(0, |length, byte| length << 8 | usize::from(*byte)), 2 + digits)
            }
        };
        (&der[from..from + length], &der[from + length..])
    }
    let (n, rest) = content(content(der, 0x30).0, 2);
    let (e, _) = content(rest, 2);
    (n.strip_prefix(&[0]).unwrap_or(n), e)
}

/// TLS of a server at `localhost`, and the certificate that it shows (PEM).
pub fn tls() -> (impl Fn(TcpStream) -> StreamOwned<ServerConnection, TcpStream> + Send + 'static, String) {
    let made = rcgen::generate_simple_self_signed(["localhost".to_owned()]).unwrap();
    let key = PrivateKeyDer::from_pem_slice(made.signing_key.serialize_pem().as_bytes()).unwrap();
    let config = ServerConfig::builder_with_provider(Arc::new(default_provider()))
        .with_safe_default_protocol_versions()
        .unwrap()
        .with_no_client_auth()
        .with_single_cert(vec![made.cert.der().to_vec().into()], key)
        .unwrap();
    let config = Arc::new(config);
    let open = move |stream| StreamOwned::new(ServerConnection::new(config.clone()).unwrap(), stream);
    (open, made.cert.pem())
}

/// See the module's documentation.
pub struct Issuer {
    pub url: String,
    state: Arc<Mutex<State>>,
}

#[derive(Default)]
struct State {
    keys: Vec<Value>,
    /// Name that the issuer gives itself; its URL unless a test sets another.
    name: Option<String>,
    /// The heads of the requests that came.
    heads: Vec<String>,
}

impl Issuer {
    pub fn start() -> Self {
        Self::on(TcpListener::bind("127.0.0.1:0").unwrap())
    }

    pub fn on(listener: TcpListener) -> Self {
        let url = format!("http://{}/realms/plant", listener.local_addr().unwrap());
        Self::serve(listener, url, Some)
    }

    /// One that is asked by TLS, and the certificate that it shows (PEM).
    pub fn by_tls() -> (Self, String) {
        let (open, certificate) = tls();
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("https://localhost:{}/realms/plant", listener.local_addr().unwrap().port());
        (Self::serve(listener, url, move |stream| Some(open(stream))), certificate)
    }

    fn serve<S: Read + Write>(
        listener: TcpListener,
        url: String,
        open: impl Fn(TcpStream) -> Option<S> + Send + 'static,
    ) -> Self {
        let state = Arc::<Mutex<State>>::default();
        let (shared, own) = (state.clone(), url.clone());
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten().filter_map(open) {
                let _gone = answer(stream, &shared, &own);
            }
        });
        Issuer { url, state }
    }

    /// Publishes these keys from now on.
    pub fn publish(&self, keys: &[&SigningKey]) {
        self.state.lock().unwrap().keys = keys.iter().map(|key| key.public()).collect();
    }

    /// Says that it is another.
    pub fn pretend(&self, name: &str) {
        self.state.lock().unwrap().name = Some(name.to_owned());
    }

    /// The heads of the requests for keys.
    pub fn asked(&self) -> Vec<String> {
        self.state.lock().unwrap().heads.iter().filter(|head| head.starts_with("GET /keys ")).cloned().collect()
    }

    /// Claims of a good token, with `others` added or in their place.
    pub fn claims(&self, others: Value) -> Value {
        let mut claims = json!({
            "iss": self.url, "aud": "flankfit", "sub": "jane.doe", "exp": now() + 600, "nbf": now() - 10, "iat": now(),
        });
        claims.as_object_mut().unwrap().extend(others.as_object().unwrap().clone());
        claims
    }

    pub fn token(&self, key: &SigningKey, others: Value) -> String {
        key.token(&key.header(), &self.claims(others))
    }
}

/// The head of a request, with the empty line behind it.
pub fn head_of(stream: &mut impl Read) -> std::io::Result<String> {
    let mut head = Vec::new();
    let mut byte = [0];
    while !head.ends_with(b"\r\n\r\n") {
        stream.read_exact(&mut byte)?;
        head.push(byte[0]);
    }
    Ok(String::from_utf8_lossy(&head).into_owned())
}

fn answer(mut stream: impl Read + Write, state: &Mutex<State>, url: &str) -> std::io::Result<()> {
    let head = head_of(&mut stream)?;
    let (status, body) = {
        let mut state = state.lock().unwrap();
        state.heads.push(head.clone());
        let root = url.trim_end_matches("/realms/plant");
        match head.split(' ').nth(1) {
            Some("/realms/plant/.well-known/openid-configuration") => {
                let name = state.name.as_deref().unwrap_or(url);
                ("200 OK", json!({"issuer": name, "jwks_uri": format!("{root}/keys")}).to_string())
            }
            Some("/keys") => ("200 OK", json!({"keys": state.keys}).to_string()),
            _ => ("404 Not Found", String::new()),
        }
    };
    let length = body.len();
    write!(stream, "HTTP/1.1 {status}\r\ncontent-length: {length}\r\nconnection: close\r\n\r\n{body}")?;
    stream.flush()
}

#[test]
fn base64_is_that_of_the_standard() {
    // RFC 4648, 10, and RFC 7515, C
    for (bytes, text) in
        [("", ""), ("f", "Zg"), ("fo", "Zm8"), ("foo", "Zm9v"), ("foob", "Zm9vYg"), ("foobar", "Zm9vYmFy")]
    {
        assert_eq!(base64(bytes.as_bytes()), text);
    }
    assert_eq!(base64(&[3, 236, 255, 224, 193]), "A-z_4ME");
}
