//! The terminal: colors, excerpts through miette, progress bars.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::{IsTerminal, Write as _};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use ltsc_core::diag::{Finding, Origin, Severity, Sources, Span};
use ltsc_evaluation::watch::Watch;
use miette::{
    Diagnostic, GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteError, MietteSpanContents, SourceCode,
    SourceSpan, SpanContents,
};

use crate::args::Choice;

static CHOICE: AtomicU8 = AtomicU8::new(0);

/// Remembers what `--color` says.
pub fn choose(choice: Choice) {
    let code = match choice {
        Choice::Auto => 0,
        Choice::Always => 1,
        Choice::Never => 2,
    };
    CHOICE.store(code, Ordering::Relaxed);
}

/// Whether to color one of the two outputs.
pub fn colored(to_stdout: bool) -> bool {
    match CHOICE.load(Ordering::Relaxed) {
        1 => true,
        2 => false,
        _ => {
            let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
            let terminal = if to_stdout { std::io::stdout().is_terminal() } else { std::io::stderr().is_terminal() };
            terminal && !set("NO_COLOR") && std::env::var_os("TERM").is_none_or(|term| term != "dumb")
        }
    }
}

/// Set when standard output could not be written for another reason than that nobody reads it.
static BROKEN: AtomicBool = AtomicBool::new(false);

/// Writes to standard output. A reader that goes away, as in `ltsc explain | head`, is no error; the exit code stays that
/// of the command. Anything else is said once and makes the command fail, see [`output_failed`].
pub fn print(text: &str) {
    let mut out = std::io::stdout().lock();
    if let Err(problem) = out.write_all(text.as_bytes()).and_then(|()| out.flush())
        && problem.kind() != std::io::ErrorKind::BrokenPipe
        && !BROKEN.swap(true, Ordering::Relaxed)
    {
        error(&format!("standard output cannot be written: {problem}"));
    }
}

/// Whether something that was printed did not arrive.
pub fn output_failed() -> bool {
    BROKEN.load(Ordering::Relaxed)
}

/// `text` without characters that a terminal would obey; line ends and tabs stay. Bytes keep their places.
pub fn harmless(text: &str) -> Cow<'_, str> {
    let obeyed = |c: char| c.is_control() && !matches!(c, '\n' | '\r' | '\t');
    if !text.contains(obeyed) {
        return Cow::Borrowed(text);
    }
    // One byte for the C0 controls and DEL, two for the C1 controls.
    let replaced = text.chars().map(|c| match c {
        c if !obeyed(c) => c,
        c if c.len_utf8() == 1 => '?',
        _ => '¿',
    });
    Cow::Owned(replaced.collect())
}

fn styled(code: &str, text: &str, to_stdout: bool) -> String {
    if colored(to_stdout) { format!("\x1b[{code}m{text}\x1b[0m") } else { text.to_owned() }
}

/// Bold text.
pub fn strong(text: &str, to_stdout: bool) -> String {
    styled("1", text, to_stdout)
}

/// Says to standard error what went wrong.
pub fn error(message: &str) {
    say(&format!("{} {}", styled("1;31", "error:", false), harmless(message)));
}

/// Says to standard error what can be done.
pub fn help(message: &str) {
    say(&format!("{} {}", styled("1;36", " help:", false), harmless(message)));
}

/// Says something to standard error.
pub fn say(message: &str) {
    ltsc_render::guard::stop_if_ending();
    let _written = writeln!(std::io::stderr(), "{message}");
}

/// The text of a panic.
pub fn panic_text(payload: &(dyn std::any::Any + Send)) -> String {
    let text = payload.downcast_ref::<String>().map(String::as_str).or_else(|| payload.downcast_ref::<&str>().copied());
    text.unwrap_or("unknown").to_owned()
}

/// "error" for what ends with an exit code of its own, "warning" and "info" for the rest.
pub fn severity_word(severity: Severity) -> &'static str {
    match severity {
        Severity::Error | Severity::Deny => "error",
        Severity::Warn => "warning",
        Severity::Info => "info",
        Severity::Allow => "allowed",
    }
}

