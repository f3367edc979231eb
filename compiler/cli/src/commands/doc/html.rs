//! Pages as HTML: Markdown through pulldown-cmark, with links between pages kept.

use pulldown_cmark::{CowStr, Event, Options, Parser, Tag, html::push_html};

/// Looks of a page: readable without a network, in light and dark.
const STYLE: &str = "body{max-width:60rem;margin:2rem auto;padding:0 1rem;font:16px/1.5 system-ui,sans-serif;color:#222;background:#fff}\
    table{border-collapse:collapse;display:block;overflow-x:auto}td,th{border:1px solid #bbb;padding:.2rem .5rem;text-align:left;vertical-align:top}\
    code{background:#eee;padding:0 .2em}img{max-width:100%;height:auto;background:#fff}\
    @media(prefers-color-scheme:dark){body{color:#ddd;background:#1b1b1b}a{color:#8bf}code{background:#333}td,th{border-color:#555}}";

/// A page from its text in Markdown. HTML in the text is shown, not obeyed.
pub fn page(title: &str, markdown: &str) -> String {
    let events = Parser::new_ext(markdown, Options::ENABLE_TABLES).map(|event| match event {
        Event::Html(text) | Event::InlineHtml(text) => Event::Text(text),
        Event::Start(Tag::Link { link_type, dest_url, title, id }) => {
            Event::Start(Tag::Link { link_type, dest_url: link(dest_url), title, id })
        }
        other => other,
    });
    let mut body = String::new();
    push_html(&mut body, events);
    let shown = title.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>{shown}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n{body}</body>\n</html>\n"
    )
}

/// A link to another page of the catalogue leads to its HTML; a link that would run a script leads nowhere.
fn link(to: CowStr<'_>) -> CowStr<'_> {
    let lower = to.trim_start().to_ascii_lowercase();
    if ["javascript:", "data:", "vbscript:"].iter().any(|scheme| lower.starts_with(scheme)) {
        return "#".into();
    }
    match to.strip_suffix(".md") {
        Some("README") => "index.html".into(),
        Some(name) if !name.contains(':') => format!("{name}.html").into(),
        _ => to,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_lead_to_pages_and_html_is_shown() {
        let page = page(
            "a <b>",
            "# a\n\n[b](b.md) [x](https://x.org/y.md) [s](javascript:alert(1)) <script>alert(1)</script>\n\n| a |\n|---|\n| 1 |\n",
        );
        assert!(
            page.contains("<title>a &lt;b&gt;</title>") && page.contains("href=\"b.html\"") && page.contains("y.md"),
            "{page}"
        );
        assert!(!page.contains("<script") && !page.contains("javascript") && page.contains("<td>1</td>"), "{page}");
    }
}
