//! Pages of `bench explain` about things that have no file of their own.

use procedures::campaign::FIELDS as CAMPAIGN;
use procedures::comparison::PUBLISHED_FIELDS;
use procedures::condition::CONDITIONS;
use procedures::diagnostic::SourceFile;
use procedures::procedure::{FIELDS as PROCEDURE, GATES};
use procedures::quantity::QuantityKind;
use procedures::requirement::FIELDS as REQUIREMENTS;
use procedures::table::Field;

use super::examples::{Examples, keys};
use crate::cli::output;
use crate::files::shipped::{self, Folder};
use crate::files::{answers, family, import_map, profile, reader, rig, unit, waivers};
use crate::plan::is_campaign;

/// A page by its name.
struct Topic {
    name: &'static str,
    /// One line for the list of topics.
    doc: &'static str,
    text: fn() -> String,
}

const TOPICS: &[Topic] = &[
    Topic { name: "units", doc: "kinds of quantities and their units", text: units },
    Topic {
        name: "verdicts",
        doc: "meaning of pass, screened, inconclusive and the other verdicts",
        text: || report("2 Verdicts"),
    },
    Topic { name: "rules", doc: "decision rules and guard bands", text: || report("3 Decision rules") },
    Topic { name: "selection", doc: "what `--select` runs", text: || SELECTION.trim().to_owned() },
    Topic { name: "gates", doc: "conditions that must be met before a point or a stage", text: gates },
    Topic {
        name: "stages",
        doc: "stages of a campaign and build states of the unit",
        text: || STAGES.trim().to_owned(),
    },
    Topic {
        name: "conditions",
        doc: "measurement conditions, for `points`, `where`, `covers` and `valid-if`",
        text: conditions,
    },
    Topic { name: "procedure-file", doc: "keys that procedures of every kind have", text: procedure_file },
    Topic { name: "campaign-file", doc: "keys of a campaign", text: campaign_file },
    Topic { name: "requirements-file", doc: "keys of a requirements file", text: requirements_file },
    Topic { name: "rig-file", doc: "keys of a rig", text: rig_keys },
    Topic { name: "profile-file", doc: "keys of a drive profile", text: profile_file },
    Topic { name: "reader-file", doc: "keys of a reader profile", text: reader_file },
    Topic { name: "unit-file", doc: "keys of a simulated unit", text: unit_file },
    Topic { name: "family-file", doc: "keys of a family of units", text: family_file },
    Topic { name: "import-file", doc: "keys of a map for `bench import`", text: import_file },
    Topic { name: "answers-file", doc: "keys of answers to prompts", text: answers_file },
    Topic { name: "waivers-file", doc: "keys of waivers", text: waivers_file },
    Topic {
        name: "published-file",
        doc: "keys of published values for `bench compare`",
        text: published_file,
    },
    Topic { name: "glossary", doc: "terms used by the bench", text: || GLOSSARY.trim().to_owned() },
];

const REPORT: &str = include_str!("../../../../docs/report.md");
const GLOSSARY: &str = include_str!("../../../../docs/glossary.md");

const SELECTION: &str = "
`--select WORD…` runs only the procedures that one of the words selects. A word is the id of a requirement, of a
procedure or of a stage, the name of an axis, or a kind. Procedures on which the selected ones depend are added: the
polarity check before closed loops, the procedures that show the signs of trackers and mirror, and the torque constant
by force gauge for requirements on torques. The report is marked PARTIAL, and only the requirements that the selection
verifies must get a verdict.

  bench run --select FRC-AZ                  the procedures that measure the friction of azimuth
  bench run fat --select velocity-loop       one stage
  bench run fat --select hysteresis el       one kind, and all procedures of one axis
";

const STAGES: &str = "
A campaign may have `[[stage]]` entries. Each of its procedures then belongs to one stage. A stage begins when the
stages that it `needs` are over and all of their procedures have completed. With `needs-pass` the named requirements
must have passed. Otherwise the stage is skipped with the reason, and the run continues with the stages that do not
need it.

