//! Shared ownership within a thread, as `Rc` gives it, in memory that is used again instead of being given back.
//!
//! ```text
//! new ──▶ a free block of this thread, else a new one ──▶ clones count up, drops count down ──▶ the last drop: a free block again
//! ```
//!
//! iceoryx2 makes one such value for every loan. What makes it true is that a value is made and
//! dropped in one thread (like `Rc` it is not `Send`), and that its block is given away by its last owner only.
#![allow(unsafe_code, reason = "a place for values of any type")]
#![allow(
    clippy::vec_box,
    reason = "blocks are taken out and given back one by one, and must not move meanwhile"
)]

use std::cell::{Cell, RefCell};
use std::fmt::Debug;
use std::marker::PhantomData;
use std::mem::MaybeUninit;
use std::ops::Deref;
use std::ptr::NonNull;
use std::rc::Rc;

use iceoryx2_bb_elementary_traits::testing::abandonable::Abandonable;
use iceoryx2_cal::arc_sync_policy::{ArcSyncPolicy, ArcSyncPolicyCreationError, LockGuard};

/// Bytes of a block: what a loan needs is 40. Larger values are allocated one by one; they are made when a port is.
const BLOCK: usize = 64;
/// Free blocks that a thread keeps: more than there are loans at once.
const MOST_FREE: usize = 64;

#[repr(C, align(16))]
struct Block(MaybeUninit<[u8; BLOCK]>);

thread_local! {
    static FREE: RefCell<Vec<Box<Block>>> = const { RefCell::new(Vec::new()) };
}

/// A value and the number of its owners.
struct Counted<T> {
    owners: Cell<usize>,
    value: T,
}

impl<T> Counted<T> {
    const FITS: bool = size_of::<Self>() <= size_of::<Block>() && align_of::<Self>() <= align_of::<Block>();

    fn place(value: T) -> NonNull<Self> {
        let counted = Self { owners: Cell::new(1), value };
        if !Self::FITS {
            return NonNull::from(Box::leak(Box::new(counted)));
        }
        let place = NonNull::from(Box::leak(take_block())).cast::<Self>();
        // SAFETY: the block is nobody else's, and `FITS` says that it is large and aligned enough.
        unsafe { place.write(counted) };
        place
    }

    /// # Safety
    /// `place` comes from [`Counted::place`], its value was not dropped before, and nobody uses it afterwards.
    unsafe fn end(place: NonNull<Self>) {
        if !Self::FITS {
            // SAFETY: it was leaked from a box of this type, and this is its one end.
            drop(unsafe { Box::from_raw(place.as_ptr()) });
            return;
        }
        // SAFETY: it was written when it was placed, and this is its one end.
        unsafe { place.drop_in_place() };
        // SAFETY: as above; a block may hold anything.
        unsafe { Self::give_back(place) };
    }

    /// # Safety
    /// `place` comes from [`Counted::place`] of a type that fits, and nobody uses it afterwards.
    unsafe fn give_back(place: NonNull<Self>) {
        // SAFETY: it was leaked from a box of a block.
        let block = unsafe { Box::from_raw(place.cast::<Block>().as_ptr()) };
        // When the thread ends there may be no list any more.
        let _ = FREE.try_with(|free| {
            let mut free = free.borrow_mut();
            if free.len() < MOST_FREE {
                free.push(block);
            }
        });
    }
}

fn take_block() -> Box<Block> {
    let free = FREE.try_with(|free| free.borrow_mut().pop()).ok().flatten();
    free.unwrap_or_else(|| Box::new(Block(MaybeUninit::uninit())))
}

/// A value that several own in one thread.
pub struct Reused<T: Send + Debug + Abandonable> {
    place: NonNull<Counted<T>>,
    _counts: PhantomData<Rc<T>>,
}

impl<T: Send + Debug + Abandonable> Reused<T> {
    fn counted(&self) -> &Counted<T> {
        // SAFETY: this is an owner, so the value is there, and only counters change in it.
        unsafe { self.place.as_ref() }
    }

    /// One owner less; says whether that was the last one.
    fn leave(&self) -> bool {
        let owners = &self.counted().owners;
        owners.set(owners.get() - 1);
        owners.get() == 0
    }
}

impl<T: Send + Debug + Abandonable> Clone for Reused<T> {
    fn clone(&self) -> Self {
        let owners = &self.counted().owners;
        owners.set(owners.get() + 1);
        Self { place: self.place, _counts: PhantomData }
    }
}

impl<T: Send + Debug + Abandonable> Drop for Reused<T> {
    fn drop(&mut self) {
        if self.leave() {
            // SAFETY: it was placed by `new`, and its last owner ends here.
            unsafe { Counted::end(self.place) };
        }
    }
}

impl<T: Send + Debug + Abandonable> Debug for Reused<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Reused").field(&self.counted().value).finish()
    }
}

impl<T: Send + Debug + Abandonable> Abandonable for Reused<T> {
    unsafe fn abandon_in_place(this: NonNull<Self>) {
        // SAFETY: the caller says that there is one.
        let this = unsafe { this.as_ref() };
        if this.leave() {
            let mut place = this.place;
            // SAFETY: that was the last owner, and what is abandoned is never used again.
            let counted = unsafe { place.as_mut() };
            // SAFETY: the same; its block is left as it is.
            unsafe { T::abandon_in_place(NonNull::from(&mut counted.value)) };
        }
    }
}

