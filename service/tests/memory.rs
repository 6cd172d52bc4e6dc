//! After warm-up the thread of a service allocates nothing from frame to frame, however many tags there are: only for a look once a second
//! whether its topics are still those that others find, and for what it publishes about itself twice a second.

#![allow(unsafe_code, reason = "a global allocator that counts cannot be written without")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on says where")]

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use std::time::Instant;

use common::{Ground, Service, WATCHDOG, picture_of};

struct Counting;

static CALLS: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    /// Only the service's thread counts: its observer, which it calls for each frame, says so.
    static IS_WATCHED: Cell<bool> = const { Cell::new(false) };
}

fn count() {
    if IS_WATCHED.get() {
        CALLS.fetch_add(1, Ordering::Relaxed);
    }
}

// SAFETY: every call is handed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: the caller keeps the contract of `realloc`.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Frames before counting begins, and while it goes on.
const WARM_UP: u32 = 100;
const FRAMES: u32 = 300;

/// Frames since whose predecessor something was allocated.
static DIRTY: AtomicU32 = AtomicU32::new(0);

#[test]
fn a_service_that_is_warm_allocates_nothing_for_a_frame() {
    let ground = Ground::new();
    let mut config = ground.config();
    let mut last = 0;
    config.observer = Some(Box::new(move |_| {
        IS_WATCHED.set(true);
        let calls = CALLS.load(Ordering::Relaxed);
        DIRTY.fetch_add(u32::from(calls > last), Ordering::Relaxed);
        last = calls;
    }));
    let service = Service::start(config);
    let (mut camera, mut first, mut second) = (ground.camera(), ground.client(), ground.client());
    let pictures = [picture_of(&[7, 42]), picture_of(&[]), picture_of(&[11])];
    camera.publish_until_heard(&pictures[0], &mut first);
    let (mut before, mut begun) = (0, Instant::now());
    for frame in 0..WARM_UP + FRAMES {
        if frame == WARM_UP {
            (before, begun) = (DIRTY.load(Ordering::Relaxed), Instant::now());
            assert!(CALLS.load(Ordering::Relaxed) > 0, "the counter does not count");
        }
        camera.publish(&pictures[frame as usize % pictures.len()]);
        for client in [&mut first, &mut second] {
            drop(client.receive(WATCHDOG).unwrap().expect("a message for the frame"));
        }
    }
    let (dirty, looks) = (DIRTY.load(Ordering::Relaxed) - before, 3 * begun.elapsed().as_secs() as u32 + 3);
    drop((first, second, camera));
    // On a machine that lets the camera wait the dead are looked for, too.
    let silences = service.end().0.deadlines_missed;
    assert!(
        u64::from(dirty) <= u64::from(looks) + silences,
        "allocations for {dirty} of {FRAMES} frames, but only {looks} looks and {silences} silences"
    );
}