A stage may require a build state of the unit (`state`): azimuth as a torque table, azimuth on its supports, both axes
with an equivalent payload, or `final`. A safety prompt asks the operator to confirm it. What is measured in an
earlier build state is reported but not judged. `bench list states` shows the build states, `bench plan CAMPAIGN` the
stages with their prompts.
";

/// The page of this name.
pub(super) fn page(name: &str) -> Option<String> {
    TOPICS.iter().find(|topic| topic.name == name).map(|topic| (topic.text)())
}

/// Names of all pages.
pub(super) fn names() -> impl Iterator<Item = &'static str> + Clone {
    TOPICS.iter().map(|topic| topic.name)
}

/// Pages with what they are about.
pub(crate) fn rows() -> Vec<Vec<String>> {
    TOPICS.iter().map(|topic| vec![topic.name.to_owned(), topic.doc.to_owned()]).collect()
}

/// A section of `docs/report.md` by its heading.
fn report(heading: &str) -> String {
    let section = REPORT.split("\n## ").find_map(|part| part.strip_prefix(heading));
    section.unwrap_or_default().lines().skip(1).collect::<Vec<_>>().join("\n").trim().to_owned()
}

fn units() -> String {
    let row = |kind: QuantityKind| {
        let symbols: Vec<&str> = kind.symbols().filter(|symbol| !symbol.is_empty()).collect();
        vec![kind.noun().to_owned(), format!("\"{}\"", kind.example()), symbols.join(", ")]
    };
    let head = ["quantity", "example", "units"].map(str::to_owned).to_vec();
    let rows: Vec<Vec<String>> =
        std::iter::once(head).chain(QuantityKind::ALL.into_iter().map(row)).collect();
    format!(
        "Write quantities in quotes, with their unit: \"10 deg/s\". Write two points between the ends of a \
         range: \"-10 deg .. 90 deg\". Begin a limit with a comparator: \"<= 45 N*m\". The unit must be \
         one of the quantity, even where dimensions agree: Hz is not accepted for an angular \
         velocity.\n\n{}",
        output::table(&rows)
    )
}

fn gates() -> String {
    let rows: Vec<Vec<String>> = GATES
        .iter()
        .map(|(name, kind)| vec![format!("  {name}"), format!("\"< {}\"", kind.example())])
        .collect();
    format!(
        "A gate is a condition that must be met before anything moves. Otherwise the point is refused \
         (exit 6) or, where `cool-down` is given, the run waits for the heat sinks to cool down. A \
         procedure sets these gates under `[gate]`:\n{}\nEvery run also checks that the disk has room \
         for the planned logs. The gate `polarity` keeps every loop open until the signs and scales of \
         torque, encoders and gyros are proven. Stages of a campaign have their own gates (`bench explain \
         stages`). Interlocks are not gates: they are checked in every tick (`bench explain rig`).",
        output::table(&rows)
    )
}

fn conditions() -> String {
    let rows: Vec<Vec<String>> = CONDITIONS
        .iter()
        .map(|(name, kind)| {
            vec![format!("  {name}"), kind.noun().to_owned(), format!("\"{}\"", kind.example())]
        })
        .collect();
    format!(
        "Conditions under which something is measured. A campaign selects points by them (`points = {{ \
         velocity = [\"10 deg/s\"] }}`). A requirement limits the measurements it counts (`where = {{ \
         velocity = \"<= 10 deg/s\" }}`) and claims ranges that must be covered (`covers`, which also knows \
         `angle`: the angles of the axis between which a value was measured). A procedure \
         demands that they were reached (`valid-if`).\n{}",
        output::table(&rows)
    )
}

fn procedure_file() -> String {
    let shipped = Examples::of_folder(Folder::Procedures, |table| table.contains_key("kind"));
    file_keys(
        "Keys that procedures of every kind have; `bench explain KIND` shows the others",
        PROCEDURE,
        &shipped,
    )
}

