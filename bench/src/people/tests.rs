use std::sync::atomic::AtomicU16;
use std::sync::mpsc::channel;

use super::*;
use crate::files::rig::read_rig;
use crate::files::shipped::{self, Folder};
use crate::files::unit::load_unit;
use crate::people::event::Shown;
use crate::plan::{Wanted, plan};
use crate::record::journal::Entry;

fn prompt(id: &str, class: PromptClass) -> Prompt {
    Prompt { id: id.into(), class, text: format!("{id}?"), simulated: false }
}

/// A plan with these prompts.
fn asking(prompts: Vec<Prompt>) -> CampaignPlan {
    let rig = shipped::find(Folder::Rigs, "sim", None).and_then(read_rig).expect("the shipped rig");
    let wanted = Wanted { names: vec!["quick/az-friction".into()], ..Wanted::default() };
    let mut plan = plan(&wanted, &rig).expect("shipped");
    plan.procedures[0].procedure.prompts = prompts;
    plan
}

fn at_a_terminal() -> Answers {
    Answers { terminal: true, ..Answers::default() }
}

/// Real devices, unit, jobs, prompts, answers; how the refusal begins, if there is one.
type Rule<'a> = (&'a [&'a str], &'a str, Option<usize>, Vec<Prompt>, Answers, Option<&'a str>);

#[test]
fn each_rule_refuses_what_it_is_about_and_nothing_else() {
    let safety = || vec![prompt("area-clear", PromptClass::Safety)];
    let info = || vec![prompt("fixture", PromptClass::Info)];
    let file = |id: &str| BTreeMap::from([(id.to_owned(), "yes".to_owned())]);
    let ask = at_a_terminal;
    const REAL: &[&str] = &["az-drive"];
    // Real devices, unit, jobs, prompts, answers; the refusal must begin with this, or there is none.
    let table: Vec<Rule<'_>> = vec![
        (REAL, "nominal", None, vec![], Answers::default(), None),
        (REAL, "encoder-sign", None, vec![], ask(), Some("unit `encoder-sign` is a planted defect")),
        (&[], "encoder-sign", None, vec![], ask(), None),
        (REAL, "nominal", Some(2), vec![], ask(), Some("--jobs 2: az-drive is real")),
        (REAL, "nominal", Some(1), vec![], ask(), None),
        (&[], "nominal", Some(2), vec![], ask(), None),
        (REAL, "nominal", None, safety(), ask(), None),
        (
            REAL,
            "nominal",
            None,
            safety(),
            Answers { yes: true, ..ask() },
            Some("--yes: safety prompt `area-clear`"),
        ),
        (&[], "nominal", None, safety(), Answers { yes: true, ..ask() }, None),
        (REAL, "nominal", None, info(), Answers { yes: true, ..ask() }, None),
        (
            REAL,
            "nominal",
            None,
            safety(),
            Answers { non_interactive: true, ..ask() },
            Some("--non-interactive: safety prompt `area-clear`"),
        ),
        (
            REAL,
            "nominal",
            None,
            safety(),
            Answers { file: file("area-clear"), ..ask() },
            Some("--answers: safety prompt `area-clear`"),
        ),
        (REAL, "nominal", None, info(), Answers { file: file("fixture"), ..ask() }, None),
        (
            REAL,
            "nominal",
            None,
            safety(),
            Answers { terminal: false, ..ask() },
            Some("safety prompt `area-clear` must be answered at a terminal"),
        ),
        (
            &[],
            "nominal",
            None,
            info(),
            Answers { non_interactive: true, ..ask() },
            Some("prompt `fixture` has no answer"),
        ),
        (&[], "nominal", None, info(), Answers::default(), Some("prompt `fixture` has no answer")),
        (
            &[],
            "nominal",
            None,
            info(),
            Answers { non_interactive: true, file: file("fixture"), ..ask() },
            None,
        ),
    ];
    for (row, (real, unit, jobs, prompts, answers, expected)) in table.into_iter().enumerate() {
        let unit = load_unit(unit).expect("shipped");
        let plan = asking(prompts);
        let found = refusals(&situation(real, &unit, &plan, jobs, &answers));
        match expected {
            None => assert_eq!(found, Vec::<String>::new(), "row {row}"),
            Some(start) => {
                assert!(found.first().is_some_and(|f| f.starts_with(start)), "row {row}: {found:?}")
            }
        }
    }
}

fn situation<'a>(
    real: &'a [&'a str],
    unit: &'a Unit,
    plan: &'a CampaignPlan,
    jobs: Option<usize>,
    answers: &'a Answers,
) -> Situation<'a> {
    Situation { real, unit, plan, jobs, answers, wire_faults: &[] }
}

