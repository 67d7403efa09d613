//! Options for external velocity laws.

use std::path::PathBuf;
use std::time::Duration;

use controllers::parameter::AXIS_PARAMETERS;
use external_law::Parameter;
use procedures::diagnostic::nearest;

use super::output;
use crate::cycle::laws::{Law, Laws};
use crate::exit;
use crate::files::settings::quantity_kind;
use crate::model::rig::{Rig, Tier};
use crate::record::ITSELF;

/// Letters of a SHA-256 in hexadecimal.
const DIGEST_LETTERS: usize = 64;

/// External laws of a run.
#[derive(clap::Args, Clone, Debug)]
pub(super) struct LawArgs {
    /// Close the velocity loop of an axis with the law of a shared library, `AXIS=FILE@SHA256`; may be repeated
    #[arg(long, value_name = "AXIS=FILE@SHA256", value_parser = asked_law)]
    pub(super) law: Vec<AskedLaw>,
    /// Step external laws in processes of their own in virtual time, too; elsewhere they always are
    #[arg(long, requires = "law")]
    pub(super) host_laws: bool,
}

/// A law as somebody asked for it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct AskedLaw {
    axis: String,
    file: PathBuf,
    sha256: String,
}

pub(super) fn asked_law(text: &str) -> Result<AskedLaw, String> {
    let form = || format!("expected AXIS=FILE@SHA256, e.g. `az=law.so@5e88…`, found `{text}`");
    let (axis, rest) = text.split_once('=').ok_or_else(form)?;
    let (file, sha256) = rest.rsplit_once('@').ok_or_else(form)?;
    if axis.is_empty() || file.is_empty() {
        return Err(form());
    }
    if sha256.len() != DIGEST_LETTERS || !sha256.chars().all(|c| c.is_ascii_hexdigit()) {
        return Err(format!(
            "expected {DIGEST_LETTERS} hexadecimal digits after `@`, found `{sha256}`; `sha256sum {file}` prints them"
        ));
    }
    let sha256 = sha256.to_ascii_lowercase();
    Ok(AskedLaw { axis: axis.to_owned(), file: PathBuf::from(file), sha256 })
}

impl LawArgs {
    /// Loads and checks the libraries; nothing is opened yet.
    pub(super) fn load(&self, rig: &Rig) -> Result<Laws, u8> {
        self.read(rig).map_err(|why| {
            output::error(&why);
            exit::USAGE
        })
    }

    /// The same, with what is wrong as text.
    pub(super) fn read(&self, rig: &Rig) -> Result<Laws, String> {
        let mut laws = Laws::default();
        for asked in &self.law {
            self.load_one(asked, rig, &mut laws).map_err(|why| format!("law {}={why}", asked.axis))?;
        }
        Ok(laws)
    }

    fn load_one(&self, asked: &AskedLaw, rig: &Rig, laws: &mut Laws) -> Result<(), String> {
        let file = asked.file.display();
        let axes = rig.axis_names();
        if !axes.contains(&asked.axis) {
            return Err(format!(
                "{file}: rig `{}` has no axis `{}`; expected {}",
                rig.id,
                asked.axis,
                axes.join(", ")
            ));
        }
        // No computer has been shown yet that holds the deadline for as long as a run takes.
        if rig.tier == Tier::Hardware {
            return Err(format!(
                "{file}: the axes of rig `{}` are real; external laws are not released for them yet: rehearse the rig with `--tier paced`, \
                 or with `--tier wired` at a served simulator",
                rig.id
            ));
        }
        let hosted = |deadline| Law::hosted(&asked.file, &asked.sha256, PathBuf::from(ITSELF), deadline);
        let law = match rig.tier {
            Tier::Virtual if !self.host_laws => Law::in_process(&asked.file, &asked.sha256),
            Tier::Virtual => hosted(None),
            Tier::Paced | Tier::Wired | Tier::Hardware => {
                hosted(Some(Duration::from_secs_f64(rig.law_deadline_s)))
            }
        }?;
        for parameter in &law.description.parameters {
            check(parameter).map_err(|why| format!("{file}: parameter `{}`: {why}", parameter.name))?;
        }
        match laws.insert(&asked.axis, law) {
            true => Ok(()),
            false => Err(format!("{file}: the axis has a law already; name one `--law` for each axis")),
        }
    }
}

/// Whether a parameter has a value: in the parameter file, in the unit that the law expects, or by the law itself.
fn check(parameter: &Parameter) -> Result<(), String> {
    let Some(known) = AXIS_PARAMETERS.iter().find(|known| known.key == parameter.name) else {
        let near = nearest(&parameter.name, AXIS_PARAMETERS.iter().map(|known| known.key));
        let near = near.map_or(String::new(), |near| format!(", did you mean `{near}`?"));
        return parameter.default_si.map(|_| ()).ok_or_else(|| {
            format!("expected a key of an axis in the parameter file or a default value, found neither{near}")
        });
    };
    let unit = quantity_kind(known.quantity).map_or("", |kind| kind.si_unit());
    if parameter.unit == unit {
        return Ok(());
    }
    Err(format!("expected unit `{unit}`, found `{}`", parameter.unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_is_an_axis_a_file_and_a_digest() {
        let digest = "0123456789abcdefABCDEF0123456789abcdef0123456789abcdef0123456789";
        let asked = asked_law(&format!("az=a=b@2/law.so@{digest}")).expect("well formed");
        assert_eq!((asked.axis.as_str(), asked.file.to_str()), ("az", Some("a=b@2/law.so")));
        assert_eq!(asked.sha256, digest.to_ascii_lowercase());
    }

    #[test]
    fn everything_else_is_told_what_was_expected() {
        for (text, expected) in [
            ("", "expected AXIS=FILE@SHA256"),
            ("law.so@12", "expected AXIS=FILE@SHA256"),
            ("az=law.so", "expected AXIS=FILE@SHA256"),
            ("=law.so@12", "expected AXIS=FILE@SHA256"),
            ("az=law.so@12", "expected 64 hexadecimal digits"),
        ] {
            let found = asked_law(text).expect_err(text);
            assert!(found.starts_with(expected), "{text}: {found}");
        }
    }
}
