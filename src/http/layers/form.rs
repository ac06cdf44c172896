//! `multipart/form-data` (RFC 7578, RFC 2046): a form that is in memory is cut into its parts, of
//! which none is copied.

use axum::body::Bytes;
use memchr::memmem;

use super::media_type::{essence, parameter};

/// Most parts that are read of a form.
const MOST_PARTS: usize = 16;
/// Longest headers of a part.
const LONGEST_HEADERS: usize = 8 << 10;

/// A part of a form.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    pub name: String,
    /// Its `content-type`, empty where there is none.
    pub media: String,
    /// As the caller calls the file.
    pub file_name: Option<String>,
    pub content: Bytes,
}

/// The parts of a form in their order, or why it cannot be read.
pub fn parts(form: &Bytes, content_type: &str) -> Result<Vec<Part>, &'static str> {
    let boundary = parameter(content_type, "boundary").filter(|boundary| (1..=70).contains(&boundary.len()));
    let boundary = boundary.ok_or("its content-type names no boundary of 1 to 70 characters")?;
    let delimiter = format!("\r\n--{boundary}");
    let delimiter = memmem::Finder::new(&delimiter);
    // The first delimiter may stand at the very beginning, without the line break before it.
    let first = &delimiter.needle()[2..];
    let mut at = match form.starts_with(first) {
        true => first.len(),
        false => delimiter.find(form).ok_or(UNENDED)? + delimiter.needle().len(),
    };
    let mut parts = Vec::new();
    while let Some(begin) = after_delimiter(form, at)? {
        if parts.len() == MOST_PARTS {
            return Err(TOO_MANY_PARTS);
        }
        let (headers, content) = headers(&form[begin..])?;
        let content = begin + content;
        // An empty part's line break is also that before the delimiter.
        let empty = form[content..].starts_with(first);
        let end = if empty { content } else { content + delimiter.find(&form[content..]).ok_or(UNENDED)? };
        parts.push(part(headers, form.slice(content..end))?);
        at = end + if empty { first.len() } else { delimiter.needle().len() };
    }
    Ok(parts)
}

const TOO_MANY_PARTS: &str = "it has more than 16 parts";
const UNENDED: &str = "it ends before its closing boundary";

/// Returns where the part after a delimiter begins; `None` after the closing one.
fn after_delimiter(form: &[u8], at: usize) -> Result<Option<usize>, &'static str> {
    let rest = &form[at..];
    if rest.starts_with(b"--") {
        return Ok(None);
    }
    let blanks = rest.iter().take_while(|byte| matches!(byte, b' ' | b'\t')).count();
    match rest.get(blanks..blanks + 2) {
        Some(b"\r\n") => Ok(Some(at + blanks + 2)),
        None => Err(UNENDED),
        Some(_) => Err("its boundary is not followed by a line break"),
    }
}

/// The headers of a part, and where its content begins.
fn headers(part: &[u8]) -> Result<(&str, usize), &'static str> {
    if part.starts_with(b"\r\n") {
        return Ok(("", 2));
    }
    let bounded = &part[..part.len().min(LONGEST_HEADERS)];
    let long = bounded.len() < part.len();
    let why = if long { "the headers of a part are too long" } else { UNENDED };
    let end = memmem::find(bounded, b"\r\n\r\n").ok_or(why)?;
    let text = std::str::from_utf8(&part[..end]).map_err(|_| "the headers of a part are not UTF-8")?;
    Ok((text, end + 4))
}

fn part(headers: &str, content: Bytes) -> Result<Part, &'static str> {
    let mut part = Part { name: String::new(), media: String::new(), file_name: None, content };
    for line in headers.split("\r\n").filter(|line| !line.is_empty()) {
        let (name, value) = line.split_once(':').ok_or("a header of a part has no colon")?;
        let value = value.trim();
        if name.eq_ignore_ascii_case("content-disposition") {
            if essence(value) != "form-data" {
                return Err("a part is not form-data");
            }
            part.name = parameter(value, "name").unwrap_or_default();
            part.file_name = parameter(value, "filename");
        } else if name.eq_ignore_ascii_case("content-type") {
            part.media = value.to_owned();
        } else if name.eq_ignore_ascii_case("content-transfer-encoding")
            && !["binary", "8bit", "7bit"].iter().any(|plain| value.eq_ignore_ascii_case(plain))
        {
            return Err("a part is encoded; send it as it is");
        }
    }
    Ok(part)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TYPE: &str = "multipart/form-data; boundary=\"x y\"";

    fn of(text: &str) -> Result<Vec<Part>, &'static str> {
        parts(&Bytes::copy_from_slice(text.as_bytes()), TYPE)
    }

    #[test]
    fn parts_are_cut_at_the_boundary_and_not_copied() {
        let text = "before\r\n--x y \t\r\nContent-Disposition: form-data; name=\"a\"\r\n\r\n1\r\n--x\r\n\r\n--x y\r\n\
                    content-disposition:form-data;name=b;filename=\"f.csv\"\r\nContent-Type: text/csv\r\n\r\n\r\n--x \
                    y\r\n\
                    \r\n--x y--\r\nafter";
        let form = Bytes::copy_from_slice(text.as_bytes());
        let [a, b, c] = parts(&form, TYPE).unwrap().try_into().unwrap();
        assert_eq!((a.name.as_str(), &a.content[..]), ("a", &b"1\r\n--x\r\n"[..]));
        assert!(form.as_ptr_range().contains(&a.content.as_ptr()), "the part lies in the form");
        assert_eq!((b.name.as_str(), b.media.as_str(), b.content.len()), ("b", "text/csv", 0));
        assert_eq!(b.file_name.as_deref(), Some("f.csv"));
        assert_eq!((c.name.as_str(), c.content.len()), ("", 0));
        assert_eq!(of("--x y--"), Ok(Vec::new()));
    }

    #[test]
    fn broken_forms_say_why() {
        let part = "Content-Disposition: form-data; name=a\r\n\r\n1";
        for (text, why) in [
            ("", UNENDED),
            ("--x y", UNENDED),
            ("--x y\r\n", UNENDED),
            (&format!("--x y\r\n{part}"), UNENDED),
            (&format!("--x yz\r\n{part}\r\n--x y--"), "its boundary is not followed by a line break"),
            ("--x y\r\nnothing\r\n\r\n\r\n--x y--", "a header of a part has no colon"),
            ("--x y\r\nContent-Disposition: inline\r\n\r\n\r\n--x y--", "a part is not form-data"),
            (&format!("--x y\r\nA: {}\r\n\r\n1\r\n--x y--", "b".repeat(9000)), "the headers of a part are too long"),
            (&format!("{}--x y--", format!("--x y\r\n{part}\r\n").repeat(17)), TOO_MANY_PARTS),
        ] {
            assert_eq!(of(text), Err(why), "{text:.40}");
        }
        assert!(parts(&Bytes::new(), "multipart/form-data").unwrap_err().contains("boundary"));
    }
}
