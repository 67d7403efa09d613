use crate::campaign::{Campaign, check};
use crate::diagnostic::{Diagnostic, SourceFile};
use crate::procedure::Procedure;
use crate::procedure::sample::SAMPLE_KINDS;
use crate::requirement::Requirements;

const HEAD: &str = "schema = 1\nid = 'c'\ntitle = 'C'\nrequirements = 'r.toml'\nmust-measure = ['FRC-AZ']\n";
const STAGES: &str = r#"
[[stage]]
id = "table"
title = "Azimuth as a torque table"
state = "azimuth-table"
inertia = { az = "640 kg*m^2" }
[[stage.prompt]]
id = "table-bare"
class = "safety"
text = "Is the table bare?"

[[stage]]
id = "friction"
title = "Friction"
state = "final"
[[stage.prompt]]
id = "complete"
class = "safety"
text = "Is the unit complete?"

[[stage]]
id = "loops"
title = "Loops"
needs = ["friction"]
needs-pass = ["FRC-AZ"]

[[procedure]]
file = "loops.toml"
stage = "loops"
[[procedure]]
file = "table.toml"
stage = "table"
[[procedure]]
file = "friction.toml"
stage = "friction"
"#;

fn read(text: &str) -> Result<Campaign, Vec<Diagnostic>> {
    Campaign::parse(SourceFile::new("c.toml", text))
}

fn right() -> Campaign {
    read(&format!("{HEAD}{STAGES}")).expect("the file is right")
}

/// Messages of the mistakes in a campaign whose stages differ by this replacement.
fn mistakes(from: &str, to: &str) -> Vec<String> {
    assert!(STAGES.contains(from), "{from}");
    let found = read(&format!("{HEAD}{}", STAGES.replace(from, to))).expect_err("a mistake");
    found.into_iter().map(|d| d.message).collect()
}

fn friction(id: &str) -> Procedure {
    let text = format!(
        "schema = 1\nid = '{id}'\ntitle = 't'\nkind = 'sample'\naxis = 'az'\nsweep.velocity = ['1 deg/s']\n"
    );
    Procedure::parse_with(SourceFile::new(format!("{id}.toml"), text), SAMPLE_KINDS).expect("a right file")
}

fn requirements() -> Requirements {
    let text = "schema = 1\n[[requirement]]\nid = 'FRC-AZ'\ntext = 't'\nsource = 's'\nmethod = 'test'\n\
                measurand = ['friction-torque']\naxis = 'az'\nlimit = '<= 260 N*m'\n";
    Requirements::parse(&SourceFile::new("r.toml", text)).expect("right")
}

#[test]
fn procedures_come_stage_by_stage_wherever_they_stand_in_the_file() {
    let campaign = right();
    let files: Vec<&str> = campaign.procedures.iter().map(|e| e.file.as_str()).collect();
    assert_eq!(files, ["table.toml", "friction.toml", "loops.toml"]);
    assert_eq!(campaign.stages[0].inertia_kg_m2, [("az".to_owned(), 640.0)]);
    assert_eq!(campaign.stages[0].prompts[0].id, "table-bare");
    assert_eq!(
        campaign.procedures.iter().map(|e| campaign.is_judged(e)).collect::<Vec<_>>(),
        [false, true, true]
    );
    let loops = &campaign.stages[2];
    let needed: Vec<bool> = campaign.procedures.iter().map(|e| campaign.is_needed(loops, e)).collect();
    assert_eq!(needed, [false, true, false]);
}

#[test]
fn stages_that_do_not_fit_together_are_mistakes() {
    for (from, to, expected) in [
        ("id = \"loops\"", "id = \"table\"", "two stages have the id `table`"),
        (
            "needs = [\"friction\"]",
            "needs = [\"loops\"]",
            "stage `loops` needs `loops`, which is not an earlier stage",
        ),
        ("needs = [\"friction\"]\n", "", "`needs-pass` without `needs`"),
        ("stage = \"loops\"", "stage = \"lops\"", "unknown stage `lops`"),
        ("stage = \"loops\"", "stage = \"friction\"", "no procedure belongs to stage `loops`"),
        ("stage = \"loops\"\n", "", "the campaign has stages, but this procedure belongs to none"),
        (
            "class = \"safety\"\ntext = \"Is the table",
            "class = \"info\"\ntext = \"Is the table",
            "a stage with a build state does not ask the operator for it",
        ),
        ("state = \"azimuth-table\"\n", "", "`inertia` is given for the final build state"),
        (
            "state = \"final\"\n",
            "",
            "stage `friction` follows a stage with build state `azimuth-table` but names no build state",
        ),
        ("id = \"complete\"", "id = \"table-bare\"", "two stages have a prompt with the id `table-bare`"),
        ("640 kg*m^2", "0 kg*m^2", "`az`: the inertia must be positive"),
        ("id = \"loops\"", "id = \"l o\"", "`id` of a stage: letters, digits, `-` and `_`, such as `range`"),
    ] {
        let found = mistakes(from, to);
        assert!(found.iter().any(|message| message == expected), "{expected:?} is not in {found:?}");
    }
}

#[test]
fn an_earlier_build_state_verifies_nothing_and_opens_no_gate() {
    let campaign = right();
    let all = ["A", "B", "C"].map(friction);
    assert_eq!(check(&campaign, Some(all.iter().collect()), &requirements()), []);
    // Friction alone in the torque table: nothing is left that FRC-AZ could be judged by.
    let only_table = STAGES
        .replace(
            "needs = [\"friction\"]\nneeds-pass = [\"FRC-AZ\"]",
            "needs = [\"table\"]\nneeds-pass = [\"FRC-AZ\"]",
        )
        .replace(
            "[[procedure]]\nfile = \"friction.toml\"\nstage = \"friction\"\n",
            "[[procedure]]\nfile = \"m.toml\"\nstage = \"friction\"\n",
        );
    let campaign = read(&format!("{HEAD}{only_table}")).expect("right in itself");
    let found: Vec<String> = check(&campaign, Some(all.iter().collect()), &requirements())
        .into_iter()
        .map(|d| d.message)
        .collect();
    assert_eq!(found, ["no stage that `loops` needs measures requirement `FRC-AZ`"]);
    let bare = Campaign {
        stages: campaign.stages[..1].to_vec(),
        procedures: campaign.procedures[..1].to_vec(),
        ..campaign
    };
    let found: Vec<String> = check(&bare, Some(all[..1].iter().collect()), &requirements())
        .into_iter()
        .map(|d| d.message)
        .collect();
    assert!(found[0].starts_with("no procedure of the campaign measures `friction-torque`"), "{found:?}");
}
