//! News of what goes on, for whoever shows them.

/// Shows how far a piece of work is.
pub trait Watch {
    /// A piece of work of `total` steps begins.
    fn begin(&mut self, total: u64, what: &str);
    /// So many steps are done.
    fn set(&mut self, done: u64);
    /// What is being done now.
    fn doing(&mut self, what: &str);
    /// The piece of work has ended.
    fn end(&mut self);
    /// Something that people should read.
    fn note(&mut self, text: &str);
}

/// Shows nothing.
pub struct Unwatched;

impl Watch for Unwatched {
    fn begin(&mut self, _total: u64, _what: &str) {}
    fn set(&mut self, _done: u64) {}
    fn doing(&mut self, _what: &str) {}
    fn end(&mut self) {}
    fn note(&mut self, _text: &str) {}
}
