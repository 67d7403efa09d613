//! What a person sees: the program on terminals of several widths, drawn by a terminal emulator.

use std::io::{Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

use nix::pty::{Winsize, openpty};
use rayon::prelude::*;

use crate::bench::{folder, run_in};

/// More lines than a run of `smoke` says.
const ROWS: u16 = 60;

/// A terminal on which nothing appears for so long waits for an answer.
const PAUSE: Duration = Duration::from_secs(2);

/// Pauses after which an answer is typed again: on a machine that is very busy the first one may have come too early.
const PATIENCE: u32 = 5;

/// What a terminal showed of a call.
struct Shown {
    code: Option<i32>,
    /// Everything that was written to it.
    bytes: Vec<u8>,
    /// Its screen after each write, without blanks at the ends of lines.
    screens: Vec<String>,
}

impl Shown {
    fn last(&self) -> &str {
        self.screens.last().map_or("", String::as_str)
    }
}

/// The program with all of its streams on a terminal; each answer is typed when its text stands on the screen.
fn on_terminal(
    folder: &Path,
    columns: u16,
    variables: &[(&str, &str)],
    arguments: &[&str],
    typed: &[(&str, &str)],
) -> Shown {
    let size = Winsize { ws_row: ROWS, ws_col: columns, ws_xpixel: 0, ws_ypixel: 0 };
    let pty = openpty(&size, None).expect("a terminal");
    let slave = || Stdio::from(pty.slave.try_clone().expect("another handle"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_bench"));
    command.args(arguments).current_dir(folder).env("TERM", "xterm-256color").env_remove("NO_COLOR");
    command.envs(variables.iter().copied()).stdin(slave()).stdout(slave()).stderr(slave());
    let mut child = command.spawn().expect("the program under test starts");
    // Only the program holds the other end now: its end is the end of the terminal.
    drop(command);
    drop(pty.slave);
    let mut terminal = std::fs::File::from(pty.master);
    let mut reader = terminal.try_clone().expect("another handle");
    let (sender, chunks) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        let mut chunk = [0; 4096];
        while let Ok(count @ 1..) = reader.read(&mut chunk) {
            if sender.send(chunk[..count].to_vec()).is_err() {
                return;
            }
        }
    });
    let size =
        [ROWS, columns].map(|count| std::num::NonZero::new(count).expect("a terminal has lines and columns"));
    let mut parser = vt100::Parser::new(size[0], size[1], 0);
    let mut shown = Shown { code: None, bytes: Vec::new(), screens: Vec::new() };
    let mut answers = typed.iter();
    let mut next = answers.next();
    let mut last = None;
    let mut silent = 0;
    loop {
        match chunks.recv_timeout(PAUSE) {
            Ok(chunk) => {
                silent = 0;
                shown.bytes.extend_from_slice(&chunk);
                parser.process(&chunk);
                let lines = parser.screen().rows(0, columns).map(|row| row.trim_end().to_owned());
                shown.screens.push(lines.collect::<Vec<_>>().join("\n").trim_end().to_owned());
            }
            // What is typed before the program listens is thrown away: a person reads the question first.
            Err(RecvTimeoutError::Timeout) => {
                silent += 1;
                let due = next.filter(|(asked, _)| shown.last().contains(asked));
                if let Some((_, answer)) = due {
                    last = Some(answer);
                    next = answers.next();
                }
                if let Some(answer) = last.filter(|_| due.is_some() || silent % PATIENCE == 0) {
                    writeln!(terminal, "{answer}").expect("a terminal");
                }
            }
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    shown.code = child.wait().expect("it ends").code();
    assert_eq!(next, None, "never asked: {}", shown.last());
    shown
}

/// Without the times that differ from run to run; blanks as they are.
fn timeless(text: &str) -> String {
    let timed = |line: &&str| !line.contains(" simulated s per CPU s") && !line.contains("s on the rig in");
    text.lines().filter(timed).collect::<Vec<_>>().join("\n")
}

const SMOKE: [&str; 7] = ["run", "smoke", "--yes", "--jobs", "1", "--out", "run"];

/// The line at the bottom that says how far the run is.
fn is_bar(line: &str) -> bool {
    let clock = line.split(' ').next().unwrap_or_default();
    clock.contains(':') && clock.chars().all(|c| c.is_ascii_digit() || c == ':') && line.contains('%')
}

#[test]
fn a_run_fits_terminals_of_60_80_and_200_columns() {
    let pictures: Vec<String> = [60, 80, 200]
        .par_iter()
        .map(|&columns| {
            let folder = folder();
            let shown = on_terminal(folder.path(), columns, &[], &SMOKE, &[]);
            assert_eq!(shown.code, Some(0), "{}", shown.last());
            let mut bars = 0;
            for screen in &shown.screens {
                // A line that is wider than the terminal goes on in the next, and a bar would leave its rest there.
                let found: Vec<usize> =
                    (0..).zip(screen.lines()).filter(|(_, l)| is_bar(l)).map(|(k, _)| k).collect();
                assert!(found.len() <= 1, "{columns} columns: {screen}");
                if let [at] = found[..] {
                    bars += 1;
                    assert_eq!(at + 1, screen.lines().count(), "the bar stands last: {screen}");
                }
            }
            assert!(bars > 3, "{columns} columns: how far the run is was seen {bars} times");
            format!("## {columns} columns\n{}", timeless(shown.last()))
        })
        .collect();
    insta::assert_snapshot!(pictures.join("\n"));
}

#[test]
fn without_colour_on_a_dumb_terminal_and_without_a_terminal_nothing_steers_the_screen() {
    let with = |variables: &[(&str, &str)]| {
        let folder = folder();
        let shown = on_terminal(folder.path(), 80, variables, &SMOKE, &[]);
        assert_eq!(shown.code, Some(0), "{}", shown.last());
        shown
    };
    let text = |shown: &Shown| String::from_utf8_lossy(&shown.bytes).into_owned();
    let colour = |text: &str| text.contains("\u{1b}[32m") || text.contains("\u{1b}[31");
    let (coloured, (plain, dumb)) = rayon::join(
        || with(&[]),
        || rayon::join(|| with(&[("NO_COLOR", "1")]), || with(&[("TERM", "dumb")])),
    );
    assert!(colour(&text(&coloured)), "a verdict has a colour: {}", coloured.last());
    assert!(
        !colour(&text(&plain)) && plain.screens.iter().any(|s| s.lines().any(is_bar)),
        "{}",
        plain.last()
    );
    assert!(!text(&dumb).contains('\u{1b}'), "{}", dumb.last());
    let folder = folder();
    let piped = run_in(folder.path(), &SMOKE);
    assert!(!piped.out.contains('\u{1b}') && !piped.err.contains('\u{1b}'), "{}{}", piped.out, piped.err);
    insta::assert_snapshot!(format!(
        "## NO_COLOR\n{}\n## dumb\n{}\n## not a terminal: stderr\n{}## stdout\n{}",
        timeless(plain.last()),
        timeless(dumb.last()),
        piped.err,
        timeless(&piped.out)
    ));
}

#[test]
fn a_question_stands_alone_says_what_it_takes_and_why_an_answer_is_refused() {
    let folder = folder();
    let asked = "nobody within its reach";
    let run = ["run", "smoke", "--jobs", "1", "--out", "run"];
    let typed = [(asked, "perhaps"), ("`perhaps`", "y")];
    let shown = on_terminal(folder.path(), 60, &[], &run, &typed);
    assert_eq!(shown.code, Some(0), "{}", shown.last());
    let asked_again = |screen: &&String| screen.matches("[yes or no]").count() == 2;
    let question = shown.screens.iter().find(asked_again).expect("the answer was refused");
    assert!(!question.lines().any(is_bar), "no bar beside what is typed: {question}");
    insta::assert_snapshot!(question);
}
