//! What people should know of the disk while they wait.

use std::sync::OnceLock;

static SHOW: OnceLock<fn(&str)> = OnceLock::new();

/// Sends what is to be said to `show`, once for the process; nothing is shown before.
pub fn show_by(show: fn(&str)) {
    let _first = SHOW.set(show);
}

pub(super) fn say(text: &str) {
    if let Some(show) = SHOW.get() {
        show(text);
    }
}
