//! JSON Schema (draft 2020-12) of the files that people write, from the same field lists that reading uses.
//!
//! Editors complete and underline with it. It is a little wider than the reader where JSON Schema cannot say it: the order of the
//! ends of a range, the quantity of a limit, which follows its measurand, and keys that exclude one another.

use serde_json::{Map, Value, json};

use crate::kinds::Kind;
use crate::quantity::QuantityKind;
use crate::table::{Field, Need, Shape};
use crate::{campaign, procedure, requirement};

mod names;
#[cfg(test)]
mod tests;

pub use names::name_axes;

const DRAFT: &str = "https://json-schema.org/draft/2020-12/schema";

/// Schema of an object with these fields and no others.
pub fn json_schema(fields: &[Field]) -> Value {
    let properties: Map<String, Value> =
        fields.iter().map(|field| (field.key.to_owned(), property(field))).collect();
    let required: Vec<&str> = fields.iter().filter(|f| f.need == Need::Required).map(|f| f.key).collect();
    json!({
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    })
}

/// A whole file: the schema of its root table with a title.
pub fn file_schema(title: &str, fields: &[Field]) -> Value {
    let mut schema = json_schema(fields);
    if let Value::Object(object) = &mut schema {
        object.insert("$schema".to_owned(), json!(DRAFT));
        object.insert("title".to_owned(), json!(title));
    }
    schema
}

/// Schema of procedure files of this kind.
pub fn procedure_schema(kind: &Kind) -> Value {
    let mut schema = file_schema(&format!("Procedure of kind {}", kind.name), &fields_of(kind));
    if let Some(property) = schema.pointer_mut("/properties/kind") {
        *property = json!({ "const": kind.name, "description": "Kind of experiment." });
    }
    names::procedure(&mut schema);
    schema
}

fn fields_of(kind: &Kind) -> Vec<Field> {
    procedure::FIELDS.iter().chain(kind.fields).copied().collect()
}

/// Schema of procedure files of all these kinds: the key `kind` says which other keys a file has.
pub fn procedures_schema(kinds: &[&Kind]) -> Value {
    let mut schema = file_schema("Procedure", procedure::FIELDS);
    let names: Vec<&str> = kinds.iter().map(|kind| kind.name).collect();
    let cases = kinds.iter().map(|kind| {
        let mut own = procedure_schema(kind);
        if let Value::Object(own) = &mut own {
            own.remove("$schema");
        }
        json!({
            "if": { "properties": { "kind": { "const": kind.name } }, "required": ["kind"] },
            "then": own,
        })
    });
    let cases: Vec<Value> = cases.collect();
    if let Some(property) = schema.pointer_mut("/properties/kind") {
        *property = json!({ "enum": names, "description": "Kind of experiment." });
    }
    if let Value::Object(schema) = &mut schema {
        schema.insert("allOf".to_owned(), Value::Array(cases));
        // Each case refuses the keys that its kind does not have.
        schema.remove("additionalProperties");
    }
    schema
}

/// Schema of campaign files.
pub fn campaign_schema() -> Value {
    let mut schema = file_schema("Campaign", campaign::FIELDS);
    names::campaign(&mut schema);
    schema
}

/// Schema of requirements files.
pub fn requirements_schema() -> Value {
    let mut schema = file_schema("Requirements", requirement::FIELDS);
    names::requirements(&mut schema);
    schema
}

/// Schema of tables with these fields and those of one variant, named by the text of the key `by`.
pub fn variants_schema(fields: &[Field], by: &str, variants: &[Variant]) -> Value {
    let each = variants.iter().map(|variant| {
        let all: Vec<Field> = fields.iter().chain(variant.fields).copied().collect();
        let mut schema = json_schema(&all);
        if let Some(property) = schema.pointer_mut(&format!("/properties/{by}")) {
            *property = json!({ "const": variant.name, "description": variant.doc });
        }
        schema
    });
    json!({ "anyOf": each.collect::<Vec<_>>() })
}

/// One sort of table among several.
#[derive(Clone, Copy, Debug)]
pub struct Variant {
    /// What names it.
    pub name: &'static str,
    /// One sentence.
    pub doc: &'static str,
    /// Keys that it adds.
    pub fields: &'static [Field],
}

fn property(field: &Field) -> Value {
    let mut schema = shape_schema(&field.shape);
    if let Value::Object(object) = &mut schema {
        object.insert("description".to_owned(), json!(field.doc));
        if field.key == "schema" {
            object.insert("const".to_owned(), json!(crate::table::SCHEMA));
        }
        if let Need::Default(text) = field.need {
            object.insert("default".to_owned(), default_value(&field.shape, text));
        }
    }
    schema
}

fn shape_schema(shape: &Shape) -> Value {
    match shape {
        Shape::Text => json!({ "type": "string" }),
        Shape::Texts => json!({ "type": "array", "items": { "type": "string" } }),
        Shape::Integer => json!({ "type": "integer" }),
        Shape::Integers => json!({ "type": "array", "items": { "type": "integer" } }),
        Shape::Boolean => json!({ "type": "boolean" }),
        Shape::Choice(words) => json!({ "enum": words }),
        Shape::Quantity(kind) => quantity(*kind),
        Shape::Quantities(kind) => json!({ "type": "array", "minItems": 1, "items": quantity(*kind) }),
        Shape::QuantitiesOf(kinds) => {
            let items = kinds.iter().map(|kind| quantity(*kind)).collect::<Vec<_>>();
            json!({ "type": "array", "minItems": 1, "items": { "anyOf": items } })
        }
        Shape::Range(kind) => {
            json!({ "type": "string", "pattern": kind.range_pattern(), "examples": [kind.range_example()] })
        }
        Shape::Limit(kind) => limit(*kind),
        Shape::Table(fields) => json_schema(fields),
        Shape::Tables(fields) => json!({ "type": "array", "items": json_schema(fields) }),
        Shape::Map(shape) => json!({ "type": "object", "additionalProperties": shape_schema(shape) }),
    }
}

fn quantity(kind: QuantityKind) -> Value {
    json!({ "type": "string", "pattern": kind.pattern(), "examples": [kind.example()] })
}

fn limit(kind: QuantityKind) -> Value {
    json!({
        "type": "string",
        "pattern": kind.limit_pattern(),
        "examples": [format!("<= {}", kind.example())],
    })
}

/// The default as it would stand in a file.
fn default_value(shape: &Shape, text: &str) -> Value {
    match shape {
        Shape::Integer => text.parse::<i64>().map_or(Value::Null, Value::from),
        Shape::Integers => text.split(',').filter_map(|item| item.trim().parse::<i64>().ok()).collect(),
        Shape::Boolean => json!(text == "true"),
        Shape::Texts | Shape::Quantities(_) | Shape::QuantitiesOf(_) => {
            let items = text.split(',').map(str::trim).filter(|item| !item.is_empty());
            items.map(Value::from).collect()
        }
        Shape::Table(_) | Shape::Map(_) => json!({}),
        Shape::Tables(_) => json!([]),
        _ => json!(text),
    }
}
