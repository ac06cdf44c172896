//! Frames of zstd, unpacked within bounds: a few bytes of a frame can be thousands of times as many
//! once they are unpacked.

use std::io::{self, Read as _};

use zstd::{stream::read::Decoder, zstd_safe};

/// No document that is kept is longer: requests and responses are bounded, and are sent as texts.
pub const LONGEST: u64 = 1 << 30;
/// A frame is not read back further than this to go on, 128 MiB; what is written here needs less.
const WINDOW_LOG: u32 = 27;
/// Capacity that is reserved before anything was read.
const AT_FIRST: u64 = 64 << 10;

/// Returns the content of a frame; an error where that is more than so many bytes, or the frame is
/// damaged.
pub fn unpacked(frame: &[u8], most: u64) -> io::Result<Vec<u8>> {
    let told = zstd_safe::get_frame_content_size(frame).ok().flatten();
    if let Some(told) = told.filter(|told| *told > most) {
        return Err(longer(told, most));
    }
    let mut decoder = Decoder::with_buffer(frame)?;
    decoder.window_log_max(WINDOW_LOG)?;
    let mut bytes = Vec::with_capacity(told.unwrap_or(0).min(AT_FIRST) as usize);
    // one byte more shows that it is longer
    decoder.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    match bytes.len() as u64 {
        length if length > most => Err(longer(length, most)),
        _ => Ok(bytes),
    }
}

fn longer(length: u64, most: u64) -> io::Error {
    let told = format!("a frame holds {length} bytes or more, of which {most} are taken");
    io::Error::new(io::ErrorKind::InvalidData, told)
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use super::*;

    /// A frame that does not say how long it is.
    fn silent(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = zstd::stream::write::Encoder::new(Vec::new(), 1).unwrap();
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn a_frame_is_unpacked_up_to_its_bound() {
        let bytes = b"1.5,".repeat(50_000);
        for frame in [zstd::bulk::compress(&bytes, 1).unwrap(), silent(&bytes)] {
            assert_eq!(unpacked(&frame, bytes.len() as u64).unwrap(), bytes);
            let refused = unpacked(&frame, bytes.len() as u64 - 1).unwrap_err();
            assert!(refused.to_string().contains("200000 bytes or more, of which 199999"), "{refused}");
            assert!(unpacked(&frame[..frame.len() - 5], 1 << 20).is_err(), "cut off");
        }
        // two frames are as long as both
        let two = [silent(&bytes), silent(&bytes)].concat();
        assert!(unpacked(&two, bytes.len() as u64).is_err());
        assert!(unpacked(b"no frame", 100).is_err());
    }

    #[test]
    fn refused_frames_take_no_memory() {
        // 1 GiB in some 100 kB
        let mut encoder = zstd::stream::write::Encoder::new(Vec::new(), 3).unwrap();
        let zeros = vec![0; 1 << 20];
        for _ in 0..1024 {
            encoder.write_all(&zeros).unwrap();
        }
        let bomb = encoder.finish().unwrap();
        assert!(bomb.len() < 200_000, "{}", bomb.len());
        let refused = unpacked(&bomb, 1 << 20).unwrap_err();
        assert!(refused.to_string().contains("1048577 bytes or more"), "no more is unpacked: {refused}");
    }
}
