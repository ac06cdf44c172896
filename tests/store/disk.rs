//! A disk that can lose its power: an SQLite VFS that passes everything on to the real one and
//! remembers, for each file, what was written and what of that was synced. After a power loss
//! exactly the synced part is guaranteed to be there.
//!
//! The page cache of the machine survives a killed process, so killing proves nothing about syncs;
//! this does.

#![expect(
    unsafe_code,
    clippy::undocumented_unsafe_blocks,
    reason = "a VFS is a table of C functions; every block only uses the pointers that SQLite hands over under its VFS \
        contract"
)]

use std::{
    collections::HashMap,
    ffi::{CStr, c_char, c_int, c_void},
    path::{Path, PathBuf},
    ptr::null_mut,
    sync::{Mutex, MutexGuard, Once, OnceLock},
};

use libsqlite3_sys as sqlite;

/// The name under which the disk is registered.
pub const NAME: &str = "watched";

/// Known states of one file.
#[derive(Clone, Default)]
struct Content {
    written: Vec<u8>,
    synced: Vec<u8>,
}

static FILES: Mutex<Option<HashMap<PathBuf, Content>>> = Mutex::new(None);
/// Directories that take no more writes, with the code that SQLite hears.
static REFUSING: Mutex<Vec<(PathBuf, c_int)>> = Mutex::new(Vec::new());
/// Files that must not grow above a length.
static MOST: Mutex<Vec<(PathBuf, usize)>> = Mutex::new(Vec::new());
static REAL: OnceLock<usize> = OnceLock::new();

/// Writes the content of every file of `directory` after a power loss now into `to`.
pub fn lose_power(directory: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for (path, content) in files().as_ref().unwrap() {
        if path.parent() == Some(directory) && !content.synced.is_empty() {
            std::fs::write(to.join(path.file_name().unwrap()), &content.synced).unwrap();
        }
    }
}

/// Makes the disk under a directory refuse everything with one of SQLite's result codes, or accept
/// it again.
pub fn refuse(directory: &Path, code: Option<c_int>) {
    let mut all = REFUSING.lock().unwrap();
    all.retain(|(there, _)| there != directory);
    all.extend(code.map(|code| (directory.to_path_buf(), code)));
}

/// Sets by how much every file of a directory may still grow, if there is a bound.
pub fn fill(directory: &Path, room: Option<usize>) {
    let mut most = MOST.lock().unwrap();
    most.retain(|(path, _)| path.parent() != Some(directory));
    if let Some(room) = room {
        let of_directory = |(path, _): &(&PathBuf, &Content)| path.parent() == Some(directory);
        let files = files();
        let all = files.as_ref().unwrap().iter().filter(of_directory);
        most.extend(all.map(|(path, content)| (path.clone(), content.written.len() + room)));
    }
}

/// True if everything written to the file has been synced.
pub fn is_synced(path: &Path) -> bool {
    files().as_ref().unwrap().get(path).is_some_and(|content| content.written == content.synced)
}

/// Registers the disk (once in a process).
pub fn register() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| unsafe {
        files().get_or_insert_default();
        assert_eq!(sqlite::sqlite3_initialize(), sqlite::SQLITE_OK);
        let real = sqlite::sqlite3_vfs_find(std::ptr::null());
        REAL.set(real as usize).unwrap();
        let mut watched = *real;
        watched.szOsFile += size_of::<File>() as c_int;
        watched.pNext = null_mut();
        watched.zName = c"watched".as_ptr();
        watched.xOpen = Some(open);
        watched.xDelete = Some(delete);
        let code = sqlite::sqlite3_vfs_register(Box::leak(Box::new(watched)), 0);
        assert_eq!(code, sqlite::SQLITE_OK);
    });
}

fn files() -> MutexGuard<'static, Option<HashMap<PathBuf, Content>>> {
    FILES.lock().unwrap()
}

/// The first part of what SQLite allocates for an open file; the real VFS's part follows it.
#[repr(C)]
struct File {
    methods: *const sqlite::sqlite3_io_methods,
    /// A leaked `PathBuf`, null for files without a name.
    path: *const PathBuf,
}

unsafe fn real_vfs() -> *mut sqlite::sqlite3_vfs {
    *REAL.get().unwrap() as *mut sqlite::sqlite3_vfs
}

unsafe fn real(file: *mut sqlite::sqlite3_file) -> *mut sqlite::sqlite3_file {
    unsafe { file.cast::<File>().add(1).cast() }
}

fn with_content(file: *mut sqlite::sqlite3_file, change: impl FnOnce(&mut Content)) {
    let path = unsafe { (*file.cast::<File>()).path.as_ref() };
    if let Some(path) = path {
        change(files().as_mut().unwrap().entry(path.clone()).or_default());
    }
}

fn path_of(name: *const c_char) -> PathBuf {
    PathBuf::from(unsafe { CStr::from_ptr(name) }.to_str().unwrap())
}

