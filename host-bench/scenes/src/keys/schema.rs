//! A JSON Schema of scene files, by which editors complete and check them.

use serde_json::{Map, Value as Json, json};

use crate::scene_file::KEYS;
use crate::scene_file::key::{Default, Key, Kind, Table, Value};

/// The schema (draft 7). It cannot state a bound by other keys, nor infinity: the reader refuses more.
pub fn schema() -> Json {
    let shared: Map<String, Json> = KEYS.keys.iter().map(|key| (key.name.to_owned(), value(key))).collect();
    let scenes: Vec<Json> = KEYS.kinds.iter().map(|kind| object(&KEYS, Some(kind), &reference)).collect();
    json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "Scene file of a vibration energy harvester",
        "oneOf": scenes,
        "definitions": shared,
    })
}

/// A key of every scene, which is defined once.
fn reference(key: &Key) -> Json {
    if KEYS.keys.iter().any(|shared| std::ptr::eq(shared, key)) {
        json!({ "$ref": format!("#/definitions/{}", key.name) })
    } else {
        value(key)
    }
}

fn table(of: &'static Table) -> Json {
    if of.kinds.is_empty() {
        return object(of, None, &value);
    }
    let kinds: Vec<Json> = of.kinds.iter().map(|kind| object(of, Some(kind), &value)).collect();
    json!({ "oneOf": kinds })
}

fn object(of: &'static Table, kind: Option<&'static Kind>, value: &dyn Fn(&Key) -> Json) -> Json {
    let mut properties = Map::new();
    let mut required = Vec::new();
    let mut rules = Vec::new();
    if let Some(kind) = kind {
        properties.insert(of.selector.to_owned(), json!({ "const": kind.word, "description": kind.meaning }));
        required.push(of.selector);
    }
    for key in kind.map_or(&[][..], |kind| kind.keys).iter().chain(of.keys) {
        properties.insert(key.name.to_owned(), value(key));
        match (key.default, key.instead_of) {
            (Default::Required, None) => required.push(key.name),
            // The pair is stated with the first of the two.
            (_, Some(other)) if properties.contains_key(other) => {}
            (Default::Required, Some(other)) => {
                rules.push(json!({ "oneOf": [{ "required": [key.name] }, { "required": [other] }] }));
            }
            (_, Some(other)) => rules.push(json!({ "not": { "required": [key.name, other] } })),
            _ => {}
        }
    }
    let mut object = json!({
        "type": "object",
        "additionalProperties": false,
        "properties": properties,
        "required": required,
    });
    if let Some(kind) = kind {
        object["description"] = json!(kind.meaning);
    }
    if !rules.is_empty() {
        object["allOf"] = json!(rules);
    }
    object
}

fn value(key: &Key) -> Json {
    let number = |kind: &str, range: model_core::bounds::Bounds<f64>| {
        let mut number = json!({ "type": kind });
        for (name, bound) in [("minimum", range.lowest), ("maximum", range.highest)] {
            if bound.is_finite() {
                number[name] = short(bound);
            }
        }
        number
    };
    let mut schema = match key.value {
        Value::Number(range) => number("number", range),
        Value::Whole(range) => number("integer", range),
        Value::NumberOrLimits(range) => {
            json!({ "type": "number", "anyOf": [{ "const": 0 }, { "minimum": short(range.lowest) }] })
        }
        Value::Among(numbers) => json!({ "enum": numbers }),
        Value::Numbers(range, _) => json!({ "type": "array", "items": number("number", range) }),
        Value::Points(_, most) => json!({
            "type": "array", "minItems": 2, "maxItems": most,
            "items": { "type": "array", "minItems": 2, "maxItems": 2, "items": { "type": "number" } },
        }),
        Value::Words(words) => json!({ "enum": words }),
        Value::Part(words) => json!({ "enum": words() }),
        Value::Flag => json!({ "type": "boolean" }),
        Value::Text => json!({ "type": "string" }),
        Value::Texts => json!({ "type": "array", "items": { "type": "string" } }),
        Value::FreeKeys => json!({
            "anyOf": [{ "type": "array", "items": { "type": "string" } }, { "type": "object" }],
        }),
        Value::Column(range) => json!({ "anyOf": [{ "type": "string" }, number("integer", range)] }),
        Value::ColumnOrFalse(range) => {
            json!({ "anyOf": [{ "type": "string" }, number("integer", range), { "const": false }] })
        }
        Value::Table(of) => table(of),
        Value::Tables(of) => json!({ "type": "array", "minItems": 1, "items": table(of) }),
    };
    let unit = if key.unit.is_empty() { String::new() } else { format!(" in {}", key.unit) };
    let said = match key.default {
        Default::Said(text) => format!(" Default: {text}."),
        _ => String::new(),
    };
    let text = format!("{}{unit}. Value: {}.{said}", key.meaning, key.bounds());
    schema["description"] = json!(text.replace('`', ""));
    match key.default {
        Default::Number(number) => schema["default"] = short(number),
        Default::Flag(flag) => schema["default"] = json!(flag),
        Default::Required | Default::Said(_) => {}
    }
    schema
}

/// A number, as an integer where it is one that is short.
fn short(number: f64) -> Json {
    if number.fract() == 0.0 && number.abs() <= 4_294_967_295.0 {
        json!(number as i64)
    } else {
        json!(number)
    }
}
