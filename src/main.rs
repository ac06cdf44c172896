//! The program: see `flankfit --help`.

mod processor;

use std::{
    ffi::{c_int, c_long},
    io::Write as _,
    process::ExitCode,
    time::Duration,
};

/// Answers are built from many short-lived vectors on several threads; this allocator is made for
/// that.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    if !processor::suffices() {
        // no format: making its arguments could be an instruction that is missing
        let _ = std::io::stderr().write_all(
            b"flankfit: this program is built for processors with x86-64-v3 (AVX2, FMA, BMI2), which this one is not\n",
        );
        return ExitCode::from(WRONG_PROCESSOR);
    }
    run()
}

/// The program is built for other processors (`EX_CONFIG` of sysexits.h).
const WRONG_PROCESSOR: u8 = 78;

/// Apart from `main`, so that nothing of it runs before the processor has been asked.
#[inline(never)]
fn run() -> ExitCode {
    give_back_freed_memory();
    give_back_while_idle();
    flankfit::cli::main()
}

/// Milliseconds that freed memory is kept before the system gets it back. The node set of a big
/// request is as long as its body, and the next one finds a place of another length: kept for the
/// allocator's second, a few requests hold several times what they need.
const KEPT_FOR: c_long = 10;

/// The allocator's number for that delay (`mi_option_purge_delay` in its header).
const PURGE_DELAY: c_int = 15;

/// Tells the allocator not to keep what was freed, unless `MIMALLOC_PURGE_DELAY` in the environment
/// says for how long.
fn give_back_freed_memory() {
    #[expect(unsafe_code, reason = "the allocator's options have no safe interface")]
    // SAFETY: the declaration is that of mimalloc.h, which this program links; the function sets
    // one number, and any number is a delay.
    unsafe {
        unsafe extern "C" {
            fn mi_option_set_default(option: c_int, value: c_long);
        }
        mi_option_set_default(PURGE_DELAY, KEPT_FOR);
    }
}

/// Interval at which freed memory is returned to the system.
const COLLECT_EVERY: Duration = Duration::from_secs(5);

/// Returns freed memory to the system while nothing is allocated: the allocator checks for memory
/// that was free long enough only during allocations, and a large unread answer may be the last one
/// of an idle server.
fn give_back_while_idle() {
    let collecting = || {
        loop {
            std::thread::sleep(COLLECT_EVERY);
            // the allocator collects only for threads that have allocated something
            drop(std::hint::black_box(Box::new(0_u8)));
            #[expect(unsafe_code, reason = "the allocator's collection has no safe interface")]
            // SAFETY: the declaration is that of mimalloc.h, which this program links; any thread
            // may call the function.
            unsafe {
                unsafe extern "C" {
                    fn mi_collect(force: bool);
                }
                mi_collect(false);
            }
        }
    };
    // without this thread memory is returned later, which must not stop the program
    let _thread = std::thread::Builder::new().name("memory".to_owned()).spawn(collecting);
}
