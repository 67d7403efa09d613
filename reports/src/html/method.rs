//! A kind's documentation as markup: headings, paragraphs, lists; nothing else of Markdown.

use crate::markup::Markup;

/// A piece of the text, its lines joined.
#[derive(Debug)]
enum Block {
    Heading(String),
    Paragraph(String),
    Item(String),
}

/// Writes the text. `# Heading` (any depth) becomes a heading, `- item` or `* item` a list, ``code`` and `*emphasis*`
/// what they say; a blank line ends a paragraph or item, any other line continues it.
pub(super) fn write(m: &mut Markup, text: &str) {
    let mut in_list = false;
    for block in blocks(text) {
        let item = matches!(block, Block::Item(_));
        if item != in_list {
            if item {
                m.open("ul", &[])
            } else {
                m.close()
            }
            in_list = item;
        }
        match block {
            Block::Heading(text) => m.element("h4", &[], &text),
            Block::Paragraph(text) => written(m, "p", &text),
            Block::Item(text) => written(m, "li", &text),
        }
    }
    if in_list {
        m.close();
    }
}

fn blocks(text: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut open = false;
    for line in text.lines().map(str::trim) {
        let item = line.strip_prefix("- ").or_else(|| line.strip_prefix("* "));
        if line.is_empty() {
            open = false;
        } else if let Some(heading) = heading(line) {
            blocks.push(Block::Heading(heading.to_owned()));
            open = false;
        } else if let Some(item) = item {
            blocks.push(Block::Item(item.to_owned()));
            open = true;
        } else if let (true, Some(Block::Paragraph(text) | Block::Item(text))) = (open, blocks.last_mut()) {
            text.push(' ');
            text.push_str(line);
        } else {
            blocks.push(Block::Paragraph(line.to_owned()));
            open = true;
        }
    }
    blocks
}

fn heading(line: &str) -> Option<&str> {
    let text = line.strip_prefix('#')?.trim_start_matches('#').trim();
    (!text.is_empty()).then_some(text)
}

fn written(m: &mut Markup, tag: &'static str, text: &str) {
    m.open(tag, &[]);
    for (i, part) in text.split('`').enumerate() {
        if i % 2 == 1 {
            m.element("code", &[], part);
        } else {
            emphasised(m, part);
        }
    }
    m.close();
}

/// `*word*` is emphasis; a star that has no partner stays a star.
fn emphasised(m: &mut Markup, mut text: &str) {
    while let Some((before, rest)) = text.split_once('*')
        && let Some((inside, after)) = rest.split_once('*')
        && !inside.is_empty()
        && !inside.starts_with(' ')
    {
        m.text(before);
        m.element("em", &[], inside);
        text = after;
    }
    m.text(text);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_go_on_over_lines_and_stars_are_emphasis() {
        let mut m = Markup::default();
        write(&mut m, "- *Friction* is half\n  the difference\n- N*m stays\n\nEnd 2*3.");
        assert_eq!(
            m.finish(),
            "<ul>\n<li><em>Friction</em> is half the difference</li>\n<li>N*m stays</li></ul>\n<p>End 2*3.</p>\n"
        );
    }

    #[test]
    fn headings_paragraphs_lists_and_code() {
        let mut m = Markup::default();
        write(&mut m, "## What it finds\nFriction,\nper `velocity`.\n\n- one\n- <two>\n\nEnd.");
        assert_eq!(
            m.finish(),
            "<h4>What it finds</h4>\n<p>Friction, per <code>velocity</code>.</p>\n<ul>\n<li>one</li>\n\
             <li>&lt;two&gt;</li></ul>\n<p>End.</p>\n"
        );
    }
}
