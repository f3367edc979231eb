//! Signals that end the process: what is half done is put back first.

/// From now on SIGINT, SIGTERM and SIGHUP put back what is half done (see `ltsc_render::guard`), and then end the process as they
/// would have, so that shells tell 130, 143 and 129. One that was ignored when the process began, as under `nohup`, stays ignored.
#[cfg(unix)]
pub fn end_cleanly() {
    use ltsc_render::guard;
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;
    use signal_hook::low_level::emulate_default_handler;

    let wanted = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|signal| !is_ignored(*signal));
    let Ok(mut signals) = Signals::new(wanted) else { return };
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            guard::put_back();
            let _ended = emulate_default_handler(signal);
        }
    });
}

/// Elsewhere the system ends the process as it is, and the next run puts in order what it left.
#[cfg(not(unix))]
pub fn end_cleanly() {}

/// Whether the caller asked that a signal be ignored.
#[cfg(target_os = "linux")]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigIgn:")?.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

#[cfg(all(unix, not(target_os = "linux")))]
fn is_ignored(_signal: i32) -> bool {
    false
}
