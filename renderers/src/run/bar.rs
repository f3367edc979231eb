//! What progress bars and closing words of renderers say.

use super::Said;

/// PBRT's `Rendering: [++++    ]  (1.5s|2.0s)` (`progressreporter.cpp` of versions 3 and 4), whose end names no rest:
/// `[++++++++]  (3.5s)`, and Mitsuba 0.x's `Rendering: [+++   ] (1.2s, ETA: 3.4s)` (`statistics.cpp`).
pub(super) fn plusses(line: &str) -> Option<Said> {
    let (title, rest) = line.trim_start().split_once(": [")?;
    // Accelerators and photon maps have bars of their own.
    if title != "Rendering" {
        return None;
    }
    let (bar, times) = rest.split_once(']')?;
    let done = bar.bytes().take_while(|byte| *byte == b'+').count();
    if bar.is_empty() || bar.bytes().skip(done).any(|byte| byte != b' ') {
        return None;
    }
    if done == bar.len() {
        let whole = times.trim().strip_prefix('(').and_then(|times| times.strip_suffix("s)"));
        if let Some(took) = whole.and_then(|seconds| seconds.parse().ok()) {
            return Some(Said::Took(took));
        }
    }
    Some(Said::Part(done as f64 / bar.len() as f64))
}

/// Mitsuba 0.x, whose log ends with `Render time: 1.2345s` in a unit of its own choice (`timeString` in `util.cpp`).
pub(super) fn mitsuba(line: &str) -> Option<Said> {
    let Some((_, time)) = line.split_once("Render time: ") else { return plusses(line) };
    let time = time.trim();
    let split = time.find(|char: char| char.is_ascii_alphabetic())?;
    let (number, unit) = time.split_at(split);
    let scale = match unit {
        "s" => 1.0,
        "m" => 60.0,
        "h" => 3600.0,
        // Its days have twelve hours.
        "d" => 12.0 * 3600.0,
        _ => return None,
    };
    number.parse::<f64>().ok().map(|number| Said::Took(number * scale))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_tell_their_share() {
        assert_eq!(plusses("Rendering: [++  ] "), Some(Said::Part(0.5)));
        assert_eq!(plusses("\rRendering: [    ]  (0.2s|?s)  "), Some(Said::Part(0.0)));
        assert_eq!(plusses("Rendering: [+++ ]  (1.5s|0.5s)  "), Some(Said::Part(0.75)));
        assert_eq!(plusses("Rendering: [++++]  (3.5s)       "), Some(Said::Took(3.5)));
        assert_eq!(plusses("Rendering: [++++] (3.5s, ETA: 0s)  "), Some(Said::Part(1.0)));
    }

    #[test]
    fn other_lines_tell_nothing() {
        for line in ["", "Building BVH: [++  ]", "Rendering: [", "Rendering: []", "Rendering: [abc]"] {
            assert_eq!(plusses(line), None, "{line}");
        }
    }

    #[test]
    fn mitsuba_tells_its_time_in_any_unit() {
        let line = "2017-07-29 12:00:00 INFO  ren0 [RenderJob] Render time: ";
        for (time, seconds) in [("1.5000s", 1.5), ("2.0000m", 120.0), ("1.0000h", 3600.0), ("1.0000d", 43_200.0)] {
            assert_eq!(mitsuba(&format!("{line}{time}")), Some(Said::Took(seconds)));
        }
        assert_eq!(mitsuba(&format!("{line}soon")), None);
        assert_eq!(mitsuba("Rendering: [+ ] (1s, ETA: 1s)"), Some(Said::Part(0.5)));
    }
}
