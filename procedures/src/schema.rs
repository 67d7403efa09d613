//! JSON Schema (draft 2020-12) of the files that people write, from the same field lists that reading uses.
//!
//! Editors complete and underline with it. It is a little wider than the reader where JSON Schema cannot say it:
//! units of a quantity, names of conditions and gates, the ends of a range.

use serde_json::{Map, Value, json};

use crate::kinds::Kind;
use crate::table::{Field, Need, Shape};
use crate::{campaign, procedure, requirement};

#[cfg(test)]
mod tests;

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
    let fields: Vec<Field> = procedure::FIELDS.iter().chain(kind.fields).copied().collect();
    let mut schema = file_schema(&format!("Procedure of kind {}", kind.name), &fields);
    if let Some(property) = schema.pointer_mut("/properties/kind") {
        *property = json!({ "const": kind.name, "description": "Kind of experiment." });
    }
    schema
}

/// Schema of campaign files.
pub fn campaign_schema() -> Value {
    file_schema("Campaign", campaign::FIELDS)
}

/// Schema of requirements files.
pub fn requirements_schema() -> Value {
    file_schema("Requirements", requirement::FIELDS)
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
        Shape::Boolean => json!({ "type": "boolean" }),
        Shape::Choice(words) => json!({ "enum": words }),
        Shape::Quantity(kind) => json!({ "type": "string", "examples": [kind.example()] }),
        Shape::Quantities(kind) => json!({
            "type": "array",
            "minItems": 1,
            "items": { "type": "string", "examples": [kind.example()] },
        }),
        Shape::Range(kind) => {
            json!({ "type": "string", "pattern": "\\.\\.", "examples": [kind.range_example()] })
        }
        Shape::Limit(kind) => json!({
            "type": "string",
            "pattern": "^\\s*[<>≤≥]|\\.\\.",
            "examples": [format!("<= {}", kind.example())],
        }),
        Shape::Table(fields) => json_schema(fields),
        Shape::Tables(fields) => json!({ "type": "array", "items": json_schema(fields) }),
        Shape::Map(shape) => json!({ "type": "object", "additionalProperties": entry_schema(shape) }),
    }
}

/// An entry of a map of lists may be a single text too.
fn entry_schema(shape: &Shape) -> Value {
    match shape {
        Shape::Texts => json!({ "anyOf": [shape_schema(&Shape::Text), shape_schema(shape)] }),
        other => shape_schema(other),
    }
}

/// The default as it would stand in a file.
fn default_value(shape: &Shape, text: &str) -> Value {
    match shape {
        Shape::Integer => text.parse::<i64>().map_or(Value::Null, Value::from),
        Shape::Boolean => json!(text == "true"),
        Shape::Texts | Shape::Quantities(_) => {
            let items = text.split(',').map(str::trim).filter(|item| !item.is_empty());
            items.map(Value::from).collect()
        }
        Shape::Table(_) | Shape::Map(_) => json!({}),
        Shape::Tables(_) => json!([]),
        _ => json!(text),
    }
}
