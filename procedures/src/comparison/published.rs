//! Values from a publication or an earlier report, as a file that people write.

use super::{Call, Quantity, Value, ValuePair};
use crate::condition;
use crate::diagnostic::{Diagnostic, SourceFile};
use crate::kinds;
use crate::measurement::Measurement;
use crate::quantity::QuantityKind;
use crate::requirement::Where;
use crate::table::{Field, MapEntry, SCHEMA_FIELD, Shape, TableReader, read_file, suggestion};

/// Keys of a file of published values.
pub const FIELDS: &[Field] = &[
    SCHEMA_FIELD,
    Field::required("id", Shape::Text, "Name of the table."),
    Field::required("title", Shape::Text, "Heading."),
    Field::required("source", Shape::Text, "Where the values were published."),
    Field::required("value", Shape::Tables(VALUE_FIELDS), "One table for each value."),
];

/// Keys of a `[[value]]`.
const VALUE_FIELDS: &[Field] = &[
    Field::required("measurand", Shape::Text, "Measurand, one of `bench list measurands`."),
    Field::optional(
        "procedure",
        Shape::Text,
        "Id of the procedure that must have measured it; default: any.",
    ),
    Field::optional("axis", Shape::Text, "Axis; default: any."),
    Field::optional(
        "where",
        Shape::Map(&Shape::Text),
        "Conditions under which it was measured, e.g. `{ elevation = \"40 deg\" }`; all of them must hold.",
    ),
    Field::required("value", Shape::Text, "The value with its unit, e.g. `\"46.5 deg\"`."),
    Field::required(
        "u",
        Shape::Text,
        "Its standard uncertainty with its unit; of a rounded figure 0.29 of its last digit.",
    ),
];

/// A table of published values.
#[derive(Clone, Debug, PartialEq)]
pub struct PublishedTable {
    /// Name.
    pub id: String,
    /// Heading.
    pub title: String,
    /// Where the values were published.
    pub source: String,
    /// The values, in the order of the file.
    pub values: Vec<PublishedValue>,
}

/// A published value.
#[derive(Clone, Debug, PartialEq)]
pub struct PublishedValue {
    procedure: Option<String>,
    measurand: String,
    axis: Option<String>,
    conditions: Vec<Where>,
    kind: QuantityKind,
    pub(super) value: Value,
}

impl PublishedTable {
    /// Reads the file.
    ///
    /// # Errors
    /// All mistakes at once.
    pub fn parse(source: &SourceFile) -> Result<Self, Vec<Diagnostic>> {
        read_file(source, FIELDS, |table| {
            table.schema();
            let [id, title, from] = ["id", "title", "source"].map(|key| table.text(key));
            let values = table.tables("value", value)?;
            if values.is_empty() && table.mistakes() == 0 {
                table.mistake("value", "the table has no value", None);
            }
            Some(Self { id: id?, title: title?, source: from?, values })
        })
    }
}

impl PublishedValue {
    pub(super) fn is_from(&self, procedure: &str) -> bool {
        self.procedure.as_ref().is_none_or(|own| own == procedure)
    }

    /// Whether a measurement is one of this quantity under these conditions; one that does not say a condition is not.
    pub(super) fn is_of(&self, m: &Measurement) -> bool {
        let holds = |w: &Where| m.conditions.iter().any(|c| c.name == w.condition && w.meets.holds(c));
        m.measurand == self.measurand
            && self.axis.as_ref().is_none_or(|axis| *axis == m.axis)
            && self.conditions.iter().all(holds)
    }

    /// The value that the run did not measure.
    pub(super) fn alone(&self) -> ValuePair {
        let conditions: Vec<String> =
            self.conditions.iter().map(|w| format!("{} {}", w.condition, w.meets.text())).collect();
        let point = (!conditions.is_empty()).then(|| conditions.join(", "));
        ValuePair {
            quantity: Quantity {
                procedure: self.procedure.clone().unwrap_or_default(),
                measurand: self.measurand.clone(),
                axis: self.axis.clone().unwrap_or_default(),
                point,
                conditions: Vec::new(),
                kind: self.kind,
            },
            a: None,
            b: Some(self.value),
            difference: None,
            call: Call::OnlyInB,
            reason: Some("the run has no value under these conditions".to_owned()),
        }
    }
}

fn value(table: &mut TableReader<'_>) -> Option<PublishedValue> {
    let name = table.text("measurand");
    let procedure = table.text("procedure");
    let axis = table.text("axis");
    let entries = table.lists("where").unwrap_or_default();
    let conditions: Vec<Where> = entries.into_iter().filter_map(|entry| meets(table, entry)).collect();
    let texts = ["value", "u"].map(|key| table.text(key));
    let name = name?;
    let Some((_, measurand)) = kinds::measurand(&name) else {
        let known = kinds::KINDS.iter().flat_map(|kind| kind.measurands.iter().map(|m| m.name));
        table.mistake("measurand", format!("unknown measurand `{name}`"), Some(suggestion(&name, known)));
        return None;
    };
    let [value, u] = texts;
    let value = number(table, "value", &value?, measurand.kind);
    let u = number(table, "u", &u?, measurand.kind);
    if u.is_some_and(|u| u < 0.0) {
        let help = "write how well the value is known, e.g. 0.29 of its last digit";
        table.mistake("u", "a standard uncertainty below zero", Some(help.to_owned()));
    }
    let value = Value { value: value?, u: u?, dof: None };
    Some(PublishedValue { procedure, measurand: name, axis, conditions, kind: measurand.kind, value })
}

fn meets(table: &mut TableReader<'_>, entry: MapEntry) -> Option<Where> {
    let meets = condition::read_meets(table, &entry)?;
    Some(Where { condition: entry.key, meets })
}

fn number(table: &mut TableReader<'_>, key: &str, text: &str, kind: QuantityKind) -> Option<f64> {
    let parsed = kind.parse(text);
    parsed.map_err(|error| table.mistake(key, format!("`{key}`: {error}"), error.help())).ok()
}
