use super::*;
use crate::sample;

#[test]
fn what_is_written_reads_back_and_writes_the_same_bytes() {
    let results = sample::results();
    let text = render(&results);
    let back = parse(&text).expect("own output");
    assert_eq!(back, results);
    assert_eq!(render(&back), text);
}

#[test]
fn findings_alone_are_the_part_that_the_record_does_not_touch() {
    let mut results = sample::results();
    let before = findings(&results.findings);
    results.record.wall_s = 99.0;
    results.record.operator = None;
    assert_eq!(findings(&results.findings), before);
    results.findings.procedures[0].measurements[0].value = Some(419.310_000_000_1);
    assert_ne!(findings(&results.findings), before, "one changed number changes the bytes");
}

#[test]
fn series_of_numbers_stand_on_one_line_and_the_rest_is_indented_by_two() {
    #[derive(serde::Serialize)]
    struct Shape {
        empty: Vec<f64>,
        numbers: Vec<Option<f64>>,
        counts: Vec<i64>,
        texts: Vec<&'static str>,
        nested: Vec<Vec<u8>>,
        pair: (&'static str, f64),
        none: Option<u8>,
    }
    let text = to_text(&Shape {
        empty: vec![],
        numbers: vec![Some(1.0), None, Some(-2.5e-9)],
        counts: vec![-1, 2],
        texts: vec!["a", "b"],
        nested: vec![vec![1, 2], vec![]],
        pair: ("x", 1.5),
        none: None,
    });
    insta::assert_snapshot!(text, @r#"
    {
      "empty": [],
      "numbers": [1.0,null,-2.5e-9],
      "counts": [-1,2],
      "texts": [
        "a",
        "b"
      ],
      "nested": [
        [1,2],
        []
      ],
      "pair": [
        "x",
        1.5
      ],
      "none": null
    }
    "#);
    let plain: serde_json::Value = serde_json::from_str(&text).expect("it is JSON");
    assert_eq!(plain["pair"][1], 1.5);
}

#[test]
fn another_schema_is_refused_by_name() {
    let text = render(&sample::results()).replace(SCHEMA, "fat-result/9");
    let error = parse(&text).expect_err("it is another schema");
    assert_eq!(error.to_string(), "result of schema `fat-result/9`, expected `fat-result/1`");
    assert!(parse("{}").is_err() && parse("no JSON").is_err());
}
