use proptest::prelude::*;

use super::*;
use crate::quantity::Limit;
use std::ops::Range;

const SWEEP: &[Field] = &[
    Field::required("velocity", Shape::Quantities(QuantityKind::AngularVelocity), "Plateau velocities."),
    Field::default("span", Shape::Range(QuantityKind::Angle), "-60 deg .. 60 deg", "Where the strokes turn."),
    Field::default("cycles", Shape::Integer, "2", "Strokes out and back."),
];

const STEP: &[Field] = &[Field::required("file", Shape::Text, "File.")];

const FIELDS: &[Field] = &[
    SCHEMA_FIELD,
    Field::required("id", Shape::Text, "Name."),
    Field::default("rule", Shape::Choice(&["simple", "guarded-u"]), "guarded-u", "Decision rule."),
    Field::optional("tags", Shape::Texts, "Words."),
    Field::optional("quick", Shape::Boolean, "Whether."),
    Field::optional("settle", Shape::Quantity(QuantityKind::Time), "How long."),
    Field::optional("limit", Shape::Limit(QuantityKind::Torque), "Limit."),
    Field::default("sweep", Shape::Table(SWEEP), "", "What is swept."),
    Field::optional("procedure", Shape::Tables(STEP), "Steps."),
    Field::optional("gate", Shape::Map(&Shape::Text), "Gates."),
    Field::optional("points", Shape::Map(&Shape::Texts), "Points."),
];

type Entry = (String, String, Range<usize>);

/// Everything that the fields above can hold.
#[derive(Debug, Default, PartialEq)]
struct Everything {
    id: String,
    rule: Option<String>,
    tags: Option<Vec<String>>,
    quick: Option<bool>,
    settle_s: Option<f64>,
    limit: Option<Limit>,
    sweep: Option<(Vec<f64>, [f64; 2], i64)>,
    files: Option<Vec<String>>,
    gates: Option<Vec<Entry>>,
    points: Option<Vec<MapEntry>>,
}

fn read_sweep(table: &mut TableReader<'_>) -> Option<(Vec<f64>, [f64; 2], i64)> {
    let velocity = table.quantities("velocity");
    let span = table.range("span");
    let cycles = table.integer("cycles", 1);
    Some((velocity?, span?, cycles?))
}

fn read_all(table: &mut TableReader<'_>) -> Option<Everything> {
    let schema = table.schema();
    let id = table.text("id");
    let all = Everything {
        id: String::new(),
        rule: table.text("rule"),
        tags: table.texts("tags"),
        quick: table.boolean("quick"),
        settle_s: table.positive("settle"),
        limit: table.limit("limit"),
        sweep: table.table("sweep", read_sweep),
        files: table.tables("procedure", |step| step.text("file")),
        gates: table.map("gate"),
        points: table.lists("points"),
    };
    schema?;
    Some(Everything { id: id?, ..all })
}

fn read(text: &str) -> Result<Everything, Vec<Diagnostic>> {
    read_file(&SourceFile::new("bench.toml", text), FIELDS, read_all)
}

