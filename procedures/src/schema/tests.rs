use super::*;
use crate::procedure::sample::SAMPLE_KINDS;

#[test]
fn a_procedure_schema_holds_the_common_keys_and_those_of_its_kind() {
    insta::assert_json_snapshot!(procedure_schema(&SAMPLE_KINDS[0]));
}

#[test]
fn campaign_and_requirements_schemas_refuse_other_keys_and_name_the_required_ones() {
    for (schema, required) in [
        (campaign_schema(), json!(["schema", "id", "title", "requirements", "procedure"])),
        (requirements_schema(), json!(["schema", "requirement"])),
    ] {
        assert_eq!(schema["required"], required);
        assert_eq!(schema["additionalProperties"], json!(false));
        assert_eq!(schema["$schema"], json!(DRAFT));
    }
    let judge = &requirements_schema()["properties"]["requirement"]["items"]["properties"]["judge"]["items"];
    assert_eq!(judge["required"], json!(["measurand"]));
    let points = &campaign_schema()["properties"]["procedure"]["items"]["properties"]["points"];
    assert!(points["properties"]["velocity"]["anyOf"].is_array(), "one text or a list: {points}");
    assert_eq!(points["additionalProperties"], json!(false), "only conditions");
}

#[test]
fn every_key_of_every_kind_is_described() {
    for kind in crate::kinds::KINDS {
        let schema = procedure_schema(kind);
        assert_eq!(schema["properties"]["kind"]["const"], json!(kind.name));
        for (key, property) in schema["properties"].as_object().expect("an object") {
            assert!(property["description"].as_str().is_some_and(|d| !d.is_empty()), "{} {key}", kind.name);
        }
    }
}
