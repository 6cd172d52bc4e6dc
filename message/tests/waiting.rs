//! Waking: nothing is missed, however sender and receiver meet.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on says where")]

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use iceoryx2::prelude::ipc;
use tagbus_message::bus::{Bus, Patience};
use tagbus_message::domain::Domain;
use tagbus_message::frame::FrameHeader;
use tagbus_message::ports::{FramesIn, FramesOut};
use tagbus_message::qos;
use tagbus_message::stop::Stop;
use tagbus_message::wait::{WaitSet, Waiter, Wake};

type Local = ipc::Service;

/// Long enough for any machine: only a hanging test gets there.
const WATCHDOG: Duration = Duration::from_secs(60);
const MESSAGES: u64 = 5_000;

/// A domain of the test's own.
struct Ground(Domain);

impl Ground {
    fn new() -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let name = format!("w{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        Self(Domain::with_root(&name, std::env::temp_dir().join(format!("tb-{name}"))).unwrap())
    }

    fn bus(&self, role: &str) -> Bus<Local> {
        Bus::start(&self.0, role, &Stop::new().unwrap()).unwrap()
    }

    fn camera(&self) -> FramesOut<Local> {
        self.bus("camera cam0").create_frames("cam0", &qos::FRAMES, 64).unwrap()
    }

    fn viewer(&self) -> FramesIn<Local> {
        self.bus("viewer").open_frames("cam0", 1, Patience::AtMost(WATCHDOG)).unwrap()
    }
}

fn send(out: &FramesOut<Local>, sequence: u64) {
    let mut loan = out.publisher().loan_slice(1).unwrap();
    *loan.user_header_mut() = FrameHeader { sequence, ..FrameHeader::default() };
    loan.send().unwrap();
    out.notify().unwrap();
}

fn spin(duration: Duration) {
    let begun = Instant::now();
    while begun.elapsed() < duration {
        std::hint::spin_loop();
    }
}

/// Waits until the newest message is `last`, and tells of each that was seen; as every receiver of the bus does it.
fn receive_until(last: u64, input: &FramesIn<Local>, waiter: &Waiter<Local>, seen: &AtomicU64) {
    loop {
        if let Some(message) = input.newest().unwrap() {
            let sequence = message.user_header().sequence;
            seen.store(sequence, Ordering::Release);
            if sequence == last {
                return;
            }
        }
        assert_ne!(waiter.wait(WATCHDOG).unwrap(), Wake::TimedOut, "a message was missed");
    }
}

/// Each message is sent when the last one was seen, and a little later each time, so that it meets the receiver at every point
/// between two sleeps. One that does not wake would be the last.
#[test]
fn no_message_is_missed_wherever_it_meets_its_receiver() {
    let ground = Ground::new();
    let (out, seen) = (ground.camera(), AtomicU64::new(0));
    std::thread::scope(|scope| {
        let receiver = scope.spawn(|| {
            let (input, stop, set) = (ground.viewer(), Stop::new().unwrap(), WaitSet::new().unwrap());
            set.keep(&stop).unwrap();
            set.keep(input.listener()).unwrap();
            receive_until(MESSAGES, &input, &Waiter::of_kept(&set, &stop, Some(input.listener())), &seen);
        });
        while out.subscribers() == 0 {
            std::thread::sleep(Duration::from_millis(1));
        }
        for sequence in 1..=MESSAGES {
            send(&out, sequence);
            let begun = Instant::now();
            while seen.load(Ordering::Acquire) < sequence && !receiver.is_finished() {
                assert!(begun.elapsed() < WATCHDOG, "message {sequence} was missed");
                std::thread::yield_now();
            }
            spin(Duration::from_nanos(10 * (sequence % 3000)));
        }
        receiver.join().unwrap();
    });
}

#[test]
fn messages_that_come_faster_than_they_are_received_end_with_the_newest() {
    let ground = Ground::new();
    let (out, seen) = (ground.camera(), AtomicU64::new(0));
    std::thread::scope(|scope| {
        let receiver = scope.spawn(|| {
            let (input, stop, set) = (ground.viewer(), Stop::new().unwrap(), WaitSet::new().unwrap());
            let waiter = Waiter::new(&set, &stop, Some(input.listener())).unwrap();
            receive_until(MESSAGES, &input, &waiter, &seen);
        });
        while out.subscribers() == 0 {
            std::thread::sleep(Duration::from_millis(1));
        }
        (1..=MESSAGES).for_each(|sequence| send(&out, sequence));
        receiver.join().unwrap();
    });
}

/// Who is not done with a message is not woken for the next ones: they are found in the queue.
#[test]
fn an_event_is_told_once_more_after_it_was_taken_and_then_no_more() {
    let ground = Ground::new();
    let (out, input) = (ground.camera(), ground.viewer());
    let (stop, set) = (Stop::new().unwrap(), WaitSet::new().unwrap());
    let waiter = Waiter::new(&set, &stop, Some(input.listener())).unwrap();
    let soon = Duration::from_millis(1);
    // The camera came before the viewer, so there is no event yet.
    assert_eq!(waiter.wait(soon).unwrap(), Wake::TimedOut);
    for sequence in 0..3 {
        send(&out, sequence);
        assert_eq!(waiter.wait(WATCHDOG).unwrap(), Wake::Event);
        (10..15).for_each(|sequence| send(&out, sequence));
        assert_eq!(input.newest().unwrap().unwrap().user_header().sequence, 14);
        assert_eq!(waiter.wait(WATCHDOG).unwrap(), Wake::Event);
        assert!(input.newest().unwrap().is_none());
        assert_eq!(waiter.wait(soon).unwrap(), Wake::TimedOut);
    }
}

/// Another waiter on the same set begins with what is there.
#[test]
fn an_event_that_was_not_taken_wakes_the_next_waiter() {
    let ground = Ground::new();
    let (out, input) = (ground.camera(), ground.viewer());
    let (stop, set) = (Stop::new().unwrap(), WaitSet::new().unwrap());
    let waiter = Waiter::new(&set, &stop, Some(input.listener())).unwrap();
    send(&out, 1);
    assert_eq!(waiter.wait(WATCHDOG).unwrap(), Wake::Event);
    drop(waiter);
    let nothing = Waiter::<Local>::new(&set, &stop, None).unwrap();
    assert_eq!(nothing.wait(Duration::from_millis(1)).unwrap(), Wake::TimedOut);
    drop(nothing);
    let waiter = Waiter::new(&set, &stop, Some(input.listener())).unwrap();
    assert_eq!(waiter.wait(WATCHDOG).unwrap(), Wake::Event);
}
