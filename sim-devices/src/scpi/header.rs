//! Mnemonics: the capitals of a pattern are the short form, all of it the long form, nothing between is known.

/// Whether a header is that of a pattern such as `SENSe#:FREQuency:STARt`, where `#` stands for a number at the end of a
/// node, 1 if it is left out; gives these numbers.
pub(crate) fn matches(pattern: &str, header: &str) -> Option<Vec<u32>> {
    let mut numbers = Vec::new();
    let mut nodes = header.split(':');
    for wanted in pattern.split(':') {
        let found = nodes.next()?;
        match wanted.strip_suffix('#') {
            None if word_matches(wanted, found) => {}
            None => return None,
            Some(wanted) => {
                let word = found.trim_end_matches(|c: char| c.is_ascii_digit());
                let number = &found[word.len()..];
                if !word_matches(wanted, word) {
                    return None;
                }
                numbers.push(if number.is_empty() { 1 } else { number.parse().ok()? });
            }
        }
    }
    nodes.next().is_none().then_some(numbers)
}

/// Whether a word is the short or the long form.
pub(crate) fn word_matches(pattern: &str, word: &str) -> bool {
    let is_short = || {
        let short = pattern.chars().filter(|c| !c.is_ascii_lowercase());
        short.map(|c| c.to_ascii_uppercase()).eq(word.chars().map(|c| c.to_ascii_uppercase()))
    };
    pattern.eq_ignore_ascii_case(word) || is_short()
}
