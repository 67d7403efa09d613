//! Elements and escaped text: what HTML, SVG and JUnit are made of.
//!
//! Text enters a document through [`Markup::text`] or an attribute and is escaped there; nothing else writes it, so
//! no field of a result can become an element. The output is well-formed XML, HTML included.

use std::fmt::Write;

use crate::printable;

/// Elements that stay on the line of what precedes them.
const INLINE: &[&str] =
    &["a", "b", "br", "code", "em", "small", "span", "strong", "sub", "sup", "td", "th", "tspan"];

/// A document or a part of one.
#[derive(Debug, Default)]
pub(crate) struct Markup {
    out: String,
    open: Vec<&'static str>,
}

/// Attributes of an element: names are ours, values are escaped.
pub(crate) type Attributes<'a> = &'a [(&'static str, &'a str)];

impl Markup {
    /// Opens an element.
    pub(crate) fn open(&mut self, tag: &'static str, attributes: Attributes<'_>) {
        self.start(tag, attributes);
        self.out.push('>');
        self.open.push(tag);
    }

    /// Closes the element opened last.
    pub(crate) fn close(&mut self) {
        if let Some(tag) = self.open.pop() {
            // Writing to a string cannot fail.
            let _ = write!(self.out, "</{tag}>");
        }
    }

    /// An element with text and nothing else in it.
    pub(crate) fn element(&mut self, tag: &'static str, attributes: Attributes<'_>, text: &str) {
        self.open(tag, attributes);
        self.text(text);
        self.close();
    }

    /// An element without content.
    pub(crate) fn empty(&mut self, tag: &'static str, attributes: Attributes<'_>) {
        self.start(tag, attributes);
        self.out.push_str("/>");
    }

    /// Escaped text.
    pub(crate) fn text(&mut self, text: &str) {
        escape(&mut self.out, text);
    }

    /// An element whose content `fill` writes.
    pub(crate) fn within(
        &mut self,
        tag: &'static str,
        attributes: Attributes<'_>,
        fill: impl FnOnce(&mut Self),
    ) {
        self.open(tag, attributes);
        fill(self);
        self.close();
    }

    /// Markup of our own making, e.g. a style sheet or a finished picture; never text from a result.
    pub(crate) fn verbatim(&mut self, markup: &str) {
        self.out.push_str(markup);
    }

    /// The finished text, with every element closed and one newline at the end.
    pub(crate) fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.close();
        }
        self.out.push('\n');
        self.out
    }

    fn start(&mut self, tag: &'static str, attributes: Attributes<'_>) {
        if !self.out.is_empty() && !self.out.ends_with('\n') && !INLINE.contains(&tag) {
            self.out.push('\n');
        }
        self.out.push('<');
        self.out.push_str(tag);
        for (name, value) in attributes {
            let _ = write!(self.out, " {name}=\"");
            escape(&mut self.out, value);
            self.out.push('"');
        }
    }
}

/// Escapes for content and quoted attributes; characters that XML 1.0 forbids become U+FFFD.
fn escape(out: &mut String, text: &str) {
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            _ => out.push(printable::character(c)),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Why a text is not well-formed, as far as our writers can go wrong: tags, attributes and entities.
    pub(crate) fn malformed(text: &str) -> Option<String> {
        let mut open: Vec<&str> = Vec::new();
        let mut rest = text;
        while let Some(at) = rest.find('<') {
            if let Some(problem) = bad_entity(&rest[..at]) {
                return Some(problem);
            }
            let end = rest[at..].find('>').map(|e| at + e)?;
            let tag = &rest[at + 1..end];
            rest = &rest[end + 1..];
            if tag.starts_with(['?', '!']) {
                continue;
            }
            if let Some(name) = tag.strip_prefix('/') {
                match open.pop() {
                    Some(expected) if expected == name => {}
                    other => return Some(format!("</{name}> closes {other:?}")),
                }
            } else {
                let inner = tag.strip_suffix('/').unwrap_or(tag);
                if !inner.matches('"').count().is_multiple_of(2) || inner.contains('<') {
                    return Some(format!("attributes of <{tag}>"));
                }
                if !tag.ends_with('/') {
                    open.push(inner.split_whitespace().next().unwrap_or(""));
                }
            }
        }
        if !open.is_empty() {
            return Some(format!("left open: {open:?}"));
        }
        bad_entity(rest)
    }

    fn bad_entity(text: &str) -> Option<String> {
        let known = ["amp;", "lt;", "gt;", "quot;", "#39;"];
        text.split('&')
            .skip(1)
            .find(|t| !known.iter().any(|k| t.starts_with(k)))
            .map(|t| format!("bare ampersand before `{t}`"))
    }

    #[test]
    fn text_and_attributes_cannot_become_elements() {
        let mut m = Markup::default();
        m.within("p", &[("title", "\"><script>")], |m| m.text("<script>alert('1' & 2)\u{0}</script>"));
        let text = m.finish();
        assert_eq!(
            text,
            "<p title=\"&quot;&gt;&lt;script&gt;\">&lt;script&gt;alert(&#39;1&#39; &amp; 2)\u{fffd}&lt;/script&gt;</p>\n"
        );
        assert_eq!(malformed(&text), None);
    }

    #[test]
    fn the_checker_finds_what_it_is_for() {
        for bad in ["<p>", "<p></a>", "<p>a & b</p>", "<p a=\"1></p>", "</p>"] {
            assert!(malformed(bad).is_some(), "{bad}");
        }
    }

    #[test]
    fn what_is_left_open_is_closed_in_the_end() {
        let mut m = Markup::default();
        m.open("ul", &[]);
        m.open("li", &[]);
        m.text("x");
        assert_eq!(m.finish(), "<ul>\n<li>x</li></ul>\n");
    }
}
