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
            set.hear(input.bell()).unwrap();
            receive_until(MESSAGES, &input, &Waiter::of_kept(&set, &stop, Some(input.bell())), &seen);
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
            let waiter = Waiter::<Local>::new(&set, &stop, Some(input.bell())).unwrap();
            receive_until(MESSAGES, &input, &waiter, &seen);
        });
        while out.subscribers() == 0 {
            std::thread::sleep(Duration::from_millis(1));
        }
        (1..=MESSAGES).for_each(|sequence| send(&out, sequence));
        receiver.join().unwrap();
    });
}

/// Who is not done with a message is told once of all that came meanwhile.
#[test]
fn what_rang_while_a_receiver_was_busy_is_told_once_and_then_no_more() {
    let ground = Ground::new();
    let (out, input) = (ground.camera(), ground.viewer());
    let (stop, set) = (Stop::new().unwrap(), WaitSet::new().unwrap());
    let waiter = Waiter::<Local>::new(&set, &stop, Some(input.bell())).unwrap();
    let soon = Duration::from_millis(1);
    assert_eq!(waiter.wait(soon).unwrap(), Wake::TimedOut);
    for sequence in 0..3 {
        send(&out, sequence);
        assert_eq!(waiter.wait(WATCHDOG).unwrap(), Wake::Event);
        assert_eq!(waiter.wait(soon).unwrap(), Wake::TimedOut);
        (10..15).for_each(|sequence| send(&out, sequence));
        assert_eq!(input.newest().unwrap().unwrap().user_header().sequence, 14);
        assert_eq!(waiter.wait(WATCHDOG).unwrap(), Wake::Event);
        assert!(input.newest().unwrap().is_none());
        assert_eq!(waiter.wait(soon).unwrap(), Wake::TimedOut);
    }
}

/// A program of somebody else knows the topic's event only.
#[test]
fn a_listener_of_another_program_is_notified_too() {
    let ground = Ground::new();
    let out = ground.camera();
    let bus = ground.bus("somebody else");
    let name = "tagbus/v1/cam0/frames".try_into().unwrap();
    let events = bus.node().service_builder(&name).event().open().unwrap();
    let listener = events.listener_builder().create().unwrap();
    send(&out, 1);
    assert!(listener.try_wait(|_| ()).unwrap() > 0);
    drop((listener, events));
    send(&out, 2);
}

/// Another waiter on the same set begins with what is there.
#[test]
fn a_bell_that_rang_before_wakes_the_next_waiter_at_once() {
    let ground = Ground::new();
    let (out, input) = (ground.camera(), ground.viewer());
    let (stop, set) = (Stop::new().unwrap(), WaitSet::new().unwrap());
    let waiter = Waiter::<Local>::new(&set, &stop, Some(input.bell())).unwrap();
    send(&out, 1);
    assert_eq!(waiter.wait(WATCHDOG).unwrap(), Wake::Event);
    drop(waiter);
    let nothing = Waiter::<Local>::new(&set, &stop, None).unwrap();
    assert_eq!(nothing.wait(Duration::from_millis(1)).unwrap(), Wake::TimedOut);
    drop(nothing);
    let waiter = Waiter::<Local>::new(&set, &stop, Some(input.bell())).unwrap();
    assert_eq!(waiter.wait(WATCHDOG).unwrap(), Wake::Event);
}