#[test]
fn faults_of_the_wire_are_refused_where_a_device_is_real() {
    let (unit, plan) = (load_unit("nominal").expect("shipped"), asking(Vec::new()));
    let answers = at_a_terminal();
    let faults = ["back:drop@0.001".to_owned()];
    let with =
        |real| refusals(&Situation { wire_faults: &faults, ..situation(real, &unit, &plan, None, &answers) });
    assert_eq!(with(&[]), Vec::<String>::new());
    let found = with(&["az-drive"]);
    assert!(found[0].starts_with("--wire-fault back:drop@0.001: az-drive is real"), "{found:?}");
}

fn owned<'a>(owner: &'a str, prompts: &'a [Prompt]) -> Vec<Asked<'a>> {
    prompts.iter().map(|prompt| Asked { owner, prompt, brought: prompt.simulated, wait_s: 0.0 }).collect()
}

/// Asks these prompts of one procedure after the other; gives what came out, the questions and the journal's answers.
fn asked(
    desk: Desk,
    rounds: &[(&str, &[Prompt])],
    typed: &[&str],
) -> (Vec<Result<(), Denied>>, usize, Vec<String>) {
    let (sender, lines) = channel();
    let mut typed = typed.iter();
    let mut questions = 0;
    let mut kept = Vec::new();
    let mut desk = desk.with_lines(lines, 0.3);
    sender.send("yes".to_owned()).expect("open"); // typed before any question: no answer to one
    let stop = AtomicU16::new(0);
    let mut ended = Vec::new();
    for (procedure, prompts) in rounds {
        let say = &mut |_: &str, _: &str| {
            questions += 1;
            if let Some(line) = typed.next() {
                sender.send((*line).to_owned()).expect("open");
            }
            let shown = Shown::default();
            shown.set();
            shown
        };
        let keep = &mut |entry: Entry| {
            if let Entry::Answered { prompt, answer, how, by, .. } = entry {
                kept.push(format!("{prompt}={answer} ({how}, {by})"));
            }
        };
        ended.push(desk.clear(&owned(procedure, prompts), &stop, say, keep));
    }
    (ended, questions, kept)
}

#[test]
fn on_a_real_rig_only_the_typed_phrase_confirms_and_the_record_says_who_and_how() {
    let prompts = [prompt("area-clear", PromptClass::Safety)];
    let desk = || Desk::new(at_a_terminal(), true, Some("Ada"));
    let (ended, questions, kept) = asked(desk(), &[("P", &prompts)], &["yes", "area-clear"]);
    assert_eq!((ended, questions), (vec![Ok(())], 2), "`yes` is not the phrase: asked again");
    assert_eq!(kept, ["area-clear=area-clear (terminal, Ada)"]);
    let (ended, _, kept) = asked(desk(), &[("P", &prompts)], &["no"]);
    assert_eq!(ended, [Err(Denied::Refused("prompt `area-clear` was answered with `no`".into()))]);
    assert_eq!(kept, ["area-clear=no (terminal, Ada)"], "a refusal is on record too");
    let (ended, questions, _) = asked(desk(), &[("P", &prompts)], &["yes", "ok", "sure", "area-clear"]);
    assert!(ended[0].is_err());
    assert_eq!(questions, 3);
}

#[test]
fn a_question_that_nobody_answers_ends_with_no() {
    let prompts = [prompt("area-clear", PromptClass::Safety)];
    let (ended, _, kept) = asked(Desk::new(at_a_terminal(), true, None), &[("P", &prompts)], &[]);
    let Err(Denied::Refused(reason)) = &ended[0] else { panic!("{ended:?}") };
    assert!(reason.contains("was not answered within"), "{reason}");
    assert!(kept.is_empty());
}

#[test]
fn a_safety_answer_holds_until_another_safety_prompt_and_an_info_answer_for_its_procedure() {
    let clear = [prompt("area-clear", PromptClass::Safety)];
    let enter = [prompt("fixture-mounted", PromptClass::Safety)];
    let info = [prompt("remark", PromptClass::Info)];
    let rounds: [(&str, &[Prompt]); 7] = [
        ("A", &clear), // asked
        ("A", &clear), // next point: holds
        ("B", &clear), // next procedure: holds
        ("C", &enter), // asked: somebody may have been inside
        ("D", &clear), // asked again
        ("D", &info),  // asked
        ("D", &info),  // known
    ];
    let (ended, questions, kept) = asked(Desk::new(at_a_terminal(), false, None), &rounds, &["yes"; 7]);
    assert!(ended.iter().all(Result::is_ok), "{ended:?}");
    assert_eq!((questions, kept.len()), (4, 4));
}

#[test]
fn a_signal_ends_the_waiting() {
    let (_sender, lines) = channel();
    let mut desk = Desk::new(at_a_terminal(), false, None).with_lines(lines, 600.0);
    let stop = AtomicU16::new(u16::from(crate::exit::SIGINT));
    let prompts = [prompt("remark", PromptClass::Info)];
    let ended = desk.clear(&owned("P", &prompts), &stop, &mut |_, _| Shown::default(), &mut |_| {});
    assert_eq!(ended, Err(Denied::Stopped(crate::exit::SIGINT)));
}

