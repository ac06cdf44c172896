//! Jobs on their way: from a store into a file, from a file into a store, from a store into
//! another. Never more than a few rows are in memory.

use std::io::{Read, Write};

use tokio::sync::mpsc;

use super::{
    Coming, Holdings, ON_THE_WAY,
    error::ArchiveError,
    file::{ArchiveReader, ArchiveWriter, Listed},
    row::Row,
    section::{Digested, Key, Section},
};

/// What the store has of a job; no rows of one that it has not and never had.
pub async fn digest(of: &dyn Holdings, key: &Key) -> Result<Digested, ArchiveError> {
    let (rows, mut coming) = mpsc::channel(ON_THE_WAY);
    let (mut section, _) = Section::begin(key);
    let taking = async {
        while let Some(row) = coming.recv().await {
            section.row(&row);
        }
    };
    let (read, ()) = tokio::join!(of.read(key.clone(), rows), taking);
    read?;
    Ok(section.end())
}

/// Whether the store has no such job yet; refuses one that is there and differs.
pub async fn is_new(to: &dyn Holdings, key: &Key, told: &Digested) -> Result<bool, ArchiveError> {
    let there = digest(to, key).await?;
    match there.rows {
        0 => Ok(true),
        _ if there == *told => Ok(false),
        _ => Err(ArchiveError::Differs(key.job)),
    }
}

/// Writes a job into a file; whether there is or was one.
pub async fn export<W: Write>(
    from: &dyn Holdings,
    key: &Key,
    into: &mut ArchiveWriter<W>,
) -> Result<bool, ArchiveError> {
    export_seen(from, key, into, |_| {}).await
}

/// The same, and shows each row on its way.
pub async fn export_seen<W: Write>(
    from: &dyn Holdings,
    key: &Key,
    into: &mut ArchiveWriter<W>,
    mut see: impl FnMut(&Row),
) -> Result<bool, ArchiveError> {
    let (rows, mut coming) = mpsc::channel(ON_THE_WAY);
    // takes its end of the channel, which is closed when writing fails: that ends reading
    let writing = async move {
        let (mut section, first) = Section::begin(key);
        let mut begun = false;
        while let Some(row) = coming.recv().await {
            if !std::mem::replace(&mut begun, true) {
                into.line(&first)?;
            }
            see(&row);
            into.line(&section.row(&row))?;
        }
        Ok((begun, section.end(), into))
    };
    let (read, written) = tokio::join!(from.read(key.clone(), rows), writing);
    let (begun, told, into) = written.map_err(ArchiveError::File)?;
    read?;
    if begun {
        into.end(&told)?;
    }
    Ok(begun)
}

/// Returns the jobs of a file; refuses the file if any part is altered or any row fails `check`.
pub fn listed<R: Read>(
    file: R,
    check: impl Fn(&Row) -> Result<(), String>,
) -> Result<Vec<(Key, Digested)>, ArchiveError> {
    let mut reader = ArchiveReader::begin(file)?;
    let (mut jobs, mut current) = (Vec::new(), None);
    // the first line without the content that only a purge removes
    let mut emptied = None;
    while let Some(next) = reader.next_part()? {
        let unreadable = |line, why, job| Err(ArchiveError::Unreadable { line, job, why });
        match next {
            Listed::Section(key) => current = Some(key),
            Listed::Row(row) => {
                let Some(Key { job, .. }) = &current else { continue };
                if let Err(why) = check(&row) {
                    return unreadable(reader.line(), why, *job);
                }
                match row.table().name {
                    "purge" => emptied = None,
                    _ if row.is_emptied() => emptied = emptied.or(Some(reader.line())),
                    _ => {}
                }
            }
            Listed::End(told) => {
                let Some(key) = current.take() else { continue };
                if let Some(line) = emptied.take() {
                    return unreadable(line, "it is empty, and the job is not purged".to_owned(), key.job);
                }
                jobs.push((key, told));
            }
        }
    }
    Ok(jobs)
}

/// Stores the next job of a file, or passes over it.
pub async fn import<R: Read>(file: &mut ArchiveReader<R>, to: &dyn Holdings, wanted: bool) -> Result<(), ArchiveError> {
    let Some(Listed::Section(key)) = file.next_part()? else { return Err(ArchiveError::Cut) };
    if !wanted {
        while let Some(Listed::Row(_)) = file.next_part()? {}
        return Ok(());
    }
    let (rows, coming) = mpsc::channel(ON_THE_WAY);
    let reading = async move {
        loop {
            let next = match file.next_part()? {
                Some(Listed::Row(row)) => Coming::Row(row),
                Some(Listed::End(told)) => Coming::All(told),
                Some(Listed::Section(_)) | None => return Err(ArchiveError::Cut),
            };
            let last = matches!(next, Coming::All(_));
            // who takes nothing more says why
            if rows.send(next).await.is_err() || last {
                return Ok(());
            }
        }
    };
    let (read, written) = tokio::join!(reading, to.write(key.clone(), coming));
    read?;
    written.map_err(|error| ArchiveError::NotStored { job: key.job, error })
}

/// Stores a job of one store in another, which has it not.
pub async fn copy(from: &dyn Holdings, to: &dyn Holdings, key: &Key) -> Result<(), ArchiveError> {
    let (rows, mut read) = mpsc::channel(ON_THE_WAY);
    let (onward, coming) = mpsc::channel(ON_THE_WAY);
    let passing = async move {
        let (mut section, _) = Section::begin(key);
        while let Some(row) = read.recv().await {
            section.row(&row);
            if onward.send(Coming::Row(row)).await.is_err() {
                return None;
            }
        }
        Some((onward, section.end()))
    };
    // the end is told only when all was read
    let reading = async {
        let (read, passed) = tokio::join!(from.read(key.clone(), rows), passing);
        read?;
        if let Some((onward, told)) = passed {
            let _taken = onward.send(Coming::All(told)).await;
        }
        Ok::<_, ArchiveError>(())
    };
    let (read, written) = tokio::join!(reading, to.write(key.clone(), coming));
    // where writing failed, reading could not go on
    written.map_err(|error| ArchiveError::NotStored { job: key.job, error })?;
    read
}
