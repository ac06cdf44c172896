//! Parts that the comparisons with other programs share: arrays as files, and seconds.

use std::{error::Error, fs, path::Path, time::Instant};

use serde_json::{Value, json};

pub type Outcome<T> = Result<T, Box<dyn Error>>;

/// Little-endian doubles.
pub fn read(folder: &Path, name: &str) -> Outcome<Vec<f64>> {
    let bytes = fs::read(folder.join(name))?;
    bytes.chunks(8).map(|b| Ok(f64::from_le_bytes(b.try_into()?))).collect()
}

/// The same, the other way round.
pub fn write(folder: &Path, name: &str, numbers: &[f64]) -> Outcome<()> {
    let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    Ok(fs::write(folder.join(name), bytes)?)
}

/// Seconds that the threads of this process have been on a processor: what other programs do has
/// little part in it. `None` where the system does not say (it is Linux that does).
fn processor_seconds() -> Option<f64> {
    let mut nanoseconds = 0;
    for task in fs::read_dir("/proc/self/task").ok()? {
        let text = fs::read_to_string(task.ok()?.path().join("schedstat")).ok()?;
        nanoseconds += text.split(' ').next()?.parse::<u64>().ok()?;
    }
    Some(nanoseconds as f64 * 1e-9)
}

/// The last result, and seconds for every repetition: as a clock shows them, and of processors. One
/// repetition is `batch` times the work.
pub fn timed<T>(repeats: usize, batch: usize, mut work: impl FnMut() -> Outcome<T>) -> Outcome<(T, Value)> {
    let mut last = work()?;
    let (mut clock, mut processor) = (Vec::new(), Vec::new());
    for _ in 0..repeats {
        let (start, busy) = (Instant::now(), processor_seconds());
        for _ in 0..batch {
            last = work()?;
        }
        clock.push(start.elapsed().as_secs_f64() / batch as f64);
        if let (Some(from), Some(to)) = (busy, processor_seconds()) {
            processor.push((to - from) / batch as f64);
        }
    }
    Ok((last, json!({"clock": clock, "processor": processor})))
}
