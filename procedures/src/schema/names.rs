//! Names that a schema lists: conditions, gates, measurands, axes.

use serde_json::{Map, Value, json};

use super::limit;
use crate::condition::CONDITIONS;
use crate::kinds::KINDS;
use crate::procedure::GATES;

/// Gates with their limits, and what must hold of a point.
pub(super) fn procedure(schema: &mut Value) {
    let gates = GATES.iter().map(|(name, kind)| ((*name).to_owned(), limit(*kind)));
    keys_at(schema, "/properties/gate", gates.collect());
    let near = json!({
        "type": "string",
        "pattern": r"^\s*within\s.*\sof requested\s*$",
        "examples": ["within 5 % of requested"],
    });
    let valid_if = CONDITIONS.iter().map(|(name, _)| ((*name).to_owned(), near.clone()));
    let dropped = json!({ "type": "string", "pattern": r"^\s*<", "examples": ["< 0.1 %, longest < 5 ms"] });
    let valid_if = valid_if.chain([("dropped-cycles".to_owned(), dropped)]);
    keys_at(schema, "/properties/valid-if", valid_if.collect());
}

/// Points of a selection.
pub(super) fn campaign(schema: &mut Value) {
    keys_at(schema, "/properties/procedure/items/properties/points", selections());
}

/// Measurands, and conditions under which they count.
pub(super) fn requirements(schema: &mut Value) {
    let requirement = "/properties/requirement/items/properties";
    let measurands: Vec<&str> = KINDS.iter().flat_map(|k| k.measurands.iter().map(|m| m.name)).collect();
    let conditions: Vec<&str> = CONDITIONS.iter().map(|(name, _)| *name).collect();
    let covered = [&conditions[..], &[crate::requirement::ANGLE]].concat();
    for (place, words) in [
        ("/measurand/items", &measurands),
        ("/judge/items/properties/measurand", &measurands),
        ("/covers/items/properties/measurand", &measurands),
        ("/covers/items/properties/condition", &covered),
        ("/judge/items/properties/mask/properties/over", &conditions),
    ] {
        set_at(schema, &format!("{requirement}{place}"), "enum", json!(words));
    }
    for place in ["/where", "/judge/items/properties/bands/items/properties/where"] {
        keys_at(schema, &format!("{requirement}{place}"), selections());
    }
    let limit = json!(r"^\s*[<>≤≥]|\.\.");
    for place in
        ["/limit", "/judge/items/properties/limit", "/judge/items/properties/bands/items/properties/limit"]
    {
        set_at(schema, &format!("{requirement}{place}"), "pattern", limit.clone());
    }
}

/// Each condition with a value, a limit or a range, or a list of those.
fn selections() -> Map<String, Value> {
    let selection = |(name, kind): &(&str, crate::quantity::QuantityKind)| {
        let one =
            json!({ "type": "string", "pattern": kind.selection_pattern(), "examples": [kind.example()] });
        ((*name).to_owned(), json!({ "anyOf": [one.clone(), { "type": "array", "items": one }] }))
    };
    CONDITIONS.iter().map(selection).collect()
}

/// Lists the axes that a procedure may move. Requirements also know axes of sensors, so theirs stay free.
pub fn name_axes(procedure: &mut Value, axes: &[&str]) {
    set_at(procedure, "/properties/axis", "enum", json!(axes));
}

/// A table with these keys and no others where any key could stand.
fn keys_at(schema: &mut Value, place: &str, keys: Map<String, Value>) {
    set_at(schema, place, "properties", Value::Object(keys));
    set_at(schema, place, "additionalProperties", json!(false));
}

fn set_at(schema: &mut Value, place: &str, key: &str, value: Value) {
    if let Some(Value::Object(object)) = schema.pointer_mut(place) {
        object.insert(key.to_owned(), value);
    }
}
