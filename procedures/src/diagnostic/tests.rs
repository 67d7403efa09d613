use proptest::prelude::*;

use super::*;

fn source() -> SourceFile {
    SourceFile::new("fat/az-friction.toml", "schema = 1\n\tvelocty = [\"µ\"]\r\nspan = 3")
}

#[test]
fn a_mistake_prints_like_a_compilers_with_carets_under_the_word() {
    let at = source().text.find("velocty").expect("the word stands in the text");
    let mistake =
        Diagnostic::new("unknown key `velocty`").at(&source(), at..at + 7).help("did you mean `velocity`?");
    insta::assert_snapshot!(mistake.to_string(), @r#"
    error: unknown key `velocty`
     --> fat/az-friction.toml:2:2
      |
    2 |  velocty = ["µ"]
      |  ^^^^^^^
      = help: did you mean `velocity`?
    "#);
}

#[test]
fn columns_count_characters_and_the_carriage_return_is_not_shown() {
    let at = source().text.find("\"]").expect("the quote stands in the text");
    let mistake = Diagnostic::new("x").at(&source(), at..at + 40);
    assert_eq!(mistake.line, Some(2));
    assert_eq!(mistake.excerpt, Some((" velocty = [\"µ\"]".to_owned(), 14..17)));
}

#[test]
fn a_very_long_line_is_shown_around_the_mistake_only() {
    let source = SourceFile::new("long.toml", format!("{}WRONG{}", "a".repeat(500), "b".repeat(500)));
    let text = Diagnostic::new("x").at(&source, 500..505).to_string();
    assert!(text.contains("long.toml:1:501"), "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 150), "{text}");
    let line = text.lines().nth(3).expect("excerpt");
    let carets = text.lines().nth(4).expect("carets");
    assert_eq!(line.find("WRONG"), carets.find("^^^^^"), "{text}");
}

#[test]
fn a_mistake_without_a_place_is_one_line_and_a_help() {
    assert_eq!(
        Diagnostic::new("no unit").help("say which").to_string(),
        "error: no unit\n  = help: say which"
    );
}

#[test]
fn nearest_finds_swapped_missing_and_wrong_letters_but_not_another_word() {
    let known = ["velocity", "span", "cycles"];
    assert_eq!(nearest("velocty", known), Some("velocity"));
    assert_eq!(nearest("VELOCITY", known), Some("velocity"));
    assert_eq!(nearest("cylces", known), Some("cycles"));
    assert_eq!(nearest("torque", known), None);
    assert_eq!(nearest("", known), None);
    assert_eq!(nearest("x", ["y"]), None, "one letter out of one is another word");
    assert_eq!(nearest("ab", ["ac", "bb"]), Some("ac"), "the first of equals");
}

proptest! {
    #[test]
    fn any_span_in_any_text_can_be_printed(text in "\\PC*|(\\n|µ|a|\\t){0,20}", a in 0usize..60, b in 0usize..60) {
        let source = SourceFile::new("f", text);
        let mistake = Diagnostic::new("m").at(&source, a..b);
        let printed = mistake.to_string();
        prop_assert!(printed.contains('^'));
    }
}
