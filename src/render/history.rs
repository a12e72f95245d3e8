//! A resource with two copies: one that this frame writes, and one that holds the data of the previous frame.

use std::cell::Cell;

/// A resource, such as a buffer, in one or two copies. The current copy belongs to this frame; the second copy, if there is
/// one, keeps the data of the previous frame.
pub struct History<T> {
    copies: Vec<T>,
    current: Cell<usize>,
    /// The number of calls of [`Self::advance`] since the last reset. After the second call, the spare copy holds data.
    advances: Cell<usize>,
}

impl<T> History<T> {
    /// A resource that consists of `copies`: one copy without history, or two copies with history.
    pub fn new(copies: Vec<T>) -> Self {
        debug_assert!(matches!(copies.len(), 1 | 2));
        Self {
            copies,
            current: Cell::new(0),
            advances: Cell::new(0),
        }
    }

    /// The copy that the passes of this frame write.
    pub fn current(&self) -> &T {
        &self.copies[self.current.get()]
    }

    /// The copy that was current before the last call of [`Self::advance`]. `None` if there is only one copy, and before the
    /// second call after a reset, because the copy holds no data until then.
    pub fn previous(&self) -> Option<&T> {
        (self.copies.len() == 2 && self.advances.get() > 1).then(|| self.spare())
    }

    /// The copy that is not current; with one copy, it is the current one. It holds the data of the previous frame, until a
    /// pass replaces them by what it makes from the current copy.
    pub fn spare(&self) -> &T {
        &self.copies[(self.current.get() + 1) % self.copies.len()]
    }

    /// Makes the spare copy the current one. This happens at the start of a frame, and after a pass that wrote the spare
    /// copy.
    pub fn advance(&self) {
        self.current
            .set((self.current.get() + 1) % self.copies.len());
        self.advances.set(self.advances.get() + 1);
    }

    /// Forgets the previous frame: [`Self::previous`] returns `None` until the second call of [`Self::advance`].
    pub fn reset(&self) {
        self.advances.set(0);
    }

    /// All copies, in a fixed order that does not depend on the frame; for clearing them and adding up their memory.
    pub fn all(&self) -> &[T] {
        &self.copies
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_previous_copy_is_the_one_before_the_last_advance() {
        let history = History::new(vec!['a', 'b']);
        history.advance();
        let first = *history.current();
        assert_eq!(history.previous(), None, "the first frame has no history");
        history.advance();
        assert_eq!(history.previous(), Some(&first));
        assert_ne!(*history.current(), first);
        history.reset();
        history.advance();
        assert_eq!(history.previous(), None, "nothing is left after a reset");
    }

    #[test]
    fn one_copy_has_no_history() {
        let history = History::new(vec![1]);
        for _ in 0..3 {
            history.advance();
            assert_eq!((history.current(), history.previous()), (&1, None));
            assert_eq!(history.spare(), &1);
        }
    }
}
