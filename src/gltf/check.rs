//! From JSON to the typed document, refusing what would be dangerous or misleading to read.

use gltf::json::mesh::Semantic;
use gltf::json::validation::{Checked, Error as Fault, Validate};
use gltf::json::{Path as JsonPath, Root};
use serde_json::Value;

use super::notes::Notes;

/// Extensions a document may require: those that are read, and those that change nothing about
/// diffuse light between triangles.
const ACCEPTED: &[&str] = &[
    "KHR_animation_pointer",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_displacement",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_node_visibility",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
];

/// Members that hold indices. The typed document cuts them to 32 bits, which would make a wild
/// index a wrong one.
const INDEX_KEYS: &[&str] = &[
    "accessor",
    "buffer",
    "bufferView",
    "camera",
    "children",
    "index",
    "indices",
    "input",
    "inverseBindMatrices",
    "joints",
    "light",
    "material",
    "mesh",
    "node",
    "nodes",
    "output",
    "sampler",
    "scene",
    "skeleton",
    "skin",
    "source",
    "texCoord",
];

/// Reads JSON text as it is.
pub(super) fn parse(text: &[u8]) -> Result<Value, String> {
    let json: Value =
        serde_json::from_slice(text).map_err(|error| format!("its JSON is broken: {error}"))?;
    if !json.is_object() {
        return Err("its JSON is not an object".to_owned());
    }
    Ok(json)
}

/// The first extension that the document requires and that is not supported.
pub(super) fn unsupported_extension(json: &Value) -> Option<&str> {
    let required = json.get("extensionsRequired")?.as_array()?;
    let mut names = required.iter().filter_map(Value::as_str);
    names.find(|name| !ACCEPTED.contains(name))
}

/// The typed document, with all references checked.
pub(super) fn typed(text: &[u8], json: &Value, notes: &mut Notes) -> Result<Root, String> {
    check_version(json)?;
    check_index_sizes(json, "")?;
    let root = read_root(text, json)
        .map_err(|error| format!("its JSON does not say what glTF needs: {error}"))?;
    check_attributes(&root)?;
    check_rest(&root, notes)?;
    check_views(&root)?;
    Ok(root)
}

fn check_version(json: &Value) -> Result<(), String> {
    let asset = json.get("asset");
    let Some(version) = asset.and_then(|asset| asset.get("version")?.as_str()) else {
        return Err("asset.version is missing".to_owned());
    };
    if version != "2" && !version.starts_with("2.") {
        return Err(format!(
            "asset.version is {version}, only glTF 2.0 is supported"
        ));
    }
    match asset.and_then(|asset| asset.get("minVersion")?.as_str()) {
        Some(version) if version != "2.0" => Err(format!(
            "asset.minVersion is {version}, only glTF 2.0 is supported"
        )),
        _ => Ok(()),
    }
}

fn check_index_sizes(value: &Value, path: &str) -> Result<(), String> {
    let too_big = |value: &Value| value.as_u64().is_some_and(|n| n >= u64::from(u32::MAX));
    match value {
        Value::Object(members) => {
            for (key, member) in members.iter().filter(|(key, _)| *key != "extras") {
                let here = format!("{path}{}{key}", if path.is_empty() { "" } else { "." });
                let many = member.as_array().is_some_and(|all| all.iter().any(too_big));
                let index = INDEX_KEYS.contains(&key.as_str()) || path.ends_with(".attributes");
                if index && (many || too_big(member)) {
                    return Err(format!("{here} refers to an entry that does not exist"));
                }
                check_index_sizes(member, &here)?;
            }
            Ok(())
        }
        Value::Array(entries) if entries.iter().any(|e| e.is_object() || e.is_array()) => {
            let mut entries = entries.iter().enumerate();
            entries.try_for_each(|(i, entry)| check_index_sizes(entry, &format!("{path}[{i}]")))
        }
        _ => Ok(()),
    }
}