/// A finding with its excerpt.
pub fn graphical(finding: &Finding, sources: &Sources, to_stdout: bool) -> String {
    let theme = match (colored(to_stdout), unicode()) {
        (true, true) => GraphicalTheme::unicode(),
        (true, false) => GraphicalTheme { characters: miette::ThemeCharacters::ascii(), ..GraphicalTheme::unicode() },
        (false, true) => GraphicalTheme::unicode_nocolor(),
        (false, false) => GraphicalTheme::none(),
    };
    let handler = GraphicalReportHandler::new_themed(theme).with_width(width()).with_links(false);
    let mut text = String::new();
    let shown = Shown::new(finding, sources);
    if handler.render_report(&mut text, &shown).is_err() {
        let _written = writeln!(text, "{}: {}", severity_word(finding.severity), finding.message);
    }
    for remark in &shown.remarks {
        let _written = writeln!(text, "  {}", harmless(remark));
    }
    for note in &finding.notes {
        let _written = writeln!(text, "  {} {}", styled("1;34", "note:", to_stdout), harmless(note));
    }
    if let Some(help) = &finding.help {
        let _written = writeln!(text, "  {} {}", styled("1;36", "help:", to_stdout), harmless(help));
    }
    text.push('\n');
    text
}

/// Whether the terminal shows more than ASCII. An unset locale is that of containers, whose terminals do.
fn unicode() -> bool {
    let locale = ["LC_ALL", "LC_CTYPE", "LANG"]
        .iter()
        .find_map(|name| std::env::var(name).ok().filter(|value| !value.is_empty()));
    let plain =
        |locale: &str| matches!(locale, "C" | "POSIX") || locale.to_ascii_lowercase().replace('-', "").contains("utf8");
    locale.is_none_or(|locale| plain(&locale))
}

/// Columns of the terminal, as the shell tells them, else 110.
fn width() -> usize {
    let columns = std::env::var("COLUMNS").ok().and_then(|value| value.parse().ok());
    columns.unwrap_or(110_usize).clamp(60, 160)
}

/// A finding as miette sees it: one file and the labels in it.
#[derive(Debug)]
struct Shown {
    id: &'static str,
    severity: Severity,
    message: String,
    source: Option<Excerpts>,
    labels: Vec<LabeledSpan>,
    /// Places that are in no excerpt.
    remarks: Vec<String>,
}

impl Shown {
    fn new(finding: &Finding, sources: &Sources) -> Self {
        let Finding {
            id,
            severity,
            message,
            origin,
            label,
            labels,
            notes: _,
            help: _,
            suppression: _,
            fixable: _,
            fix: _,
        } = finding;
        let mut shown = Self {
            id,
            severity: *severity,
            message: harmless(message).into_owned(),
            source: None,
            labels: Vec::new(),
            remarks: Vec::new(),
        };
        match origin {
            Origin::Text(span) if line_length(&sources.get(span.file).text, *span) > LONGEST_LINE => {
                let at = sources.position(span.file, span.start);
                let label = if label.is_empty() { String::new() } else { format!(": {label}") };
                shown.remarks.push(format!("{}:{}:{}{label}", sources.get(span.file).path, at.line, at.column));
            }
            Origin::Text(span) => {
                let file = sources.get(span.file);
                let shown_text = match harmless(&file.text) {
                    Cow::Borrowed(_) => Arc::clone(&file.text),
                    Cow::Owned(text) => Arc::from(text),
                };
                let text = (!label.is_empty()).then(|| harmless(label).into_owned());
                let range = (span.start as usize, (span.end - span.start) as usize);
                shown.labels.push(LabeledSpan::new_primary_with_span(text, range));
                shown.source = Some(Excerpts { path: harmless(&file.path).into_owned(), text: shown_text });
            }
            Origin::File { path, place } => {
                let place = if place.is_empty() { path.clone() } else { format!("{path}, {place}") };
                shown.remarks.push(format!("in {place}"));
                shown.remarks.extend((!label.is_empty()).then(|| label.clone()));
            }
            Origin::Made => {}
        }
        for other in labels {
            if shown.source.is_some() && origin.span().is_some_and(|span| span.file == other.span.file) {
                let range = (other.span.start as usize, (other.span.end - other.span.start) as usize);
                shown.labels.push(LabeledSpan::new_with_span(Some(harmless(&other.text).into_owned()), range));
            } else {
                let at = sources.position(other.span.file, other.span.start);
                let path = &sources.get(other.span.file).path;
                shown.remarks.push(format!("{path}:{}:{}: {}", at.line, at.column, other.text));
            }
        }
        shown
    }
}

