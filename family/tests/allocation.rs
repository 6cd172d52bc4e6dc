//! Proves that looking up a code allocates nothing, for it is done hundreds of times a frame, and how large an index is.

#![allow(unsafe_code, reason = "an allocator that counts can only be written with it")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use tagbus_family::{Family, Index};

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
    /// Bytes that this thread has allocated and not given back.
    static LIVE: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: both methods pass their arguments to the system's allocator and change nothing. (`realloc` is made of them.)
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        LIVE.set(LIVE.get().wrapping_add(layout.size()));
        // SAFETY: the caller keeps the promises that `alloc` asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        LIVE.set(LIVE.get().wrapping_sub(layout.size()));
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

#[test]
fn an_index_occupies_what_it_says_and_all_nine_together_less_than_20_million_bytes() {
    let before = LIVE.get();
    let loaded = Family::PUBLISHED.map(|name| {
        let family = Family::published(name).unwrap();
        let before = LIVE.get();
        let index = Index::new(&family, 3);
        let held = LIVE.get() - before + size_of::<Index>();
        assert_eq!(index.size_bytes(), held, "{name}");
        (family, index)
    });
    let all = LIVE.get() - before + size_of_val(&loaded);
    println!("nine families and their indexes: {all} bytes");
    assert!((1_000_000..20_000_000).contains(&all), "{all} bytes");
    let some = Index::for_ids(&loaded[3].0, 2, &Vec::from_iter(3..203));
    assert!(some.size_bytes() < loaded[3].1.size_bytes());
}