/// The `gltf` crate wants `nodes` in every scene, glTF does not.
fn read_root(text: &[u8], json: &Value) -> Result<Root, serde_json::Error> {
    let scenes = json.get("scenes").and_then(Value::as_array);
    let bare = |scene: &Value| scene.is_object() && scene.get("nodes").is_none();
    if !scenes.is_some_and(|scenes| scenes.iter().any(bare)) {
        return serde_json::from_slice(text);
    }
    let mut json = json.clone();
    let scenes = json.get_mut("scenes").and_then(Value::as_array_mut);
    for scene in scenes.into_iter().flatten().filter(|scene| bare(scene)) {
        scene["nodes"] = Value::Array(Vec::new());
    }
    serde_json::from_value(json)
}

/// The validator of the `gltf` crate looks positions up unchecked: this goes first.
fn check_attributes(root: &Root) -> Result<(), String> {
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            for (name, accessor) in &primitive.attributes {
                if accessor.value() >= root.accessors.len() {
                    return Err(format!(
                        "meshes[{m}].primitives[{p}].attributes.{} refers to accessor {accessor}, \
                         which does not exist",
                        name.to_string()
                    ));
                }
            }
        }
    }
    Ok(())
}

fn check_rest(root: &Root, notes: &mut Notes) -> Result<(), String> {
    let mut faults = Vec::new();
    root.validate(root, JsonPath::new, &mut |path, fault| {
        faults.push((path().0, fault));
    });
    let unknown = Checked::<Semantic>::Invalid.to_string();
    let mut serious = None;
    let mut others = 0;
    for (path, fault) in faults {
        if path.contains(&unknown) {
            notes.add(format!(
                "{} has an attribute whose name glTF does not know: it is ignored.",
                path.split(".attributes").next().unwrap_or_default()
            ));
        } else if !is_harmless(&path, fault) {
            others += usize::from(serious.is_some());
            serious.get_or_insert((path, fault));
        }
    }
    let Some((path, fault)) = serious else {
        return Ok(());
    };
    let what = match fault {
        Fault::IndexOutOfBounds => "refers to an entry that does not exist",
        Fault::Invalid => "has a value that glTF does not allow",
        Fault::Missing => "is missing",
        Fault::Oversize => "is too large for this machine",
        Fault::Unsupported => "is not supported",
    };
    let more = match others {
        0 => String::new(),
        n => format!(" (and {n} more)"),
    };
    Err(format!("{path} {what}{more}"))
}

/// What the validator of the `gltf` crate reports but import can do without, or looks after.
fn is_harmless(path: &str, fault: Fault) -> bool {
    let missing = fault == Fault::Missing;
    path.starts_with("extensionsRequired")
        // Noted where the primitive is read.
        || missing && path.ends_with("attributes[\"POSITION\"]")
        // Bounds are computed, not believed.
        || path.ends_with("attributes[\"POSITION\"].min")
        || path.ends_with("attributes[\"POSITION\"].max")
        // All zeros, says the specification.
        || missing && path.starts_with("accessors[") && path.ends_with("].bufferView")
        // The image is where an extension says; noted where the texture is used.
        || missing && path.starts_with("textures[") && path.ends_with("].source")
}

/// Every buffer view lies within its buffer.
fn check_views(root: &Root) -> Result<(), String> {
    for (index, view) in root.buffer_views.iter().enumerate() {
        let start = view.byte_offset.unwrap_or_default().0;
        let end = start.checked_add(view.byte_length.0);
        let buffer = view.buffer.value();
        let length = root.buffers.get(buffer).map_or(0, |b| b.byte_length.0);
        if end.is_none_or(|end| end > length) {
            return Err(format!(
                "bufferViews[{index}] has {} bytes from {start}, but buffers[{buffer}] has \
                 {length} bytes",
                view.byte_length.0
            ));
        }
    }
    Ok(())
}
