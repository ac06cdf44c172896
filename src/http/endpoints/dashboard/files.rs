//! Files of the dashboard: those in the program, or of a folder while somebody works on them.

use std::{
    collections::BTreeMap,
    fs, io,
    io::Write as _,
    path::Path,
    sync::{Arc, LazyLock, OnceLock},
};

use axum::body::Bytes;
use flate2::{Compression, write::GzEncoder};
use rust_embed::RustEmbed;
use sha2::{Digest, Sha256};

use crate::jobs::rows::to_hex;

const INDEX: &str = include_str!("../../../../web/index.html");
/// Placeholder of the digest in `index.html`.
const PLACEHOLDER: &str = "{digest}";
/// The digest of files that may change at any time.
const UNFINISHED: &str = "folder";

#[derive(RustEmbed)]
#[folder = "web/app/"]
#[prefix = "app/"]
#[exclude = "*.d.ts"]
struct App;

#[derive(RustEmbed)]
#[folder = "web/vendor/"]
#[prefix = "vendor/"]
#[exclude = "*.d.ts"]
struct Vendor;

/// Source of the files.
#[derive(Clone, Debug)]
pub enum Files {
    Embedded,
    /// A folder that holds `index.html`, `app/` and `vendor/`.
    Folder(Arc<Path>),
}

/// One file.
#[derive(Clone, Debug)]
pub struct File {
    pub bytes: Bytes,
    pub media: &'static str,
    /// As gzip, once that has been asked for.
    packed: Arc<OnceLock<Option<Bytes>>>,
}

/// Files embedded in the program.
struct Embedded {
    files: BTreeMap<String, File>,
    digest: String,
    index: String,
}

static EMBEDDED: LazyLock<Embedded> = LazyLock::new(|| {
    let all =
        App::iter().map(|name| (App::get(&name), name)).chain(Vendor::iter().map(|name| (Vendor::get(&name), name)));
    let files: BTreeMap<String, File> = all
        .filter_map(|(file, name)| {
            let bytes = match file?.data {
                std::borrow::Cow::Borrowed(bytes) => Bytes::from_static(bytes),
                std::borrow::Cow::Owned(bytes) => bytes.into(),
            };
            Some((name.to_string(), File::new(&name, bytes)))
        })
        .collect();
    let mut hash = Sha256::new();
    let named = files.iter().map(|(name, file)| (name.as_str(), &file.bytes[..]));
    for (name, bytes) in named.chain([("index.html", INDEX.as_bytes())]) {
        // with their lengths, so that no two sets of files are the same text
        hash.update((name.len() as u64).to_le_bytes());
        hash.update(name);
        hash.update((bytes.len() as u64).to_le_bytes());
        hash.update(bytes);
    }
    let digest = to_hex(&hash.finalize());
    Embedded { index: INDEX.replace(PLACEHOLDER, &digest), digest, files }
});

impl Files {
    /// Those of a folder, or those in the program.
    pub fn of(folder: Option<&Path>) -> Self {
        folder.map_or(Files::Embedded, |folder| Files::Folder(folder.into()))
    }

    /// Refuses a folder that holds no page.
    pub fn check(&self) -> Result<(), String> {
        let Files::Folder(folder) = self else { return Ok(()) };
        let missing = |error| format!("--dashboard-dir {}: cannot read its index.html: {error}", folder.display());
        fs::metadata(folder.join("index.html")).map(drop).map_err(missing)
    }

    /// Returns the digest, which is part of the path of every file.
    pub fn digest(&self) -> &str {
        match self {
            Files::Embedded => &EMBEDDED.digest,
            Files::Folder(_) => UNFINISHED,
        }
    }

    /// Whether a file stays what it is.
    pub fn may_be_kept(&self) -> bool {
        matches!(self, Files::Embedded)
    }

    /// The page, with the paths of its files.
    pub fn index(&self) -> io::Result<String> {
        match self {
            Files::Embedded => Ok(EMBEDDED.index.clone()),
            Files::Folder(folder) => {
                Ok(fs::read_to_string(folder.join("index.html"))?.replace(PLACEHOLDER, UNFINISHED))
            }
        }
    }

    /// The file of a name such as `app/main.js`.
    pub fn file(&self, name: &str) -> Option<File> {
        match self {
            Files::Embedded => EMBEDDED.files.get(name).cloned(),
            Files::Folder(folder) => {
                let inside = ["app/", "vendor/"].iter().any(|start| name.starts_with(start));
                let plain = name.split('/').all(|part| !part.is_empty() && !part.starts_with('.'));
                let bytes = (inside && plain && !name.contains(['\\', ':', '\0'])).then(|| fs::read(folder.join(name)));
                Some(File::new(name, bytes?.ok()?.into()))
            }
        }
    }
}

impl File {
    fn new(name: &str, bytes: Bytes) -> Self {
        let ending = name.rsplit_once('.').map_or("", |(_, ending)| ending);
        let media = match ending {
            "js" => "text/javascript; charset=utf-8",
            "css" => "text/css; charset=utf-8",
            "svg" => "image/svg+xml",
            "json" => "application/json",
            "png" => "image/png",
            "txt" => "text/plain; charset=utf-8",
            _ => "application/octet-stream",
        };
        File { bytes, media, packed: Arc::default() }
    }

    /// As gzip, made once; none where that is no shorter.
    pub fn packed(&self) -> Option<Bytes> {
        let pack = || {
            let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
            encoder.write_all(&self.bytes).ok()?;
            let packed = encoder.finish().ok()?;
            (packed.len() < self.bytes.len()).then(|| packed.into())
        };
        self.packed.get_or_init(pack).clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_gives_nothing_outside_of_it() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str| fs::write(folder.path().join(name), name).unwrap();
        for below in ["app", "vendor", "test"] {
            fs::create_dir(folder.path().join(below)).unwrap();
        }
        ["index.html", "app/main.js", "app/.hidden.js", "test/a.js"].into_iter().for_each(write);
        let files = Files::of(Some(folder.path()));
        files.check().unwrap();
        assert_eq!(files.file("app/main.js").unwrap().bytes, "app/main.js");
        for name in ["app/.hidden.js", "test/a.js", "app/../test/a.js", "index.html", "app//main.js", "app/none.js"] {
            assert!(files.file(name).is_none(), "{name}");
        }
    }

    #[test]
    fn a_folder_without_a_page_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let refusal = Files::of(Some(folder.path())).check().unwrap_err().to_string();
        assert!(refusal.starts_with("--dashboard-dir ") && refusal.contains("index.html"), "{refusal}");
    }
}
