//! Proves that looking up a code allocates nothing: it is done hundreds of times a frame.

#![allow(unsafe_code, reason = "an allocator that counts can only be written with it")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use tagbus_family::{Family, Index};

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: both methods pass their arguments to the system's allocator and change nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller keeps the promises that `alloc` asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the memory came from `alloc` above, that is from the system's allocator, with this layout.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

fn allocations() -> u64 {
    ALLOCATIONS.get()
}

#[test]
fn a_look_up_allocates_nothing() {
    for name in Family::PUBLISHED {
        let family = Family::published(name).unwrap();
        let index = Index::new(&family, 2);
        let before = allocations();
        assert!(before > 0, "the counter does not count");
        let mut found = 0;
        for &code in family.codes().iter().take(1000) {
            found += u64::from(index.lookup(code).is_some()) + u64::from(index.lookup(code ^ 3).is_some());
            found += u64::from(index.lookup(code.wrapping_mul(0x9e37_79b9_7f4a_7c15)).is_some());
        }
        assert!(found >= 2 * family.codes().len().min(1000) as u64, "{name}");
        assert_eq!(allocations(), before, "{name}");
    }
}
