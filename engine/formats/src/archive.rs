//! Reads the model file of a ZIP archive (`.rexsz`).
//!
//! A model is the only file of its archive, stored or deflated. Encryption, multi-part archives and
//! ZIP64 are not supported.

use super::file_error::{FileError, FilePosition};

/// Signature of an archive.
pub(super) const MAGIC: &[u8] = b"PK\x03\x04";

/// Greatest size of an unpacked file, in bytes.
pub const MOST_UNPACKED: usize = 1 << 26;

const CENTRAL: &[u8] = b"PK\x01\x02";
const END: &[u8] = b"PK\x05\x06";

/// Returns name and bytes of the model in an archive: the first file named like a model, or the
/// only file.
pub(super) fn unpack(archive: &[u8]) -> Result<(String, Vec<u8>), FileError> {
    let files = listed(archive).ok_or_else(|| unreadable("a ZIP archive without a list of its files"))?;
    let is_model = |name: &str| [".rexs", ".rexsj", ".xml", ".json"].iter().any(|end| name.ends_with(end));
    let named = files.iter().find(|file| is_model(&file.name.to_lowercase()));
    let only = || files.first().filter(|_| files.len() == 1);
    let file = named
        .or_else(only)
        .ok_or_else(|| unreadable(&format!("a ZIP archive of {} files, none of which is a REXS model", files.len())))?;
    if file.encrypted {
        return Err(unreadable("an encrypted ZIP archive; unpack it first"));
    }
    let bytes = file.bytes(archive).ok_or_else(|| unreadable("a ZIP archive that is cut off"))?;
    let too_large = |bytes| FileError::TooLarge { bytes, most: MOST_UNPACKED };
    if file.unpacked > MOST_UNPACKED {
        return Err(too_large(file.unpacked));
    }
    let text = match file.method {
        0 => bytes.to_vec(),
        8 => miniz_oxide::inflate::decompress_to_vec_with_limit(bytes, MOST_UNPACKED).map_err(|fault| {
            if fault.status == miniz_oxide::inflate::TINFLStatus::HasMoreOutput {
                too_large(fault.output.len().max(MOST_UNPACKED + 1))
            } else {
                unreadable("a ZIP archive whose data are damaged")
            }
        })?,
        method => return Err(unreadable(&format!("a ZIP archive packed by method {method}; unpack it first"))),
    };
    if text.len() != file.unpacked {
        return Err(unreadable("a ZIP archive whose data are damaged"));
    }
    Ok((file.name.clone(), text))
}

fn unreadable(what: &str) -> FileError {
    FileError::Unsupported { place: FilePosition { line: 1, column: 1 }, what: what.into() }
}

/// A file of an archive, by its entry in the central directory.
struct Packed {
    name: String,
    encrypted: bool,
    method: u16,
    packed: usize,
    unpacked: usize,
    header: usize,
}

impl Packed {
    /// Returns the packed bytes, which follow the local header.
    fn bytes<'a>(&self, archive: &'a [u8]) -> Option<&'a [u8]> {
        let header = archive.get(self.header..)?;
        header.starts_with(MAGIC).then_some(())?;
        let start = 30 + usize::from(short(header, 26)?) + usize::from(short(header, 28)?);
        header.get(start..start.checked_add(self.packed)?)
    }
}

/// Returns the files of the central directory, without folders.
fn listed(archive: &[u8]) -> Option<Vec<Packed>> {
    // the end record has 22 bytes and a comment of at most 65,535
    let last = archive.len().checked_sub(22)?;
    let end = (last.saturating_sub(0xFFFF)..=last).rev().find(|at| archive[*at..].starts_with(END))?;
    let count = short(archive, end + 10)?;
    let mut at = long(archive, end + 16)?;
    let mut files = Vec::new();
    for _ in 0..count {
        let entry = archive.get(at..)?;
        entry.starts_with(CENTRAL).then_some(())?;
        let lengths = [28, 30, 32].map(|place| short(entry, place).map(usize::from));
        let [Some(name), Some(extra), Some(comment)] = lengths else { return None };
        let file = Packed {
            name: String::from_utf8_lossy(entry.get(46..46 + name)?).into_owned(),
            encrypted: short(entry, 8)? & 1 == 1,
            method: short(entry, 10)?,
            packed: long(entry, 20)?,
            unpacked: long(entry, 24)?,
            header: long(entry, 42)?,
        };
        if !file.name.ends_with('/') {
            files.push(file);
        }
        at += 46 + name + extra + comment;
    }
    Some(files)
}

fn short(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..at + 2).map(|two| u16::from_le_bytes([two[0], two[1]]))
}

fn long(bytes: &[u8], at: usize) -> Option<usize> {
    bytes.get(at..at + 4).map(|four| u32::from_le_bytes([four[0], four[1], four[2], four[3]]) as usize)
}
