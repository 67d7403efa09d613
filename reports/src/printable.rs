//! Text from files and people as it may be shown: without characters that steer a terminal.

/// The character itself, or U+FFFD in the place of a control character that is neither tab nor line feed: an escape
/// sequence in a title or a path would otherwise be obeyed by whatever shows the text.
pub fn character(c: char) -> char {
    match c {
        '\t' | '\n' => c,
        '\u{fffe}' | '\u{ffff}' => '\u{fffd}',
        c if c.is_control() => '\u{fffd}',
        c => c,
    }
}

/// A text without what cannot be printed; a carriage return before a line feed is dropped.
pub fn text(text: &str) -> String {
    text.replace("\r\n", "\n").chars().map(character).collect()
}

/// A number with its noun, in the plural unless there is one: `1 point`, `2 points`.
pub fn counted(count: usize, noun: &str) -> String {
    let ending = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{ending}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_steers_a_terminal_is_replaced_and_everything_else_stays() {
        assert_eq!(text("a\u{1b}[31mb\u{9b}2J\u{7}\u{7f}"), "a\u{fffd}[31mb\u{fffd}2J\u{fffd}\u{fffd}");
        assert_eq!(text("1\r\n2\t±0.1 °\n"), "1\n2\t±0.1 °\n");
        assert_eq!(text("3\r4"), "3\u{fffd}4");
    }

    #[test]
    fn only_one_is_in_the_singular() {
        assert_eq!([0, 1, 2].map(|n| counted(n, "point")), ["0 points", "1 point", "2 points"]);
    }
}
