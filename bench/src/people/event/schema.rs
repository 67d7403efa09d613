//! JSON Schema of the lines that `bench run --json` writes.

use serde_json::{Map, Value, json};

/// Name of the event, what it says, its fields with their types.
struct Shape {
    event: &'static str,
    doc: &'static str,
    fields: &'static [(&'static str, Type)],
}

/// What stands in a field.
#[derive(Clone, Copy)]
enum Type {
    Text,
    /// A text, or null.
    Maybe,
    Count,
    Seconds,
    Code,
    /// Objects whose fields are all texts.
    Texts(&'static [&'static str]),
    /// Parts of a result for a person.
    Parts,
}

const fn shape(event: &'static str, doc: &'static str, fields: &'static [(&'static str, Type)]) -> Shape {
    Shape { event, doc, fields }
}

use Type::{Code, Count, Maybe, Parts, Seconds, Text, Texts};

#[rustfmt::skip]
const SHAPES: &[Shape] = &[
    shape("run-started", "The run begins.", &[("campaign", Text), ("rig", Text), ("unit", Text), ("procedures", Count), ("planned_s", Seconds), ("folder", Text)]),
    shape("procedure-started", "A procedure begins.", &[("procedure", Text), ("points", Count)]),
    shape("point-started", "A point begins; `number` counts from 1.", &[("procedure", Text), ("point", Text), ("number", Count), ("points", Count), ("planned_s", Seconds)]),
    shape("point-ended", "A point ended.", &[("procedure", Text), ("point", Text), ("status", Text), ("planned_s", Seconds), ("reason", Maybe)]),
    shape("procedure-ended", "A procedure ended and was judged by its own log; the final verdicts follow at the end of the run.", &[("procedure", Text), ("status", Text), ("planned_s", Seconds), ("verdicts", Texts(&["requirement", "verdict"]))]),
    shape("notice", "Information for the operator.", &[("text", Text)]),
    shape("result", "The result in words.", &[("parts", Parts)]),
    shape("question", "A question to the operator.", &[("text", Text)]),
    shape("answered", "A question was answered.", &[("asked_by", Text), ("prompt", Text), ("answer", Text), ("by", Text)]),
    shape("run-ended", "The run is over: overall verdict, exit code, and the shortfalls that prevent a pass.", &[("overall", Text), ("exit_code", Code), ("counts", Text), ("shortfalls", Texts(&["requirement", "verdict", "why", "place"])), ("report", Maybe)]),
];

/// Schema of one line.
pub fn schema() -> Value {
    let variants: Vec<Value> = SHAPES.iter().map(variant).collect();
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "A line of `bench run --json`",
        "oneOf": variants,
    })
}

fn variant(shape: &Shape) -> Value {
    let when = [
        (
            "utc",
            json!({ "type": "string", "format": "date-time", "description": "When the line was written." }),
        ),
        (
            "elapsed_s",
            json!({ "type": "number", "minimum": 0, "description": "Time since the program began, s." }),
        ),
        ("event", json!({ "const": shape.event })),
    ];
    let own = shape.fields.iter().map(|(name, of)| (*name, of.schema()));
    let properties: Map<String, Value> =
        when.into_iter().chain(own).map(|(name, of)| (name.to_owned(), of)).collect();
    let required: Vec<&String> = properties.keys().collect();
    json!({
        "type": "object",
        "description": shape.doc,
        "required": required,
        "properties": properties,
        "additionalProperties": false,
    })
}

impl Type {
    fn schema(self) -> Value {
        match self {
            Self::Text => json!({ "type": "string" }),
            Self::Maybe => json!({ "type": ["string", "null"] }),
            Self::Count => json!({ "type": "integer", "minimum": 0 }),
            Self::Seconds => json!({ "type": "number", "minimum": 0, "description": "s" }),
            Self::Code => json!({ "type": "integer", "minimum": 0, "maximum": 255 }),
            Self::Texts(fields) => {
                let properties: Map<String, Value> =
                    fields.iter().map(|name| ((*name).to_owned(), json!({ "type": "string" }))).collect();
                json!({ "type": "array", "items": object(fields, properties) })
            }
            Self::Parts => {
                let mut properties = Map::new();
                properties.insert("text".to_owned(), json!({ "type": "string" }));
                properties.insert("verdict".to_owned(), json!({ "type": ["string", "null"] }));
                json!({ "type": "array", "items": object(&["text", "verdict"], properties) })
            }
        }
    }
}

fn object(required: &[&str], properties: Map<String, Value>) -> Value {
    json!({ "type": "object", "required": required, "properties": properties, "additionalProperties": false })
}

#[cfg(test)]
mod tests {
    use boon::{Compiler, Schemas};
    use procedures::verdict::Verdict;

    use super::*;
    use crate::people::event::{FirstVerdict, Part, RunEvent, Shortfall, Shown};

    fn text() -> String {
        "text".to_owned()
    }

    fn one_of_each() -> Vec<RunEvent> {
        let verdicts = vec![FirstVerdict { requirement: text(), verdict: text() }];
        let shortfalls = vec![Shortfall { requirement: text(), verdict: text(), why: text(), place: text() }];
        vec![
            RunEvent::RunStarted {
                campaign: text(),
                rig: text(),
                unit: text(),
                procedures: 2,
                planned_s: 1.5,
                folder: text(),
            },
            RunEvent::ProcedureStarted { procedure: text(), points: 3 },
            RunEvent::PointStarted { procedure: text(), point: text(), number: 1, points: 3, planned_s: 1.0 },
            RunEvent::PointEnded {
                procedure: text(),
                point: text(),
                status: text(),
                planned_s: 1.0,
                reason: None,
            },
            RunEvent::ProcedureEnded { procedure: text(), status: text(), planned_s: 3.0, verdicts },
            RunEvent::Notice { text: text() },
            RunEvent::Result { parts: vec![Part::coloured("FAIL", Verdict::Fail), Part::plain("text")] },
            RunEvent::Question { text: text(), shown: Shown::default() },
            RunEvent::Answered { asked_by: text(), prompt: text(), answer: text(), by: text() },
            RunEvent::RunEnded { overall: text(), exit_code: 1, counts: text(), shortfalls, report: None },
        ]
    }

    fn fits(value: &Value, schema: &Value) -> bool {
        let mut compiler = Compiler::new();
        compiler.add_resource("shape.json", schema.clone()).expect("a schema");
        let mut schemas = Schemas::new();
        let index = compiler.compile("shape.json", &mut schemas).expect("a schema without mistakes");
        schemas.validate(value, index).is_ok()
    }

    #[test]
    fn every_event_fits_one_shape_of_the_schema_and_every_shape_has_an_event() {
        let schema = schema();
        let shapes = schema["oneOf"].as_array().expect("shapes");
        let events = one_of_each();
        assert_eq!(events.len(), shapes.len());
        for (event, shape) in events.iter().zip(shapes) {
            let mut line = serde_json::to_value(event).expect("an event has a JSON form");
            line["utc"] = json!("2026-01-01T00:00:00Z");
            line["elapsed_s"] = json!(0.5);
            assert!(fits(&line, shape), "{line} {shape}");
            assert_eq!(shapes.iter().filter(|shape| fits(&line, shape)).count(), 1, "{line}");
            line["more"] = json!(1);
            assert!(!fits(&line, shape), "a field that the schema does not know");
        }
    }
}