unsafe extern "C" fn open(
    _vfs: *mut sqlite::sqlite3_vfs,
    name: *const c_char,
    file: *mut sqlite::sqlite3_file,
    flags: c_int,
    out_flags: *mut c_int,
) -> c_int {
    unsafe {
        let ours = file.cast::<File>();
        (*ours).methods = std::ptr::null();
        (*ours).path =
            if name.is_null() { std::ptr::null() } else { Box::into_raw(Box::new(path_of(name))).cast_const() };
        (*real(file)).pMethods = std::ptr::null();
        let code = (*real_vfs()).xOpen.unwrap()(real_vfs(), name, real(file), flags, out_flags);
        if !(*real(file)).pMethods.is_null() {
            (*ours).methods = &METHODS;
        }
        code
    }
}

unsafe extern "C" fn delete(_vfs: *mut sqlite::sqlite3_vfs, name: *const c_char, sync: c_int) -> c_int {
    files().as_mut().unwrap().remove(&path_of(name));
    unsafe { (*real_vfs()).xDelete.unwrap()(real_vfs(), name, sync) }
}

unsafe extern "C" fn write(
    file: *mut sqlite::sqlite3_file,
    bytes: *const c_void,
    count: c_int,
    offset: sqlite::sqlite3_int64,
) -> c_int {
    let directory = unsafe { (*file.cast::<File>()).path.as_ref() }.and_then(|path| path.parent());
    let refusing = REFUSING.lock().unwrap();
    if let Some((_, code)) = refusing.iter().find(|(there, _)| Some(there.as_path()) == directory) {
        return *code;
    }
    drop(refusing);
    let path = unsafe { (*file.cast::<File>()).path.as_ref() };
    let end = offset as usize + count as usize;
    if MOST.lock().unwrap().iter().any(|(bounded, most)| Some(bounded) == path && end > *most) {
        return sqlite::SQLITE_FULL;
    }
    let code = unsafe { (*(*real(file)).pMethods).xWrite.unwrap()(real(file), bytes, count, offset) };
    if code == sqlite::SQLITE_OK {
        let bytes = unsafe { std::slice::from_raw_parts(bytes.cast::<u8>(), count as usize) };
        with_content(file, |content| {
            let begin = offset as usize;
            if content.written.len() < begin + bytes.len() {
                content.written.resize(begin + bytes.len(), 0);
            }
            content.written[begin..begin + bytes.len()].copy_from_slice(bytes);
        });
    }
    code
}

unsafe extern "C" fn truncate(file: *mut sqlite::sqlite3_file, size: sqlite::sqlite3_int64) -> c_int {
    let code = unsafe { (*(*real(file)).pMethods).xTruncate.unwrap()(real(file), size) };
    if code == sqlite::SQLITE_OK {
        with_content(file, |content| content.written.truncate(size as usize));
    }
    code
}

unsafe extern "C" fn sync(file: *mut sqlite::sqlite3_file, flags: c_int) -> c_int {
    let code = unsafe { (*(*real(file)).pMethods).xSync.unwrap()(real(file), flags) };
    if code == sqlite::SQLITE_OK {
        with_content(file, |content| content.synced.clone_from(&content.written));
    }
    code
}

/// Methods that only pass on.
macro_rules! passed_on {
    ($($name:ident as $method:ident($($argument:ident: $kind:ty),*) -> $answer:ty;)*) => {
        $(unsafe extern "C" fn $name(file: *mut sqlite::sqlite3_file $(, $argument: $kind)*) -> $answer {
            unsafe { (*(*real(file)).pMethods).$method.unwrap()(real(file) $(, $argument)*) }
        })*
    };
}

passed_on! {
    close as xClose() -> c_int;
    read as xRead(to: *mut c_void, count: c_int, offset: sqlite::sqlite3_int64) -> c_int;
    size as xFileSize(size: *mut sqlite::sqlite3_int64) -> c_int;
    lock as xLock(level: c_int) -> c_int;
    unlock as xUnlock(level: c_int) -> c_int;
    check_lock as xCheckReservedLock(out: *mut c_int) -> c_int;
    control as xFileControl(operation: c_int, argument: *mut c_void) -> c_int;
    sector as xSectorSize() -> c_int;
    characteristics as xDeviceCharacteristics() -> c_int;
    shm_map as xShmMap(page: c_int, size: c_int, extend: c_int, out: *mut *mut c_void) -> c_int;
    shm_lock as xShmLock(offset: c_int, count: c_int, flags: c_int) -> c_int;
    shm_barrier as xShmBarrier() -> ();
    shm_unmap as xShmUnmap(delete: c_int) -> c_int;
}

static METHODS: sqlite::sqlite3_io_methods = sqlite::sqlite3_io_methods {
    // Version 2: no memory-mapped reads, so every byte passes by.
    iVersion: 2,
    xClose: Some(close),
    xRead: Some(read),
    xWrite: Some(write),
    xTruncate: Some(truncate),
    xSync: Some(sync),
    xFileSize: Some(size),
    xLock: Some(lock),
    xUnlock: Some(unlock),
    xCheckReservedLock: Some(check_lock),
    xFileControl: Some(control),
    xSectorSize: Some(sector),
    xDeviceCharacteristics: Some(characteristics),
    xShmMap: Some(shm_map),
    xShmLock: Some(shm_lock),
    xShmBarrier: Some(shm_barrier),
    xShmUnmap: Some(shm_unmap),
    xFetch: None,
    xUnfetch: None,
};