#[test]
fn questions_that_are_asked_together_hold_together() {
    let both = [prompt("unit-complete", PromptClass::Safety), prompt("area-clear", PromptClass::Safety)];
    let rounds: [(&str, &[Prompt]); 3] = [("A", &both), ("A", &both), ("B", &both[1..])];
    let (ended, questions, _) = asked(Desk::new(at_a_terminal(), false, None), &rounds, &["yes"; 4]);
    assert!(ended.iter().all(Result::is_ok), "{ended:?}");
    assert_eq!(questions, 2, "neither makes the other one void");
}

#[test]
fn an_answer_that_would_grow_too_old_while_the_axis_cools_down_is_asked_for_again() {
    let prompts = [prompt("area-clear", PromptClass::Safety)];
    let questions = |wait_s: f64| {
        let asked = [Asked { owner: "A", prompt: &prompts[0], brought: false, wait_s }];
        let stop = AtomicU16::new(0);
        let mut kept = 0;
        let mut desk = Desk::new(Answers { yes: true, ..Answers::default() }, false, None);
        for _ in 0..2 {
            desk.clear(&asked, &stop, &mut |_, _| Shown::default(), &mut |_| kept += 1)
                .expect("`--yes` answers");
        }
        kept
    };
    assert_eq!((questions(25.0 * 60.0), questions(30.0 * 60.0)), (1, 2));
}

#[test]
fn a_build_state_is_brought_by_the_bench_where_all_is_simulated_and_by_people_where_anything_is_real() {
    let prompts = [prompt("table-bare", PromptClass::Safety)];
    let asked = [Asked { owner: "table", prompt: &prompts[0], brought: true, wait_s: 0.0 }];
    let alone =
        |file: BTreeMap<String, String>| Answers { non_interactive: true, file, ..Answers::default() };
    let stop = AtomicU16::new(0);
    let cleared = |answers: Answers, real: bool| {
        let mut kept = Vec::new();
        let mut desk = Desk::new(answers, real, Some("Ada"));
        let mut keep = |entry: Entry| kept.push(entry);
        let ended = [(); 2].map(|()| desk.clear(&asked, &stop, &mut |_, _| Shown::default(), &mut keep));
        (ended[1].clone(), kept)
    };
    let (ended, kept) = cleared(alone(BTreeMap::new()), false);
    assert_eq!((ended, kept.len()), (Ok(()), 1), "once for the whole run");
    let Entry::Answered { how, by, answer, .. } = &kept[0] else { panic!("{kept:?}") };
    assert_eq!((how.as_str(), by.as_str(), answer.as_str()), ("simulated: state applied", "bench", "yes"));
    assert!(cleared(alone(BTreeMap::new()), true).0.is_err(), "nobody is there to bring it");
    let no = BTreeMap::from([("table-bare".to_owned(), "no".to_owned())]);
    assert!(cleared(alone(no), false).0.is_err(), "who answers with no is heard");
}

#[test]
fn a_target_that_the_simulation_has_is_asked_for_where_anything_is_real() {
    let light = Prompt { simulated: true, ..prompt("fixed-light", PromptClass::Info) };
    let asked = [Asked { owner: "TRACK", prompt: &light, brought: light.simulated, wait_s: 0.0 }];
    let stop = AtomicU16::new(0);
    let cleared = |real: bool| {
        let nobody = Answers { non_interactive: true, ..Answers::default() };
        let mut kept = Vec::new();
        let ended =
            Desk::new(nobody, real, None)
                .clear(&asked, &stop, &mut |_, _| Shown::default(), &mut |e| kept.push(e));
        (ended.is_ok(), kept)
    };
    let (ok, kept) = cleared(false);
    let Some(Entry::Answered { how, by, .. }) = kept.first().filter(|_| ok) else { panic!("{kept:?}") };
    assert_eq!((how.as_str(), by.as_str()), ("simulated: part of the simulation", "bench"));
    assert!(!cleared(true).0, "a real light is lit by people");
}

#[test]
fn every_shipped_procedure_that_looks_at_a_light_asks_for_it() {
    let looking = ["track", "tracker-latency", "optical-gain", "atmosphere"];
    let mut count = 0;
    for file in shipped::all(Folder::Procedures) {
        let kind = |k: &&str| file.source().text.contains(&format!("\nkind = \"{k}\"\n"));
        if !looking.iter().any(kind) {
            continue;
        }
        count += 1;
        let procedure = procedures::procedure::Procedure::parse(file.source()).expect("shipped files parse");
        let light = procedure.prompts.iter().find(|p| p.simulated);
        let moves = procedure.id.contains("RAIL") || procedure.id.contains("DRONE");
        let class = if moves { PromptClass::Safety } else { PromptClass::Info };
        assert_eq!(light.map(|p| p.class), Some(class), "{}", file.path);
    }
    assert_eq!(
        count, 17,
        "eight of the acceptance test, six quick ones, two on the wire, one of the regression"
    );
}
