//! The state of a study: its finished runs, its references, and the forecast of the work that is left.

use super::forecast::Forecast;
use super::library::Library;
use super::pictures::Pictures;
use super::store::Store;

/// The state of a study, from which its results can be computed at any moment.
pub struct Ledger {
    /// The finished runs.
    pub store: Store,
    /// The references.
    pub library: Library,
    /// The pictures of runs, which only pages show.
    pub pictures: Pictures,
    /// The steps of work that are done and to come.
    pub forecast: Forecast,
}

/// A callback that receives the state of the study after each step of work. If it returns an error, the work ends with this
/// error. While a reference is rendered, it is called after some samples too.
pub type OnStep<'a> = dyn FnMut(&mut Ledger) -> crate::Result<()> + 'a;
