//! What threads find in any order, put back in the order of a single one.

use std::sync::{Mutex, PoisonError};

/// Finds, each with the number of what it was found in. Finds are rare beside the work, so one list for all threads is
/// enough, and it grows as the list of a single thread would.
pub(crate) struct Numbered<T>(Mutex<Vec<(usize, T)>>);

impl<T> Default for Numbered<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T: Copy> Numbered<T> {
    /// Takes a find. Numbers must differ.
    pub(crate) fn add(&self, number: usize, find: T) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push((number, find));
    }

    /// Appends all finds to `list` by their numbers, and forgets them.
    pub(crate) fn move_to(&mut self, list: &mut Vec<T>) {
        let finds = self.0.get_mut().unwrap_or_else(PoisonError::into_inner);
        finds.sort_unstable_by_key(|(number, _)| *number);
        list.extend(finds.iter().map(|(_, find)| *find));
        finds.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_come_back_by_their_numbers_and_are_forgotten() {
        let mut finds = Numbered::default();
        for number in [5, 2, 9, 0] {
            finds.add(number, number * 10);
        }
        let mut list = vec![7];
        finds.move_to(&mut list);
        assert_eq!(list, [7, 0, 20, 50, 90]);
        finds.move_to(&mut list);
        assert_eq!(list.len(), 5);
    }
}
