//! Checks JSON against the schemas in `schemas/`: as much of JSON Schema as those use, and a panic
//! at any keyword beyond.

use serde_json::Value;

pub(crate) const DETECT: &str = include_str!("../../../schemas/detect.schema.json");
pub(crate) const SCAN: &str = include_str!("../../../schemas/scan.schema.json");
pub(crate) const TIMING: &str = include_str!("../../../schemas/timing.schema.json");
pub(crate) const DECODE: &str = include_str!("../../../schemas/decode.schema.json");

pub(crate) const ADAPTERS: &str = include_str!("../../../schemas/adapters.schema.json");

#[allow(dead_code, reason = "the tests of the command alone look at it")]
pub(crate) const SIMULATE: &str = include_str!("../../../schemas/simulate.schema.json");

#[allow(dead_code, reason = "the tests of the command alone look at it")]
pub(crate) const LSS: &str = include_str!("../../../schemas/lss.schema.json");

/// Panics with the place and the reason if `value` does not fit.
pub(crate) fn assert_valid(schema: &str, value: &Value) {
    let root: Value = serde_json::from_str(schema).unwrap();
    if let Err(reason) = check(&root, &root, value, "$") {
        panic!("{reason}\nin {value}");
    }
}

fn check(root: &Value, schema: &Value, value: &Value, at: &str) -> Result<(), String> {
    for (keyword, rule) in schema.as_object().unwrap() {
        let fits = match keyword.as_str() {
            "$schema" | "$defs" | "title" | "description" => true,
            "$ref" => {
                let name = rule.as_str().unwrap().strip_prefix("#/$defs/").unwrap();
                check(root, &root["$defs"][name], value, at)?;
                true
            }
            "oneOf" => {
                let tries: Vec<_> = rule
                    .as_array()
                    .unwrap()
                    .iter()
                    .map(|option| check(root, option, value, at))
                    .collect();
                if tries.iter().filter(|t| t.is_ok()).count() != 1 {
                    return Err(format!("{at}: not exactly one of: {tries:?}"));
                }
                true
            }
            "type" => match rule {
                Value::Array(types) => types.iter().any(|t| is_type(value, t)),
                one => is_type(value, one),
            },
            "enum" => rule.as_array().unwrap().contains(value),
            "minimum" => value.as_f64().is_none_or(|v| v >= rule.as_f64().unwrap()),
            "maximum" => value.as_f64().is_none_or(|v| v <= rule.as_f64().unwrap()),
            "required" => rule
                .as_array()
                .unwrap()
                .iter()
                .all(|key| value.get(key.as_str().unwrap()).is_some()),
            "properties" => {
                for (key, rule) in rule.as_object().unwrap() {
                    if let Some(inner) = value.get(key) {
                        check(root, rule, inner, &format!("{at}.{key}"))?;
                    }
                }
                true
            }
            "additionalProperties" => {
                assert_eq!(rule, false);
                value.as_object().is_none_or(|object| {
                    object.keys().all(|key| schema["properties"].get(key).is_some())
                })
            }
            "items" => {
                for (index, inner) in value.as_array().into_iter().flatten().enumerate() {
                    check(root, rule, inner, &format!("{at}[{index}]"))?;
                }
                true
            }
            other => panic!("the schema uses {other:?}, which is not checked here"),
        };
        if !fits {
            return Err(format!("{at}: {keyword} {rule} does not fit {value}"));
        }
    }
    Ok(())
}

fn is_type(value: &Value, name: &Value) -> bool {
    match name.as_str().unwrap() {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "string" => value.is_string(),
        "integer" => value.is_u64() || value.is_i64(),
        "number" => value.is_number(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        other => panic!("unknown type {other:?}"),
    }
}

#[test]
fn the_checker_refuses_what_does_not_fit() {
    let root: Value = serde_json::from_str(DECODE).unwrap();
    let mut good = serde_json::json!({
        "t": 0.5, "id": 1, "extended": false, "remote": false, "fd": false, "brs": false,
        "esi": false, "dlc": 0, "data": "", "ack": true, "kind": "data", "error": null,
        "field": null, "error_t": null
    });
    assert_eq!(check(&root, &root, &good, "$"), Ok(()));
    for (key, wrong) in [("kind", "fd".into()), ("dlc", 16.into()), ("ack", "yes".into())] {
        let mut bad = good.clone();
        bad[key] = wrong;
        assert!(check(&root, &root, &bad, "$").is_err(), "{key}");
    }
    good["extra"] = 1.into();
    assert!(check(&root, &root, &good, "$").is_err());
    good.as_object_mut().unwrap().remove("extra");
    good.as_object_mut().unwrap().remove("t");
    assert!(check(&root, &root, &good, "$").is_err());
}