fn campaign_file() -> String {
    let shipped = Examples::of_folder(Folder::Procedures, |table| table.contains_key("procedure"));
    file_keys("Keys of a campaign", CAMPAIGN, &shipped)
}

fn requirements_file() -> String {
    file_keys(
        "Keys of a requirements file",
        REQUIREMENTS,
        &Examples::of_folder(Folder::Requirements, |_| true),
    )
}

fn rig_keys() -> String {
    let shipped = Examples::of_folder(Folder::Rigs, |_| true);
    let keys = file_keys("Keys of a rig", rig::FIELDS, &shipped);
    format!(
        "{keys}\n\nA device has the keys of its driver, too: `bench explain DRIVER`. Safety: `bench explain rig`."
    )
}

fn profile_file() -> String {
    file_keys("Keys of a drive profile", profile::FIELDS, &Examples::of_folder(Folder::Profiles, |_| true))
}

fn reader_file() -> String {
    file_keys("Keys of a reader profile", reader::FIELDS, &Examples::of_folder(Folder::Readers, |_| true))
}

fn unit_file() -> String {
    file_keys("Keys of a simulated unit", unit::fields(), &Examples::of_folder(Folder::Units, |_| true))
}

fn family_file() -> String {
    file_keys("Keys of a family of units", family::FIELDS, &Examples::of_folder(Folder::Families, |_| true))
}

fn import_file() -> String {
    file_keys("Keys of a map for `bench import`", import_map::FIELDS, &Examples::none())
}

fn answers_file() -> String {
    file_keys("Keys of answers to prompts", answers::FIELDS, &Examples::none())
}

fn published_file() -> String {
    file_keys("Keys of published values", PUBLISHED_FIELDS, &Examples::none())
}

fn waivers_file() -> String {
    file_keys("Keys of waivers", waivers::FIELDS, &Examples::none())
}

fn file_keys(title: &str, fields: &[Field], examples: &Examples) -> String {
    let keys = fields.iter().flat_map(|field| keys("", field, examples));
    std::iter::once(title.to_owned()).chain(keys).collect::<Vec<_>>().join("\n")
}

/// A shipped campaign or procedure: its title, and its file.
pub(super) fn file(name: &str) -> Option<String> {
    let stem = name.trim_end_matches(".toml");
    let all = || shipped::all(Folder::Procedures).filter(|e| !e.is_requirements());
    let by_path = all().find(|e| e.path.trim_end_matches(".toml") == stem);
    let found = by_path.or_else(|| all().find(|e| e.stem() == stem))?;
    let source: SourceFile = found.source();
    let what = if is_campaign(&source) { "campaign" } else { "procedure" };
    Some(format!("{what} {}\n\n{}", source.name, source.text.trim()))
}

/// A shipped rig: its file.
pub(super) fn rig_file(name: &str) -> Option<String> {
    let found = shipped::all(Folder::Rigs).find(|e| e.stem() == name)?;
    Some(format!("rig {}\n\n{}", found.source().name, found.text.trim()))
}

/// A shipped profile of drives or readers: its file.
pub(super) fn profile(name: &str) -> Option<String> {
    let folders = [Folder::Profiles, Folder::Readers];
    let mut all = folders.into_iter().flat_map(|folder| shipped::all(folder).map(move |e| (folder, e)));
    let (folder, found) = all.find(|(_, e)| e.stem() == name)?;
    Some(format!("{} {}\n\n{}", folder.noun(), found.source().name, found.text.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_topic_has_a_page() {
        for topic in TOPICS {
            assert!((topic.text)().lines().count() > 3, "{}", topic.name);
        }
        assert!(
            report("2 Verdicts").contains("conditional pass")
                && report("3 Decision rules").contains("guarded")
        );
        assert!(units().contains("N*m/A"), "{}", units());
    }
}
