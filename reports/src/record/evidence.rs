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
                "intact: journal, logs, results and index agree ({} files); no station key has signed them, so a chain \
                 that somebody computed anew would not be noticed",
                self.files.len()
            ),
            state => format!("{}: {}", state.word(), self.reasons.join("; ")),
        }
    }
}
