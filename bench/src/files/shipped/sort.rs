//! Which sort of file a text is, by its keys: what is said where another sort was expected.

use procedures::diagnostic::{Diagnostic, SourceFile};
use toml::de::DeTable;

use super::Folder;

/// A sort of file that people write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sort {
    /// Procedures in order.
    Campaign,
    /// One experiment.
    Procedure,
    /// Limits.
    Requirements,
    /// What the bench is.
    Rig,
    /// A simulated unit, or a defect.
    Unit,
    /// Distributions that units are drawn from.
    Family,
    /// Answers to questions.
    Answers,
    /// What is let pass.
    Waivers,
    /// What a table of another tool holds.
    Import,
    /// A type of drive.
    Profile,
    /// A type of instrument that sends its readings as text.
    Reader,
    /// Values from a publication.
    Published,
    /// By how much a controller may become worse.
    Criteria,
}

/// Keys by which a sort is known: the first row of which one stands in the file counts.
const KEYS: &[(Sort, &[&str])] = &[
    (Sort::Procedure, &["kind"]),
    (Sort::Requirements, &["requirement"]),
    (Sort::Answers, &["answers"]),
    (Sort::Waivers, &["waiver"]),
    (Sort::Import, &["time-column", "channel"]),
    (Sort::Profile, &["process-data", "torque-scale"]),
    (Sort::Reader, &["pattern", "terminator"]),
    (Sort::Published, &["value"]),
    (Sort::Criteria, &["criterion", "looks"]),
    (Sort::Family, &["setting", "mode-factor", "correlation"]),
    (Sort::Rig, &["tier", "loop-rate", "device", "parameters"]),
    (Sort::Campaign, &["procedure", "must-measure", "requirements"]),
    (Sort::Procedure, &["sweep", "gate", "valid-if"]),
    (
        Sort::Unit,
        &["base", "world", "must-flip", "must-trip", "az", "el", "imu", "mirror", "trackers", "step-rate"],
    ),
];

impl Sort {
    /// The sort of a file; `None` where its keys say nothing.
    pub fn of(source: &SourceFile) -> Option<Self> {
        let (root, _) = DeTable::parse_recoverable(&source.text);
        let has = |key: &&str| root.get_ref().get(*key).is_some();
        KEYS.iter().find(|(_, keys)| keys.iter().any(&has)).map(|(sort, _)| *sort)
    }

    /// Whether files of this sort are looked for in a folder.
    pub fn fits(self, folder: Folder) -> bool {
        match folder {
            Folder::Procedures => matches!(self, Self::Campaign | Self::Procedure),
            Folder::Requirements => self == Self::Requirements,
            Folder::Rigs => self == Self::Rig,
            Folder::Units | Folder::States => self == Self::Unit,
            Folder::Families => self == Self::Family,
            Folder::Parameters => false,
            Folder::Profiles => self == Self::Profile,
            Folder::Readers => self == Self::Reader,
            Folder::Criteria => self == Self::Criteria,
        }
    }

    /// What such a file holds, and how it is given to the program.
    fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Campaign => ("a campaign", "name it without an option: `bench run FILE`"),
            Self::Procedure => ("a procedure", "name it without an option: `bench run FILE`"),
            Self::Requirements => ("requirements", "give them with `--requirements FILE`"),
            Self::Rig => ("a rig", "give it with `--rig FILE`"),
            Self::Unit => ("a simulated unit", "give it with `--unit FILE`"),
            Self::Family => ("a family of units", "draw units from it with `bench draw FILE`"),
            Self::Answers => ("answers to questions", "give them with `run --answers FILE`"),
            Self::Waivers => ("waivers", "give them with `report --waivers FILE`"),
            Self::Profile => ("a drive profile", "name it in a rig file: `profile = \"FILE\"`"),
            Self::Reader => ("a reader profile", "name it in a rig file: `profile = \"FILE\"` of a device"),
            Self::Published => ("published values", "give them to `bench compare RUN FILE`"),
            Self::Criteria => {
                ("criteria of a comparison of controllers", "give them with `regress --criteria FILE`")
            }
            Self::Import => ("a map for an import", "give it to `bench import FILE`"),
        }
    }
}

/// Refuses a file that holds something else than what is looked for, before its keys are read one by one: each of them would be
/// wrong.
///
/// # Errors
/// What it holds, and how that is given to the program.
pub fn expect(source: SourceFile, folder: Folder) -> Result<SourceFile, Vec<Diagnostic>> {
    match Sort::of(&source).filter(|sort| !sort.fits(folder)) {
        None => Ok(source),
        Some(sort) => {
            let (holds, help) = sort.words();
            let message = format!("{} contains {holds}; expected {}", source.name, folder.content());
            Err(vec![Diagnostic::new(message).help(help.replace("FILE", &source.name))])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::shipped::all;

    #[test]
    fn every_shipped_file_is_of_the_sort_that_its_folder_is_for() {
        for folder in [
            Folder::Procedures,
            Folder::Requirements,
            Folder::Rigs,
            Folder::Units,
            Folder::Families,
            Folder::Profiles,
            Folder::Readers,
            Folder::Criteria,
        ] {
            for file in all(folder) {
                let sort = Sort::of(&file.source());
                let is_own = sort.is_some_and(|sort| sort.fits(folder));
                let is_beside = folder == Folder::Procedures && file.is_requirements();
                assert!(is_own || is_beside && sort == Some(Sort::Requirements), "{}: {sort:?}", file.path);
            }
        }
    }
}
