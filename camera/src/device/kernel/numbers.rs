//! Numbers of a driver's queue, and the memory that the kernel knows by each.

/// One number.
struct Slot<L> {
    /// The address that the kernel knows by this number; 0 before the first.
    address: usize,
    loan: Option<L>,
}

/// All numbers of a queue. Memory (`L`) that the driver has lies in here.
pub(super) struct Numbers<L> {
    slots: Vec<Slot<L>>,
    repins: u64,
}

impl<L> Numbers<L> {
    pub(super) fn new(count: usize) -> Numbers<L> {
        Numbers { slots: (0..count).map(|_| Slot { address: 0, loan: None }).collect(), repins: 0 }
    }

    pub(super) fn count(&self) -> usize {
        self.slots.len()
    }

    /// Pieces of memory that the driver has.
    pub(super) fn lent(&self) -> usize {
        self.slots.iter().filter(|slot| slot.loan.is_some()).count()
    }

    /// How often memory got a number under which the kernel knew other memory, which it then had to pin anew.
    pub(super) fn repins(&self) -> u64 {
        self.repins
    }

    /// The number under which the kernel knows this memory; else one that was never used; else any that is free; `None` when the
    /// driver has them all.
    pub(super) fn number_for(&self, address: usize) -> Option<usize> {
        let free = |wanted: &dyn Fn(&Slot<L>) -> bool| {
            self.slots.iter().position(|slot| slot.loan.is_none() && wanted(slot))
        };
        free(&|slot| slot.address == address)
            .or_else(|| free(&|slot| slot.address == 0))
            .or_else(|| free(&|_| true))
    }

    /// Keeps what the driver now has under a number.
    pub(super) fn keep(&mut self, number: usize, address: usize, loan: L) {
        let slot = &mut self.slots[number];
        self.repins += u64::from(slot.address != address && slot.address != 0);
        (slot.address, slot.loan) = (address, Some(loan));
    }

    /// What the driver had under a number; `None` when it had nothing there.
    pub(super) fn take(&mut self, number: usize) -> Option<L> {
        self.slots.get_mut(number).and_then(|slot| slot.loan.take())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hands each address over and takes it back at once.
    fn pass(numbers: &mut Numbers<()>, addresses: impl IntoIterator<Item = usize>) {
        for address in addresses {
            let number = numbers.number_for(address).unwrap();
            numbers.keep(number, address, ());
            numbers.take(number).unwrap();
        }
    }

    #[test]
    fn with_a_number_for_each_piece_of_memory_none_is_pinned_twice() {
        let mut numbers = Numbers::new(5);
        pass(&mut numbers, (0..100).map(|i| 4096 * (1 + i * 7 % 5)));
        assert_eq!(numbers.repins(), 0);
    }

    #[test]
    fn with_fewer_numbers_than_memory_each_change_of_address_is_counted() {
        let mut numbers = Numbers::new(2);
        pass(&mut numbers, [1, 2, 1, 2, 3, 3, 2, 1]);
        // 3 took the number of 1, and 1 took it back.
        assert_eq!(numbers.repins(), 2);
    }

    #[test]
    fn memory_that_the_driver_has_keeps_its_number_and_comes_back_once() {
        let mut numbers = Numbers::new(2);
        numbers.keep(0, 8, 'a');
        assert_eq!((numbers.number_for(8), numbers.lent()), (Some(1), 1));
        numbers.keep(1, 16, 'b');
        assert_eq!(numbers.number_for(24), None);
        assert_eq!((numbers.take(0), numbers.take(0), numbers.take(7)), (Some('a'), None, None));
        assert_eq!(numbers.number_for(8), Some(0));
    }
}
