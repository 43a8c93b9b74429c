//! Ctrl-C: the first one asks the work to stop, the second ends the program.

use super::output;
use etendue_solvers::CancelToken;
use std::sync::Arc;

/// What is said on the way; nothing where a command is silent.
#[derive(Clone, Copy, Default)]
pub struct Words {
    /// When asked to stop.
    pub asked: Option<&'static str>,
    /// When ended at once.
    pub ended: Option<&'static str>,
}

/// Listens from now on. `token` finds the request to stop within what shares it; `loss` says what Ctrl-C will do where nobody can listen.
pub fn stop_on_ctrl_c<T: Send + Sync + 'static>(shared: &Arc<T>, token: fn(&T) -> &CancelToken, words: Words, loss: &str) {
    let shared = Arc::clone(shared);
    let say = |words: Option<&str>| words.into_iter().for_each(output::message);
    let handler = move || {
        let cancel = token(&shared);
        if cancel.is_cancelled() {
            say(words.ended);
            #[expect(clippy::exit, reason = "the user has asked twice")]
            std::process::exit(130);
        }
        cancel.cancel();
        say(words.asked);
    };
    if let Err(e) = ctrlc::set_handler(handler) {
        output::message(&format!("warning: Ctrl-C will {loss}: {e}"));
    }
}