fn messages(text: &str) -> String {
    let mistakes = read(text).expect_err("the file is wrong");
    mistakes.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

#[test]
fn a_right_file_gives_si_values_defaults_and_entries_in_written_order() {
    let all = read(concat!(
        "schema = 1\nid = 'A'\ntags = ['x', 'y']\nquick = true\nsettle = '5 ms'\nlimit = '<= 45 N*m'\n",
        "gate = { heat-sink = '< 60 degC', bus-voltage = '> 500 V' }\n",
        "points = { velocity = ['2 deg/s'], dwell = '1 s' }\n",
        "[sweep]\nvelocity = ['180 deg/s']\n[[procedure]]\nfile = 'a.toml'\n[[procedure]]\nfile = 'b.toml'\n"
    ))
    .expect("a right file");
    assert_eq!((all.id.as_str(), all.rule.as_deref()), ("A", Some("guarded-u")));
    assert_eq!((all.quick, all.settle_s), (Some(true), Some(0.005)));
    assert_eq!(all.limit.and_then(|limit| limit.high), Some(45.0));
    let (velocity, span, cycles) = all.sweep.expect("a sweep");
    assert_eq!((velocity, cycles), (vec![std::f64::consts::PI], 2));
    assert!((span[0] + std::f64::consts::FRAC_PI_3).abs() < 1e-15);
    assert_eq!(all.files, Some(vec!["a.toml".to_owned(), "b.toml".to_owned()]));
    let gates: Vec<_> = all.gates.into_iter().flatten().map(|(key, text, _)| (key, text)).collect();
    assert_eq!(gates[0], ("heat-sink".to_owned(), "< 60 degC".to_owned()), "written before bus-voltage");
    let points = all.points.expect("points");
    assert_eq!((points[0].key.as_str(), points[0].texts[0].0.as_str()), ("velocity", "2 deg/s"));
    assert_eq!((points[1].key.as_str(), points[1].texts[0].0.as_str()), ("dwell", "1 s"));
}

#[test]
fn misspelt_key_names_the_nearest_word() {
    insta::assert_snapshot!(messages(
        "schema = 1\nid = 'A'\n\n[sweep]\nvelocity = ['1 deg/s']\nvelocty = ['2 deg/s']\n"
    ));
}

#[test]
fn several_mistakes_come_at_once_in_order_of_their_place() {
    insta::assert_snapshot!(messages(concat!(
        "schema = 2\nrule = 'guarded-v'\ntags = 'x'\nquick = 1\nsettle = '-1 s'\nlimit = '45 N*m'\n",
        "gate = { heat-sink = 60 }\n",
        "[sweep]\nvelocity = ['10 Hz', '3 deg/s', '3 deg/x']\nspan = '60 deg .. -60 deg'\ncycles = 0\n",
        "[[procedure]]\nfile = 'a.toml'\n[[procedure]]\nflie = 'b.toml'\n"
    )));
}

#[test]
fn empty_sweep_and_bare_numbers_say_what_to_write() {
    insta::assert_snapshot!(messages("schema = 1\nid = 'A'\nsettle = 10\n[sweep]\nvelocity = []\n"));
    insta::assert_snapshot!(messages("schema = 1\nid = 'A'\n[sweep]\nvelocity = [10, 2.5]\n"));
}

#[test]
fn grammar_mistakes_come_with_the_wrong_keys_but_without_keys_that_they_may_have_swallowed() {
    insta::assert_snapshot!(messages(
        "schema = 1\nid = 'A\nrul = 'simple'\n[sweep]\nvelocity = ['1 deg/s' '2 deg/s']\n"
    ));
}

#[test]
fn a_table_with_a_default_that_is_absent_still_misses_its_required_keys() {
    insta::assert_snapshot!(messages("schema = 1\nid = 'A'\n"), @r#"
    error: missing key `velocity`
     --> bench.toml:1:1
      |
    1 | schema = 1
      | ^
      = help: `velocity` must be a list such as `["10 deg/s"]`: Plateau velocities.
    "#);
}

#[test]
fn a_table_where_a_value_belongs_and_the_other_way_round() {
    insta::assert_snapshot!(messages(
        "schema = 1\nsweep = 3\ngate = 'x'\nprocedure = { file = 'a' }\n[id]\nx = 1\n"
    ));
}

#[test]
fn keys_of_an_unknown_kind_can_be_let_through() {
    let source = SourceFile::new("f", "schema = 1\nid = 'A'\nfoo = 1\n");
    let open = read_file(&source, FIELDS, |table| {
        table.accept_any_key();
        table.schema()
    });
    assert_eq!(open, Ok(()));
}

#[test]
fn a_kind_extends_the_known_keys_of_the_same_table() {
    const EXTRA: &[Field] =
        &[Field::required("dwell", Shape::Quantities(QuantityKind::Time), "Dwell times.")];
    let source = SourceFile::new("f", "schema = 1\ndwell = ['1 s', '100 ms']\n");
    let dwell = read_file(&source, &[SCHEMA_FIELD], |table| {
        table.schema()?;
        table.extend(EXTRA);
        table.quantities("dwell")
    });
    assert_eq!(dwell, Ok(vec![1.0, 0.1]));
}

#[test]
#[should_panic(expected = "is not among the fields")]
fn asking_for_a_key_that_is_no_field_is_a_programming_error() {
    let _ = read_file(&SourceFile::new("f", ""), &[SCHEMA_FIELD], |table| table.text("idd"));
}

/// The mistakes of a text.
fn mistakes(text: &str) -> Vec<Diagnostic> {
    read(text).expect_err("it has mistakes")
}

#[test]
fn a_file_larger_than_anybody_writes_is_not_parsed() {
    let found = mistakes(&format!("schema = 1\nid = '{}'\n", "x".repeat(MOST_BYTES)));
    assert_eq!(found.len(), 1);
    assert!(found[0].message.contains("expected at most 1048576"), "{}", found[0].message);
}

#[test]
fn mistakes_beyond_the_first_hundred_are_counted() {
    let keys: String = (0..5000).map(|k| format!("key{k} = 1\n")).collect();
    let steps: String = (0..900).map(|k| format!("[[procedure]]\nfil = '{k}'\n")).collect();
    let found = mistakes(&format!("schema = 1\nid = 'A'\n{keys}[sweep]\nvelocity = ['1 deg/s']\n{steps}"));
    assert_eq!(found.len(), MOST_MISTAKES + 1);
    // Each step lacks a key and has one too many.
    let last = &found[MOST_MISTAKES].message;
    assert_eq!(last, &format!("and {} more mistakes in this file", 5000 + 2 * 900 - MOST_MISTAKES));
}

#[test]
fn a_list_with_more_entries_than_any_test_has_is_refused_as_one_mistake() {
    let long = |item: &str| item.repeat(MOST_ENTRIES + 1);
    for text in [
        format!("tags = [{}]\n", long("'a', ")),
        format!("[sweep]\nvelocity = [{}]\n", long("'1 deg/s', ")),
        format!("[sweep]\nvelocity = ['1 deg/s']\n{}", long("[[procedure]]\nfile = 'a'\n")),
    ] {
        let text = format!("schema = 1\nid = 'A'\n{text}");
        let found: Vec<String> = mistakes(&text).into_iter().map(|m| m.message).collect();
        assert!(found.iter().any(|m| m.contains("has 1001 entries; expected at most 1000")), "{found:?}");
        assert!(found.len() < 3, "{found:?}");
    }
}

#[test]
fn nesting_beyond_all_measure_is_a_mistake_of_grammar() {
    for depth in [100, 100_000] {
        let found = mistakes(&format!("schema = 1\nid = {}1{}\n", "[".repeat(depth), "]".repeat(depth)));
        assert!(found.iter().any(|m| m.message.starts_with("not TOML")), "{found:?}");
    }
}

proptest! {
    #[test]
    fn no_file_makes_the_reader_panic(text in "\\PC*|((schema|id|rule|sweep|gate|velocity|\\[|\\]|=|'|\"|1|\\{|\\}|,|\\n| |\\.){0,40})") {
        if let Err(mistakes) = read(&text) {
            prop_assert!(!mistakes.is_empty());
            for pair in mistakes.windows(2) {
                prop_assert!(pair[0].span.as_ref().map(|s| s.start) <= pair[1].span.as_ref().map(|s| s.start));
            }
        }
    }
}
