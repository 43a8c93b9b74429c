//! Threads of our own: rayon's global pool belongs to the program that uses the library.

use crate::render::RenderError;

/// A pool of so many threads; of as many as there are cores where none is told.
pub(crate) fn pool(threads: Option<usize>) -> Result<rayon::ThreadPool, RenderError> {
    let threads = threads.unwrap_or_else(cores);
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|i| format!("etendue {i}"))
        .build()
        .map_err(|e| RenderError(format!("{threads} threads cannot be started: {e}\n  help: fewer will do, with --threads")))
}

/// Cores that this process may use.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}
