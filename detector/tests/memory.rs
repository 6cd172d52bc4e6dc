//! No second picture is ever made, and after warm-up nothing is allocated.

#![allow(unsafe_code, reason = "a global allocator that counts cannot be written without")]
#![allow(clippy::unwrap_used, reason = "the whole file is one test")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use tagbus_detector::{Decimation, Detector, LumaView, Refinement, Settings};
use tagbus_family::Family;
use tagbus_scene::{Scene, SceneConfig};

struct Counting;

static BYTES: AtomicUsize = AtomicUsize::new(0);
static CALLS: AtomicUsize = AtomicUsize::new(0);
static HAS_BEGUN: AtomicBool = AtomicBool::new(false);

thread_local! {
    /// Whether this thread's allocations count; unknown before its first.
    static IS_WATCHED: Cell<Option<bool>> = const { Cell::new(None) };
}

/// Watched are the test's thread and those that begin after it. The harness has one of its own, which allocates in the middle of
/// it all: it says so when a test takes longer than a minute.
fn is_watched() -> bool {
    let known = IS_WATCHED.get().unwrap_or_else(|| HAS_BEGUN.load(Ordering::Relaxed));
    IS_WATCHED.set(Some(known));
    known
}

fn count(bytes: usize) {
    if is_watched() {
        BYTES.fetch_add(bytes, Ordering::Relaxed);
        CALLS.fetch_add(1, Ordering::Relaxed);
    }
}

// SAFETY: every call is handed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size());
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size.saturating_sub(layout.size()));
        // SAFETY: the caller keeps the contract of `realloc`.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// One test, since the counters belong to the whole process.
#[test]
fn a_flat_frame_costs_less_than_half_a_byte_a_pixel_and_warm_frames_nothing() {
    IS_WATCHED.set(Some(true));
    HAS_BEGUN.store(true, Ordering::Relaxed);
    flat_frame_costs_less_than_half_a_byte_a_pixel();
    warm_frames_allocate_nothing();
}

fn flat_frame_costs_less_than_half_a_byte_a_pixel() {
    let (width, height) = (1280, 800);
    let families = ["tag36h11", "tagStandard41h12"].map(|name| Family::published(name).unwrap());
    let luma = vec![120; width * height];
    for factor in [1.0, 1.5, 2.0, 3.0] {
        let decimation = Decimation::from_factor(factor).unwrap();
        let mut detector = Detector::new(&families, &Settings { decimation, ..Settings::default() }).unwrap();
        let before = BYTES.load(Ordering::Relaxed);
        detector.detect(&LumaView::grey(&luma, width, height).unwrap());
        let per_pixel = (BYTES.load(Ordering::Relaxed) - before) as f64 / (width * height) as f64;
        println!("factor {factor}: {per_pixel:.3} bytes a pixel");
        assert!(per_pixel < 0.5, "factor {factor}: {per_pixel} bytes a pixel");
    }
}

fn warm_frames_allocate_nothing() {
    let families: Vec<Family> =
        Family::PUBLISHED.iter().map(|name| Family::published(name).unwrap()).collect();
    for refinement in [Refinement::None, Refinement::Edges, Refinement::Tag] {
        for threads in [1, 2, 5] {
            let decimation = Decimation::Every(1);
            let settings = Settings { refinement, threads, decimation, ..Settings::default() };
            let mut detector = Detector::new(&families, &settings).unwrap();
            moving_frames_allocate_nothing(&mut detector);
        }
    }
}

/// Frames of a moving scene, again and again: who works on what is chance, so more than once round is looked at.
fn moving_frames_allocate_nothing(detector: &mut Detector) {
    // So many tags that sorting them takes more than a few places on the stack.
    let families = vec![SceneConfig::default().families; 6].concat();
    let scene =
        Scene::new(SceneConfig { width: 1280, height: 960, families, ..SceneConfig::default() }).unwrap();
    let frames: Vec<Vec<u8>> = (0..4).map(|frame| rendered(&scene, 7 * frame)).collect();
    for round in 0..12 {
        for (frame, luma) in frames.iter().enumerate() {
            let before = CALLS.load(Ordering::Relaxed);
            let found = detector.detect(&LumaView::grey(luma, 1280, 960).unwrap()).len();
            assert!(found >= 30, "only {found} tags");
            let calls = CALLS.load(Ordering::Relaxed) - before;
            assert!(round == 0 || calls == 0, "frame {frame}, round {round}, {:?}", detector.settings());
        }
    }
}

fn rendered(scene: &Scene, frame: u64) -> Vec<u8> {
    let mut luma = vec![0; 1280 * 960];
    scene.render(frame, &mut luma);
    luma
}
