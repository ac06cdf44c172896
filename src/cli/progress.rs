//! A progress bar for what takes above a second, on standard error where that is a terminal.

use std::{
    io::{IsTerminal, stderr},
    sync::mpsc::{Receiver, RecvTimeoutError, channel},
    thread,
    time::Duration,
};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::pool::Handle;

/// Shorter work shows no bar.
const SHORT: Duration = Duration::from_secs(1);
/// Between two looks.
const LOOK: Duration = Duration::from_millis(100);
/// The bar counts thousandths.
const WHOLE: f64 = 1000.0;

/// Does `work` on a thread of its own and shows how far it says it is.
pub fn shown<T: Send>(what: &'static str, work: impl FnOnce() -> T + Send) -> T {
    let handle = Handle::new();
    let telling = handle.clone();
    watched(
        what,
        || Some(handle.progress()),
        move || {
            // nobody cancels; the progress is that of the same work
            let mut work = Some(work);
            match telling.run(|| work.take().map(|work| work())) {
                Ok(Some(done)) => done,
                _ => unreachable!("nobody cancels the work, and it is done once"),
            }
        },
    )
}

/// Does `work`, which does not tell how far it is, on a thread of its own, and shows the part that
/// `how_far` finds done: none where nobody can know, and then how long it takes already.
pub fn watched<T: Send>(what: &'static str, how_far: impl Fn() -> Option<f64>, work: impl FnOnce() -> T + Send) -> T {
    if !stderr().is_terminal() {
        return work();
    }
    thread::scope(|scope| {
        let (over, ended) = channel::<()>();
        let working = scope.spawn(move || {
            let done = work();
            drop(over);
            done
        });
        draw(what, &how_far, &ended);
        match working.join() {
            Ok(done) => done,
            Err(panicked) => std::panic::resume_unwind(panicked),
        }
    })
}

/// Draws the bar until `ended` is, if that is not soon, and takes it away.
fn draw(what: &'static str, how_far: &dyn Fn() -> Option<f64>, ended: &Receiver<()>) {
    if ended.recv_timeout(SHORT) != Err(RecvTimeoutError::Timeout) {
        return;
    }
    let is_known = how_far().is_some();
    let bar = ProgressBar::with_draw_target(is_known.then_some(WHOLE as u64), ProgressDrawTarget::stderr());
    let template = if is_known { "{msg} {wide_bar} {percent:>3} % {eta}" } else { "{msg} {spinner} {elapsed}" };
    // a template that does not read would be a bar without numbers
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar.set_message(what);
    loop {
        if let Some(part) = how_far() {
            bar.set_position((part * WHOLE) as u64);
        }
        bar.tick();
        if ended.recv_timeout(LOOK) != Err(RecvTimeoutError::Timeout) {
            break;
        }
    }
    bar.finish_and_clear();
}
