//! A kind's documentation as markup: headings, paragraphs, lists; nothing else of Markdown.

use crate::markup::Markup;

#[derive(Clone, Copy, PartialEq)]
enum Block {
    None,
    Paragraph,
    List,
}

/// Writes the text. `# Heading` (any depth) becomes a heading, `- item` or `* item` a list; a blank line ends a
/// paragraph.
pub(super) fn write(m: &mut Markup, text: &str) {
    let mut block = Block::None;
    for line in text.lines().map(str::trim) {
        let item = line.strip_prefix("- ").or_else(|| line.strip_prefix("* "));
        if line.is_empty() {
            change(m, &mut block, Block::None);
        } else if let Some(heading) = heading(line) {
            change(m, &mut block, Block::None);
            m.element("h4", &[], heading);
        } else if let Some(item) = item {
            change(m, &mut block, Block::List);
            m.open("li", &[]);
            inline(m, item);
            m.close();
        } else {
            if block == Block::Paragraph {
                m.text(" ");
            }
            change(m, &mut block, Block::Paragraph);
            inline(m, line);
        }
    }
    change(m, &mut block, Block::None);
}

fn heading(line: &str) -> Option<&str> {
    let text = line.strip_prefix('#')?.trim_start_matches('#').trim();
    (!text.is_empty()).then_some(text)
}

fn change(m: &mut Markup, block: &mut Block, to: Block) {
    if *block == to {
        return;
    }
    if *block != Block::None {
        m.close();
    }
    match to {
        Block::None => {}
        Block::Paragraph => m.open("p", &[]),
        Block::List => m.open("ul", &[]),
    }
    *block = to;
}

/// Text with `code` between back ticks.
fn inline(m: &mut Markup, text: &str) {
    for (i, part) in text.split('`').enumerate() {
        if i % 2 == 1 {
            m.element("code", &[], part);
        } else {
            m.text(part);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