/// Keeps a value while it is looked at.
pub struct Guard<'parent, T: Send + Debug + Abandonable> {
    value: &'parent T,
}

impl<T: Send + Debug + Abandonable> Deref for Guard<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.value
    }
}

impl<'parent, T: Send + Debug + Abandonable> LockGuard<'parent, T> for Guard<'parent, T> {}

impl<T: Send + Debug + Abandonable> ArcSyncPolicy<T> for Reused<T> {
    type LockGuard<'parent>
        = Guard<'parent, T>
    where
        Self: 'parent,
        T: 'parent;

    fn new(value: T) -> Result<Self, ArcSyncPolicyCreationError> {
        Ok(Self { place: Counted::place(value), _counts: PhantomData })
    }

    fn lock(&self) -> Guard<'_, T> {
        Guard { value: &self.counted().value }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts its drops.
    #[derive(Debug)]
    struct Dropping<'a, const BYTES: usize> {
        drops: &'a Drops,
        bytes: [u8; BYTES],
    }

    /// Never shared between threads here; iceoryx2 wants values that could be.
    #[derive(Debug, Default)]
    struct Drops(std::sync::atomic::AtomicUsize);

    impl Drops {
        fn count(&self) -> usize {
            self.0.load(std::sync::atomic::Ordering::Relaxed)
        }
    }

    impl<const BYTES: usize> Drop for Dropping<'_, BYTES> {
        fn drop(&mut self) {
            self.drops.0.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        }
    }

    impl<const BYTES: usize> Abandonable for Dropping<'_, BYTES> {
        unsafe fn abandon_in_place(_this: NonNull<Self>) {}
    }

    fn reused<const BYTES: usize>(drops: &Drops, fill: u8) -> Reused<Dropping<'_, BYTES>> {
        Reused::new(Dropping { drops, bytes: [fill; BYTES] }).unwrap()
    }

    fn free() -> usize {
        FREE.with(|free| free.borrow().len())
    }

    /// Small ones, those that just fit, and those that are too large.
    fn lives_as_long_as_its_owners<const BYTES: usize>() {
        let drops = Drops::default();
        let first = reused::<BYTES>(&drops, 7);
        let others: Vec<_> = (0..5).map(|_| first.clone()).collect();
        drop(first);
        assert_eq!(drops.count(), 0);
        assert!(others.iter().all(|owner| owner.lock().bytes == [7; BYTES]));
        drop(others);
        assert_eq!(drops.count(), 1);
    }

    #[test]
    fn a_value_lives_as_long_as_its_owners_whatever_its_size() {
        lives_as_long_as_its_owners::<0>();
        lives_as_long_as_its_owners::<1>();
        lives_as_long_as_its_owners::<48>();
        lives_as_long_as_its_owners::<49>();
        lives_as_long_as_its_owners::<5000>();
        assert_eq!([48, 49].map(|_| size_of::<Counted<Dropping<48>>>()), [BLOCK; 2]);
        const { assert!(!Counted::<Dropping<49>>::FITS && Counted::<Dropping<48>>::FITS) };
    }

    #[test]
    fn blocks_are_used_again_and_values_never_share_one() {
        let drops = Drops::default();
        for round in 0..3 {
            let many: Vec<_> = (0..2 * MOST_FREE).map(|fill| reused::<32>(&drops, fill as u8)).collect();
            assert!(many.iter().enumerate().all(|(fill, owner)| owner.lock().bytes == [fill as u8; 32]));
            drop(many);
            assert_eq!((drops.count(), free()), ((round + 1) * 2 * MOST_FREE, MOST_FREE));
        }
        let place = reused::<32>(&drops, 1).place;
        assert_eq!((reused::<8>(&drops, 2).place.addr(), free()), (place.addr(), MOST_FREE - 1));
    }

    #[test]
    fn a_value_that_owns_another_gives_back_both() {
        let drops = Drops::default();
        let inner = reused::<8>(&drops, 3);
        #[derive(Debug)]
        struct Outer<'a>(Reused<Dropping<'a, 8>>);
        // As iceoryx2's own states are: moved to another thread by nobody here.
        // SAFETY: no thread is started.
        unsafe impl Send for Outer<'_> {}
        impl Abandonable for Outer<'_> {
            unsafe fn abandon_in_place(_this: NonNull<Self>) {}
        }
        let outer = Reused::new(Outer(inner.clone())).unwrap();
        drop(inner);
        assert_eq!((outer.lock().0.lock().bytes, drops.count()), ([3; 8], 0));
        drop(outer);
        assert_eq!((drops.count(), free()), (1, 2));
    }

    #[test]
    fn what_is_abandoned_is_not_dropped() {
        let drops = Drops::default();
        let first = reused::<8>(&drops, 3);
        let second = first.clone();
        first.abandon();
        assert_eq!(second.lock().bytes, [3; 8]);
        second.abandon();
        assert_eq!(drops.count(), 0);
    }
}
