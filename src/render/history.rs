//! A resource in two copies that exchange their roles: one for the data of this frame, and one with the data of the previous
//! frame, which temporal reuse reads. If nothing is reused, one copy is enough.

use std::cell::Cell;

/// A resource, such as a buffer of reservoirs, in one or two copies. The current copy belongs to this frame. If there is a
/// second copy, it stores the data of the previous frame, so that this frame can reuse it. [`Self::advance`] exchanges the
/// roles of the copies, without copying data.
pub struct History<T> {
    copies: Vec<T>,
    current: Cell<usize>,
    /// The number of calls of [`Self::advance`] since the last reset. From the second call on, the copy that is not current
    /// contains data, and [`Self::previous`] returns it.
    advances: Cell<usize>,
}

impl<T> History<T> {
    /// Makes a history from `copies`: one or two resources of the same size, such as buffers. One copy is enough if no frame
    /// reads the data of the previous frame, and no pass needs a second copy for its output.
    pub fn new(copies: Vec<T>) -> Self {
        debug_assert!(matches!(copies.len(), 1 | 2));
        Self {
            copies,
            current: Cell::new(0),
            advances: Cell::new(0),
        }
    }

    /// The copy that belongs to this frame. The passes of the frame write it, and later passes read it.
    pub fn current(&self) -> &T {
        &self.copies[self.current.get()]
    }

    /// The copy with the data of the previous frame: the one that was current before the last call of [`Self::advance`].
    /// `None` if there is only one copy. Also `None` after fewer than two calls of [`Self::advance`] since the last reset,
    /// because this copy then contains no data.
    pub fn previous(&self) -> Option<&T> {
        (self.copies.len() == 2 && self.advances.get() > 1).then(|| self.spare())
    }

    /// The spare copy of the resource, which is the one that is not current; if there is only one copy, the current one. At
    /// the start of a frame, the spare copy contains the data of the previous frame. When this data is no longer needed, a
    /// pass can read the current copy and write its output to the spare one. [`Self::advance`] then makes this output
    /// current.
    pub fn spare(&self) -> &T {
        &self.copies[(self.current.get() + 1) % self.copies.len()]
    }

    /// Makes the spare copy of the resource the current one, and the current copy the spare one. It is called at the start
    /// of each frame, and after each pass that wrote its output to the spare copy. If there is only one copy, it stays
    /// current.
    pub fn advance(&self) {
        self.current
            .set((self.current.get() + 1) % self.copies.len());
        self.advances.set(self.advances.get() + 1);
    }

    /// Forgets the data of the previous frame, for a restart: [`Self::previous`] returns `None` until the second call of
    /// [`Self::advance`].
    pub fn reset(&self) {
        self.advances.set(0);
    }

    /// All copies of the resource, one or two, in an order that is the same in all frames. Callers clear the copies and add
    /// up their sizes.
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
