use super::*;

fn three_lines(folder: &Path) {
    let mut journal = Journal::create(folder).expect("fresh folder");
    let opened =
        Entry::Opened { campaign: "quick".into(), rig: "sim".into(), unit: "nominal".into(), seed: 1 };
    journal.write(opened).expect("writable");
    let ended =
        Entry::ProcedureEnded { procedure: "P".into(), status: "completed".into(), log: None, reason: None };
    journal.write(ended).expect("writable");
    journal.close(0).expect("writable");
}

#[test]
fn a_closed_journal_reads_back_whole() {
    let folder = tempfile::tempdir().expect("temporary folder");
    three_lines(folder.path());
    let (lines, closed) = read(folder.path()).expect("intact");
    assert_eq!(lines.len(), 3);
    assert!(closed);
    assert_eq!(lines[2].entry, Entry::Closed { exit_code: 0, entries: 3 });
}

#[test]
fn an_altered_line_breaks_the_chain_where_it_stands() {
    let folder = tempfile::tempdir().expect("temporary folder");
    three_lines(folder.path());
    let path = folder.path().join(FILE);
    let text = std::fs::read_to_string(&path).expect("readable");
    std::fs::write(&path, text.replace("\"seed\":1", "\"seed\":2")).expect("writable");
    let message = read(folder.path()).expect_err("altered");
    assert!(message.contains("journal.jsonl:2"), "{message}");
}

#[test]
fn a_line_cut_off_by_a_crash_leaves_the_run_open() {
    let folder = tempfile::tempdir().expect("temporary folder");
    three_lines(folder.path());
    let path = folder.path().join(FILE);
    let text = std::fs::read_to_string(&path).expect("readable");
    std::fs::write(&path, &text[..text.len() - 5]).expect("writable");
    let (lines, closed) = read(folder.path()).expect("what is whole");
    assert_eq!(lines.len(), 2);
    assert!(!closed);
}