/// A file that excerpts are taken from. Miette counts columns in bytes; people count characters.
#[derive(Debug)]
struct Excerpts {
    path: String,
    text: Arc<str>,
}

impl SourceCode for Excerpts {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        lines_before: usize,
        lines_after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let inner = self.text.read_span(span, lines_before, lines_after)?;
        let start = inner.span().offset();
        let line = self.text[..start].rfind('\n').map_or(0, |end| end + 1);
        let column = if inner.column() == 0 { 0 } else { self.text[line..start].chars().count() };
        Ok(Box::new(MietteSpanContents::new_named(
            self.path.clone(),
            inner.data(),
            *inner.span(),
            inner.line(),
            column,
            inner.line_count(),
        )))
    }
}

/// Lines longer than this many bytes are machine-made and are not shown.
const LONGEST_LINE: usize = 400;

/// Bytes of the lines that a span lies in, with the lines between them.
fn line_length(text: &str, span: Span) -> usize {
    let (start, end) = ((span.start as usize).min(text.len()), (span.end as usize).min(text.len()));
    let bytes = text.as_bytes();
    let before = bytes[..start].iter().rev().take_while(|byte| **byte != b'\n').count();
    let after = bytes[end..].iter().take_while(|byte| **byte != b'\n').count();
    let inner = bytes[start..end].split(|byte| *byte == b'\n').map(<[u8]>::len).max().unwrap_or(0);
    before + inner + after
}

impl std::fmt::Display for Shown {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Shown {}

impl Diagnostic for Shown {
    fn code<'a>(&'a self) -> Option<Box<dyn std::fmt::Display + 'a>> {
        Some(Box::new(self.id))
    }

    fn severity(&self) -> Option<miette::Severity> {
        Some(match self.severity {
            Severity::Error | Severity::Deny => miette::Severity::Error,
            Severity::Warn => miette::Severity::Warning,
            Severity::Info | Severity::Allow => miette::Severity::Advice,
        })
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.source.as_ref().map(|source| source as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        if self.labels.is_empty() { None } else { Some(Box::new(self.labels.iter().cloned())) }
    }
}

/// A progress bar on standard error that appears after a second, and only on a terminal.
pub struct Bar {
    bar: ProgressBar,
    started: Instant,
    hidden: bool,
}

impl Bar {
    /// A bar that counts to `total`, or spins where that is 0.
    pub fn new(total: u64, what: &str) -> Self {
        let bar = ProgressBar::with_draw_target(Some(total.max(1)), ProgressDrawTarget::hidden());
        let template = if total > 0 {
            "{msg:24!} {wide_bar} {percent:>3} %  {elapsed} of about {duration}"
        } else {
            "{spinner} {wide_msg} {elapsed}"
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.set_message(what.to_owned());
        Self { bar, started: Instant::now(), hidden: true }
    }

    fn appear(&mut self) {
        let shown = std::io::stderr().is_terminal();
        if self.hidden && shown && self.started.elapsed() > Duration::from_secs(1) {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
            self.hidden = false;
        }
    }

    /// Moves the bar.
    pub fn set(&mut self, done: u64) {
        self.appear();
        self.bar.set_position(done);
    }

    /// Changes the words and turns the spinner.
    pub fn say(&mut self, what: &str) {
        self.appear();
        self.bar.set_message(what.to_owned());
        self.bar.tick();
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// Shows the progress of what libraries do by a bar.
#[derive(Default)]
pub struct Watcher(Option<Bar>);

impl Watch for Watcher {
    fn begin(&mut self, total: u64, what: &str) {
        self.0 = Some(Bar::new(total, what));
    }

    fn set(&mut self, done: u64) {
        if let Some(bar) = &mut self.0 {
            bar.set(done);
        }
    }

    fn doing(&mut self, what: &str) {
        if let Some(bar) = &mut self.0 {
            bar.say(what);
        }
    }

    fn end(&mut self) {
        if let Some(bar) = self.0.take() {
            bar.finish();
        }
    }

    fn note(&mut self, text: &str) {
        say(text);
    }
}
