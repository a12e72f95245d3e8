//! The state of a study: its finished runs, its references, its pictures, and the forecast of the work that
//! is left.

use super::forecast::Forecast;
use super::library::Library;
use super::pictures::Pictures;
use super::store::Store;

/// The state of a study: everything that is finished, from which the results can be computed at any moment,
/// and a forecast of the rest.
pub struct Ledger {
    /// The finished runs, in memory and in the file `runs.jsonl`.
    pub store: Store,
    /// The references with which frames are compared, from the files of the study's folder.
    pub library: Library,
    /// The last frames of one run of each configuration, which only pages show.
    pub pictures: Pictures,
    /// The numbers of steps of work that are done and still to come, from which progress is reported.
    pub forecast: Forecast,
}

/// A callback that receives the state of the study after each step of work. If it returns an error, the work ends with this
/// error. While a reference is rendered, it is called after some samples too.
pub type OnStep<'a> = dyn FnMut(&mut Ledger) -> crate::Result<()> + 'a;
