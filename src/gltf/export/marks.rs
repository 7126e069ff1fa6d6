//! Says in the file's `extras` what was baked, for whoever loads it.

use serde_json::{Map, Value, json};

use super::{
    ExportOptions, LightEncoding,
    glb::{Glb, object_mut},
};
use crate::{gltf::GltfError, radiosity::DirectLight};

/// The key of everything this crate writes into `extras`.
const KEY: &str = "fresco";

/// Marks the asset and its lights.
pub(super) fn mark(
    glb: &mut Glb,
    light_nodes: &[usize],
    options: &ExportOptions,
    directional: bool,
) -> Result<(), GltfError> {
    let direct = match options.direct {
        DirectLight::Baked => "baked",
        DirectLight::Realtime => "realtime",
    };
    let mut asset = json!({
        "baked_light": "irradiance_over_pi",
        "version": env!("CARGO_PKG_VERSION"),
        "direct": direct,
    });
    match options.encoding {
        LightEncoding::Attribute => {
            asset["encoding"] = "attribute".into();
            if directional {
                asset["directional"] = true.into();
            }
        }
        LightEncoding::VertexColors { exposure } => {
            asset["encoding"] = "vertex_colors".into();
            asset["exposure"] = exposure.into();
        }
    }
    // What an earlier bake said of itself does not hold for this one.
    if let Some(extras) = glb
        .json
        .pointer_mut("/asset/extras")
        .and_then(Value::as_object_mut)
    {
        extras.shift_remove(KEY);
    }
    merge_extras(&mut glb.json["asset"], asset);
    for &node in light_nodes {
        if !glb.json["nodes"][node].is_object() {
            return Err(glb.refuse(format!("it has no light node {node}")));
        }
        merge_extras(&mut glb.json["nodes"][node], json!({"direct": direct}));
    }
    Ok(())
}

/// Adds to `extras.fresco`, keeping all else that `extras` holds.
fn merge_extras(owner: &mut Value, marks: Value) {
    let Some(owner) = owner.as_object_mut() else {
        return;
    };
    let extras = owner.entry("extras").or_insert_with(|| json!({}));
    if !extras.is_object() {
        *extras = json!({"fresco_previous_extras": extras.take()});
    }
    if !extras[KEY].is_object() {
        extras[KEY] = Map::new().into();
    }
    if let (Some(to), Value::Object(marks)) = (object_mut(extras, KEY), marks) {
        to.extend(marks);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gltf_extras_are_merged() {
        let cases = [
            (json!({}), json!({"fresco": {"a": 1}})),
            (
                json!({"extras": {"x": 2, "fresco": {"b": 3, "a": 0}}}),
                json!({"x": 2, "fresco": {"b": 3, "a": 1}}),
            ),
            (
                json!({"extras": 7}),
                json!({"fresco_previous_extras": 7, "fresco": {"a": 1}}),
            ),
            (
                json!({"extras": {"fresco": "mine"}}),
                json!({"fresco": {"a": 1}}),
            ),
        ];
        for (mut owner, expected) in cases {
            merge_extras(&mut owner, json!({"a": 1}));
            assert_eq!(owner["extras"], expected);
        }
    }
}
