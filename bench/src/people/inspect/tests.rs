use super::*;

fn angles(az: f64, el: f64) -> Vec<AxisAngle> {
    vec![AxisAngle { axis: "az".into(), deg: az }, AxisAngle { axis: "el".into(), deg: el }]
}

#[test]
fn positions_agree_within_a_tenth_of_a_degree_on_every_axis() {
    for (before, now, expected) in [
        (angles(10.0, 20.0), angles(10.09, 19.91), true),
        (angles(10.0, 20.0), angles(10.11, 20.0), false),
        (angles(10.0, 20.0), angles(10.0, 19.89), false),
        (Vec::new(), angles(0.0, 0.0), false),
    ] {
        assert_eq!(agrees(&before, &now), expected, "{before:?} {now:?}");
    }
}

/// A journal that broke off inside its second point, half a line last.
fn lost(folder: &Path) {
    let mut journal = Journal::create(folder).expect("fresh");
    let started = |point: &str| Entry::PointStarted { procedure: "P".into(), point: point.into() };
    journal.write(started("one")).expect("writable");
    let ended = Entry::PointEnded {
        procedure: "P".into(),
        point: "one".into(),
        status: "completed".into(),
        reason: None,
        safe: String::new(),
        angles_deg: angles(10.0, 20.0),
    };
    journal.write(ended).expect("writable");
    journal.write(started("two")).expect("writable");
    journal.write(started("never")).expect("writable");
    let path = folder.join(crate::record::journal::FILE);
    let text = std::fs::read_to_string(&path).expect("readable");
    std::fs::write(&path, &text[..text.len() - 7]).expect("writable");
}

#[test]
fn the_chain_goes_on_after_a_line_that_was_cut_off_and_says_what_moved() {
    let folder = tempfile::tempdir().expect("temporary folder");
    lost(folder.path());
    let (journal, known) = journal_of(folder.path()).expect("never closed");
    assert_eq!(known.in_motion, Some(("P".into(), "two".into())));
    assert_eq!(known.angles_deg, angles(10.0, 20.0));
    let standing = Standing { bus: String::new(), devices: Vec::new(), angles_deg: angles(11.0, 20.0) };
    let finding = |accepts_positions| Finding { by: "Ada".into(), found: "pushed".into(), accepts_positions };
    assert!(!record(journal, &known, &standing, finding(false)).expect("writable"));
    let (journal, known) = journal_of(folder.path()).expect("still not closed");
    assert!(record(journal, &known, &standing, finding(true)).expect("writable"));
    let (lines, closed) = crate::record::journal::read(folder.path()).expect("an intact chain");
    assert!(!closed, "a lost run stays lost");
    assert!(matches!(lines[3].entry, Entry::Inspected { agrees: false, released: false, .. }));
    assert!(matches!(lines[4].entry, Entry::Inspected { agrees: false, released: true, .. }));
}

#[test]
fn a_run_that_ended_by_itself_is_not_inspected() {
    let folder = tempfile::tempdir().expect("temporary folder");
    Journal::create(folder.path()).and_then(|journal| journal.close(3)).expect("writable");
    let told = journal_of(folder.path()).expect_err("closed");
    assert!(told.contains("ended normally") && told.contains("exit code 3"), "{told}");
}
