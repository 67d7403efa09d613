//! What a check of the run folder found: whether its files are those that the run left.

use serde::{Deserialize, Serialize};

use super::FileHash;

/// How far the files of a run can be believed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EvidenceState {
    /// Everything that the journal has on record is there, unchanged, and nothing else is.
    Intact,
    /// Nothing speaks against the files, but they do not hold what a check needs.
    NotVerifiable,
    /// Something was changed, removed, added, swapped, or belongs to another run.
    Altered,
}

/// The result of a check.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct EvidenceRecord {
    /// In a word.
    pub state: EvidenceState,
    /// What was found, each in a sentence; empty where the folder is intact.
    pub reasons: Vec<String>,
    /// The files of the run with their digests as they are now.
    pub files: Vec<FileHash>,
    /// Digest of the evidence index, `SHA256SUMS`.
    pub index_sha256: Option<String>,
}

impl EvidenceState {
    /// The word as it is printed.
    pub fn word(self) -> &'static str {
        match self {
            Self::Intact => "intact",
            Self::NotVerifiable => "not verifiable",
            Self::Altered => "ALTERED",
        }
    }
}

impl EvidenceRecord {
    /// The digest of a file of the run.
    pub fn sha256_of(&self, file: &str) -> Option<&str> {
        self.files.iter().find(|f| f.file == file).map(|f| f.sha256.as_str())
    }

    /// State and reasons on one line.
    pub fn sentence(&self) -> String {
        match self.state {
            EvidenceState::Intact => format!(
                "intact: journal, logs, results and index agree ({} files); they are not signed with a \
                 station key, so a recomputed hash chain would not be detected",
                self.files.len()
            ),
            state => format!("{}: {}", state.word(), self.reasons.join("; ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FORMATS, sample};

    fn with(state: EvidenceState) -> crate::record::Results {
        let reasons = vec!["AZ-FRICTION.mcap is <not> the file that the journal has on record".to_owned()];
        let file = FileHash { file: "journal.jsonl".to_owned(), size_bytes: 1, sha256: "0c".repeat(32) };
        let index_sha256 = Some("1d".repeat(32));
        sample::results().with_evidence(EvidenceRecord { state, reasons, files: vec![file], index_sha256 })
    }

    #[test]
    fn every_text_format_says_how_the_evidence_stands_and_is_loud_where_it_was_altered() {
        for format in FORMATS {
            let word = |state: EvidenceState| match format.name {
                "json" => format!("\"state\": {}", serde_json::to_string(&state).expect("a word")),
                _ => state.word().to_owned(),
            };
            for state in [EvidenceState::Intact, EvidenceState::NotVerifiable, EvidenceState::Altered] {
                let Ok(text) = String::from_utf8((format.render)(&with(state))) else { continue };
                assert!(text.contains(&word(state)), "{} does not say {}", format.name, word(state));
            }
        }
        let page = crate::html::render(&with(EvidenceState::Altered));
        assert!(page.contains("class=\"draft\">EVIDENCE ALTERED<"), "in the title");
        assert!(page.contains("content: \"EVIDENCE ALTERED"), "in the margin of every printed page");
        assert!(page.contains("is &lt;not&gt; the file"));
        assert!(!crate::html::render(&with(EvidenceState::Intact)).contains("EVIDENCE ALTERED"));
    }

    #[test]
    fn the_index_on_paper_is_that_of_the_files_as_they_are_now() {
        let page = crate::html::render(&with(EvidenceState::Intact));
        for digest in ["0c".repeat(32), "1d".repeat(32)] {
            assert!(page.contains(&digest));
        }
    }
}
