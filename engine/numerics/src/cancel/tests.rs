use std::sync::mpsc;

use rayon::prelude::*;

use super::{loops::STRETCH, *};

fn spin() -> ! {
    loop {
        checkpoint();
        std::hint::spin_loop();
    }
}

#[test]
fn without_a_handle_nothing_happens_and_with_one_the_result_comes_through() {
    checkpoint();
    assert!(current().is_none());
    let handle = Handle::new();
    let result = handle.run(|| {
        checkpoint();
        every(STRETCH, 0);
        assert!(current().is_some());
        42
    });
    assert_eq!(result, Ok(42));
    assert!(current().is_none() && !handle.is_cancelled());
}

#[test]
fn a_cancelled_handle_ends_the_work_from_another_thread_and_destructors_run() {
    struct Bell(mpsc::Sender<()>);
    impl Drop for Bell {
        fn drop(&mut self) {
            // computing in a destructor is no second unwinding
            checkpoint();
            self.0.send(()).unwrap();
        }
    }
    let handle = Handle::new();
    let (begun, seen) = mpsc::channel();
    let (gone, dropped) = mpsc::channel();
    let working = std::thread::spawn({
        let handle = handle.clone();
        move || {
            let result = handle.run(|| {
                let _bell = Bell(gone);
                begun.send(()).unwrap();
                spin()
            });
            (result, current().is_none())
        }
    });
    seen.recv().unwrap();
    assert!(!working.is_finished());
    handle.cancel();
    assert_eq!(working.join().unwrap(), (Err::<(), _>(Cancelled), true));
    dropped.recv().unwrap();
    assert_eq!(handle.run(|| 1), Err(Cancelled), "what is cancelled does not begin");
}

#[test]
fn handles_nest_and_each_ends_its_own_work() {
    let (outer, inner) = (Handle::new(), Handle::new());
    let result = outer.run(|| {
        inner.cancel();
        let given_up = inner.run(|| spin());
        checkpoint();
        given_up
    });
    assert_eq!(result, Ok(Err::<(), _>(Cancelled)));
    let (outer, inner) = (Handle::new(), Handle::new());
    let result = outer.run(|| {
        let done = inner.run(|| {
            outer.cancel();
            checkpoint();
            1
        });
        assert_eq!(done, Ok(1), "the inner work is still wanted");
        checkpoint();
    });
    assert_eq!(result, Err(Cancelled));
}

#[test]
fn loops_ask_once_in_a_stretch_of_turns() {
    let handle = Handle::new();
    handle.cancel();
    let turns = |cost: usize, most: usize| {
        let turn = std::cell::Cell::new(0);
        let by_number = catch_unwind(AssertUnwindSafe(|| {
            carry(Some(&handle), || (0..most).for_each(|i| (turn.set(i), every(cost, i)).1))
        }));
        let seen = std::cell::Cell::new(0);
        let by_item = catch_unwind(AssertUnwindSafe(|| {
            carry(Some(&handle), || (0..most).asking(cost).for_each(|i| seen.set(i + 1)))
        }));
        assert_eq!(by_number.is_err(), by_item.is_err());
        by_number.is_err().then(|| (turn.get(), seen.get()))
    };
    assert_eq!(turns(STRETCH / 4, 3), None);
    assert_eq!(turns(STRETCH / 4, 5), Some((4, 4)));
    assert_eq!(turns(0, 2 * STRETCH), Some((STRETCH, STRETCH)));
    assert_eq!(turns(usize::MAX, 1), Some((0, 0)));
    assert_eq!((0..7).asking(1).size_hint(), (7, Some(7)));
    let mut numbers: Vec<usize> = (0..100_000).map(|i| i * 7919 % 100_003).collect();
    let sort = || carry(Some(&handle), || numbers.sort_by(comparing(usize::cmp)));
    assert!(catch_unwind(AssertUnwindSafe(sort)).is_err());
}

#[test]
fn other_panics_pass_through() {
    let handle = Handle::new();
    let payload = catch_unwind(AssertUnwindSafe(|| handle.run(|| resume_unwind(Box::new("a defect"))))).unwrap_err();
    assert_eq!(payload.downcast_ref(), Some(&"a defect"));
    assert!(current().is_none());
}

#[test]
fn threads_of_rayon_take_the_handle_along() {
    let handle = Handle::new();
    let (begun, seen) = mpsc::sync_channel(1 << 10);
    let working = std::thread::spawn({
        let handle = handle.clone();
        move || {
            handle.run(|| {
                let handle = current();
                (0..64).into_par_iter().for_each(|_| {
                    carry(handle.as_ref(), || {
                        let _full = begun.try_send(());
                        spin()
                    })
                });
            })
        }
    });
    seen.recv().unwrap();
    handle.cancel();
    assert_eq!(working.join().unwrap(), Err(Cancelled));
    // the pool's threads keep nothing of it
    assert!((0..64).into_par_iter().all(|_| current().is_none()));
}

#[test]
fn work_without_a_handle_is_not_cancelled_by_the_one_below_it_on_the_stack() {
    let handle = Handle::new();
    let result = handle.run(|| {
        handle.cancel();
        carry(None, || {
            checkpoint();
            7
        })
    });
    assert_eq!(result, Ok(7));
}
