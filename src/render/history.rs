//! A resource with two copies: one that this frame writes, and one that the previous frame left.

use std::cell::Cell;

/// A resource in one or two copies: that of this frame, and with two copies that of the previous frame.
pub struct History<T> {
    copies: Vec<T>,
    current: Cell<usize>,
    /// Advances since the last reset.
    advances: Cell<usize>,
}

impl<T> History<T> {
    /// A resource with `copies`, one or two of them.
    pub fn new(copies: Vec<T>) -> Self {
        debug_assert!(matches!(copies.len(), 1 | 2));
        Self {
            copies,
            current: Cell::new(0),
            advances: Cell::new(0),
        }
    }

    /// The copy of this frame.
    pub fn current(&self) -> &T {
        &self.copies[self.current.get()]
    }

    /// The copy that was current before the last advance. `None` with one copy, and until the second advance after a reset,
    /// because it holds no frame until then.
    pub fn previous(&self) -> Option<&T> {
        (self.copies.len() == 2 && self.advances.get() > 1).then(|| self.spare())
    }

    /// The copy that is not current, to be written by a pass that reads the current one; with one copy the
    /// current one. Its contents are those of [`Self::previous`].
    pub fn spare(&self) -> &T {
        &self.copies[(self.current.get() + 1) % self.copies.len()]
    }

    /// Makes the spare copy the current one: at the start of a frame, and after a pass that wrote the spare
    /// copy.
    pub fn advance(&self) {
        self.current
            .set((self.current.get() + 1) % self.copies.len());
        self.advances.set(self.advances.get() + 1);
    }

    /// Forgets the previous frame.
    pub fn reset(&self) {
        self.advances.set(0);
    }

    /// All copies.
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
