//! Waivers of a run: which demands the customer lets pass for this unit, by whom and until when.

use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::table::{Field, SCHEMA_FIELD, Shape, TableReader, read_file, suggestion};
use reports::record::WaiverRecord;

use super::rig::day;

/// Keys of a waivers file.
pub(crate) const FIELDS: &[Field] =
    &[SCHEMA_FIELD, Field::required("waiver", Shape::Tables(WAIVER_FIELDS), "One table per waiver.")];

/// Keys of a `[[waiver]]`.
const WAIVER_FIELDS: &[Field] = &[
    Field::required("requirement", Shape::Text, "Id of the requirement that is waived, e.g. `FRC-AZ`."),
    Field::required("number", Shape::Text, "Number of the waiver; unique in the file."),
    Field::required("approver", Shape::Text, "Who approved it: name and organisation."),
    Field::required("expiry", Shape::Text, "Last day on which it is valid, `2027-03-01`."),
    Field::required("reason", Shape::Text, "Reason and conditions of the waiver."),
];

/// Reads a waivers file; `requirements` are the ids of the run that it is for.
///
/// # Errors
/// All mistakes at once, waivers of requirements that the run does not know among them.
pub(crate) fn read(source: &SourceFile, requirements: &[&str]) -> Result<Vec<WaiverRecord>, Vec<Diagnostic>> {
    read_file(source, FIELDS, |table| {
        table.schema()?;
        let all = table.tables("waiver", |entry| one(entry, requirements))?;
        if let Some(twice) = (1..all.len()).find(|&k| all[..k].iter().any(|w| w.number == all[k].number)) {
            let message = format!("two waivers have the number `{}`", all[twice].number);
            table.mistake("waiver", message, Some("give each waiver its own number".to_owned()));
        }
        Some(all)
    })
}

fn one(entry: &mut TableReader<'_>, requirements: &[&str]) -> Option<WaiverRecord> {
    let requirement = entry.text("requirement");
    let expiry = day(entry, "expiry");
    let [number, approver, reason] = ["number", "approver", "reason"].map(|key| entry.text(key));
    let unknown = requirement.as_deref().filter(|id| !requirements.contains(id));
    if let Some(id) = unknown {
        let help = suggestion(id, requirements.iter().copied());
        entry.mistake("requirement", format!("no requirement `{id}` in this run"), Some(help));
    }
    let requirement = requirement?;
    let number = number?;
    Some(WaiverRecord { requirement, number, approver: approver?, expiry: expiry?, reason: reason? })
}

#[cfg(test)]
mod tests {
    use super::*;

    const RIGHT: &str = "schema = 1\n[[waiver]]\nrequirement = \"FRC-AZ\"\nnumber = \"W-17\"\n\
        approver = \"B. Customer\"\nexpiry = \"2026-12-31\"\nreason = \"retainer is exchanged\"\n";

    fn mistakes(text: &str) -> String {
        let source = SourceFile { name: "waivers.toml".to_owned(), text: text.to_owned() };
        let found = read(&source, &["FRC-AZ", "FRC-EL"]).expect_err("it has mistakes");
        found.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
    }

    #[test]
    fn a_waiver_holds_through_its_last_day() {
        let source = SourceFile { name: "waivers.toml".to_owned(), text: RIGHT.to_owned() };
        let all = read(&source, &["FRC-AZ"]).expect("it is right");
        assert_eq!((all.len(), all[0].number.as_str(), all[0].requirement.as_str()), (1, "W-17", "FRC-AZ"));
        assert!(!all[0].has_expired_by("2026-12-31T23:59:59Z"));
        assert!(all[0].has_expired_by("2027-01-01T00:00:00Z"));
    }

    #[test]
    fn what_cannot_be_a_waiver_is_told() {
        assert!(mistakes(&RIGHT.replace("FRC-AZ", "FRC-AX")).contains("no requirement `FRC-AX` in this run"));
        assert!(mistakes(&RIGHT.replace("2026-12-31", "2026-02-30")).contains("must be a day"));
        assert!(mistakes(&RIGHT.replace("approver = \"B. Customer\"\n", "")).contains("approver"));
        let twice = format!("{RIGHT}{}", &RIGHT[RIGHT.find("[[").expect("an entry")..]);
        assert!(mistakes(&twice).contains("two waivers have the number `W-17`"));
    }
}
