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
        draw(what, &how_far, &ended, SHORT, ProgressDrawTarget::stderr);
        match working.join() {
            Ok(done) => done,
            Err(panicked) => std::panic::resume_unwind(panicked),
        }
    })
}

/// Draws the bar until `ended` is, if that is not before `short` is over, and takes it away.
fn draw(
    what: &'static str,
    how_far: &dyn Fn() -> Option<f64>,
    ended: &Receiver<()>,
    short: Duration,
    target: impl FnOnce() -> ProgressDrawTarget,
) {
    if ended.recv_timeout(short) != Err(RecvTimeoutError::Timeout) {
        return;
    }
    let is_known = how_far().is_some();
    let bar = ProgressBar::with_draw_target(is_known.then_some(WHOLE as u64), target());
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

#[cfg(test)]
mod tests {
    use std::{
        io,
        sync::{Arc, Mutex},
        time::Instant,
    };

    use indicatif::TermLike;

    use super::*;
    use flankfit_engine::numerics::cancel::parts;

    /// Text that was drawn.
    #[derive(Clone, Debug, Default)]
    struct Screen(Arc<Mutex<String>>);

    impl TermLike for Screen {
        fn width(&self) -> u16 {
            60
        }

        fn move_cursor_up(&self, _lines: usize) -> io::Result<()> {
            Ok(())
        }

        fn move_cursor_down(&self, _lines: usize) -> io::Result<()> {
            Ok(())
        }

        fn move_cursor_right(&self, _columns: usize) -> io::Result<()> {
            Ok(())
        }

        fn move_cursor_left(&self, _columns: usize) -> io::Result<()> {
            Ok(())
        }

        fn write_line(&self, text: &str) -> io::Result<()> {
            self.write_str(text)
        }

        fn write_str(&self, text: &str) -> io::Result<()> {
            self.0.lock().unwrap().push_str(text);
            Ok(())
        }

        fn clear_line(&self) -> io::Result<()> {
            self.write_str("<cleared>")
        }

        fn flush(&self) -> io::Result<()> {
            Ok(())
        }
    }

    impl Screen {
        fn text(&self) -> String {
            self.0.lock().unwrap().clone()
        }

        /// Waits until this is drawn: how long that takes is the machine's.
        fn until(&self, shows: impl Fn(&str) -> bool) {
            let begun = Instant::now();
            while !shows(&self.text()) && begun.elapsed() < Duration::from_secs(60) {
                thread::sleep(Duration::from_millis(5));
            }
        }
    }

    /// Returns the text that is drawn while half of some work is done, as long as `lasting` takes.
    fn drawn(short: Duration, lasting: impl Fn(&Screen) + Send + 'static) -> String {
        let (screen, handle) = (Screen::default(), Handle::new());
        let (over, ended) = channel();
        let worker = thread::spawn({
            let (handle, screen) = (handle.clone(), screen.clone());
            move || {
                let worked = handle.run(|| {
                    let halves = parts(2);
                    halves.run(1, || ());
                    halves.run(1, || lasting(&screen));
                });
                drop(over);
                worked
            }
        });
        let target = screen.clone();
        draw("study", &|| Some(handle.progress()), &ended, short, || ProgressDrawTarget::term_like(Box::new(target)));
        assert_eq!(worker.join().unwrap(), Ok(()));
        screen.text()
    }

    #[test]
    fn long_runs_show_progress_and_clear_it() {
        let text = drawn(Duration::from_millis(20), |screen| screen.until(|text| text.contains(" 50 %")));
        assert!(text.contains("study") && text.contains(" 50 %"), "{text}");
        assert!(text.ends_with("<cleared>"), "{text}");
    }

    #[test]
    fn unknown_progress_shows_the_elapsed_time() {
        let (screen, (over, ended)) = (Screen::default(), channel());
        // the first that is drawn may come late
        let tells_time = |text: &str| text.as_bytes().windows(2).any(|two| two[0].is_ascii_digit() && two[1] == b's');
        let (target, seen) = (screen.clone(), screen.clone());
        let worker = thread::spawn(move || {
            seen.until(tells_time);
            drop::<std::sync::mpsc::Sender<()>>(over);
        });
        let target = || ProgressDrawTarget::term_like(Box::new(target));
        draw("migrate", &|| None, &ended, Duration::from_millis(20), target);
        worker.join().unwrap();
        let text = screen.text();
        assert!(text.contains("migrate") && tells_time(&text) && !text.contains('%'), "{text}");
        assert!(text.ends_with("<cleared>"), "{text}");
    }

    #[test]
    fn short_runs_show_no_progress() {
        assert_eq!(drawn(Duration::from_secs(60), |_| ()), "");
    }

    #[test]
    fn the_result_comes_through() {
        assert_eq!(shown("sum", || 2 + 2), 4);
        assert_eq!(watched("sum", || None, || 2 + 2), 4);
    }
}
