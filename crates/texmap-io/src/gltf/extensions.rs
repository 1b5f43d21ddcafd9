//! The extensions of glTF and their treatment.

use super::json::Document;
use super::model::Model;
use crate::{IoError, info::ExtensionInfo};

/// Treatment of an extension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Support {
    /// Read.
    Full,
    /// Left out or approximated: the file is drawn with this sentence as a warning.
    Partial(&'static str),
    /// Data that cannot be decoded, and the command that converts it.
    Encoded(&'static str),
}

pub(super) const DECODE: &str =
    "decode it with `npx @gltf-transform/cli copy IN.glb OUT.glb`, which drops this compression";
pub(super) const PICTURES: &str =
    "convert its pictures with `npx @gltf-transform/cli ktxdecompress IN.glb OUT.glb`";

/// Every extension that is known, by name.
pub(super) const KNOWN: [(&str, Support); 31] = {
    use Support::{Encoded, Full, Partial};
    [
        (
            "EXT_lights_image_based",
            Partial("its environment is not read"),
        ),
        ("EXT_mesh_gpu_instancing", Full),
        ("EXT_meshopt_compression", Full),
        (
            "EXT_texture_avif",
            Encoded("convert its pictures with `npx @gltf-transform/cli png IN.glb OUT.glb`"),
        ),
        ("EXT_texture_webp", Full),
        ("KHR_draco_mesh_compression", Encoded(DECODE)),
        ("KHR_lights_punctual", Full),
        (
            "KHR_materials_anisotropy",
            Partial("highlights are drawn round"),
        ),
        ("KHR_materials_clearcoat", Full),
        (
            "KHR_materials_diffuse_transmission",
            Partial("surfaces are drawn opaque to light from behind"),
        ),
        (
            "KHR_materials_dispersion",
            Partial("light is not split into colours"),
        ),
        ("KHR_materials_emissive_strength", Full),
        ("KHR_materials_ior", Full),
        (
            "KHR_materials_iridescence",
            Partial("thin films are drawn without their colours"),
        ),
        (
            "KHR_materials_pbrSpecularGlossiness",
            Partial("it is drawn as metallic-roughness"),
        ),
        ("KHR_materials_sheen", Full),
        ("KHR_materials_specular", Full),
        (
            "KHR_materials_transmission",
            Partial("glass is drawn as thin sheets, which pass grey light and do not refract it"),
        ),
        ("KHR_materials_unlit", Full),
        (
            "KHR_materials_variants",
            Partial("the default materials are drawn"),
        ),
        (
            "KHR_materials_volume",
            Partial("light is coloured at the surface and not refracted"),
        ),
        ("KHR_mesh_quantization", Full),
        ("KHR_meshopt_compression", Full),
        (
            "KHR_animation_pointer",
            Partial("only nodes and weights are animated"),
        ),
        ("KHR_node_visibility", Full),
        ("KHR_texture_basisu", Encoded(PICTURES)),
        ("KHR_texture_transform", Full),
        ("KHR_xmp_json_ld", Full),
        ("KHR_xmp", Full),
        ("MSFT_lod", Partial("the finest level is drawn")),
        (
            "MSFT_texture_dds",
            Partial("the plain pictures beside its own are drawn"),
        ),
    ]
};

/// Treatment of the extension of this name, if it is known.
pub(super) fn support(name: &str) -> Option<Support> {
    KNOWN
        .iter()
        .find(|(known, _)| *known == name)
        .map(|(_, support)| *support)
}

/// Refuses files that cannot be drawn without an extension that is not read; warns of others.
pub(super) fn check(model: &mut Model<'_>) -> Result<(), IoError> {
    for (i, name) in model.document.extensions_required.iter().enumerate() {
        let help = match support(name) {
            Some(Support::Full | Support::Partial(_)) => continue,
            Some(Support::Encoded(command)) => command.to_owned(),
            None => "the file says that it cannot be read without; export it again without this extension, or drop it with `npx @gltf-transform/cli`".to_owned(),
        };
        return Err(model.unsupported(&format!("/extensionsRequired/{i}"), name, help));
    }
    let used = &model.document.extensions_used;
    let unknown: Vec<&str> = used
        .iter()
        .map(String::as_str)
        .filter(|n| support(n).is_none())
        .collect();
    let mut warnings: Vec<String> = used
        .iter()
        .filter_map(|name| match support(name) {
            Some(Support::Partial(what)) if in_use(&model.document, name) => {
                Some(format!("{name}: {what}"))
            }
            _ => None,
        })
        .collect();
    if let Some((first, rest)) = unknown.split_first() {
        let names = rest
            .iter()
            .take(4)
            .fold(String::from(*first), |list, name| list + ", " + name);
        let more = if rest.len() > 4 { ", ..." } else { "" };
        let n = unknown.len();
        let s = if n == 1 { "" } else { "s" };
        warnings.push(format!(
            "{n} optional extension{s} left out: {}{more}",
            crate::shortened(&names)
        ));
    }
    for warning in warnings {
        model.warn(warning);
    }
    Ok(())
}

/// True if a named extension is used by a part of the file. Exporters name some for no reason.
fn in_use(document: &Document, name: &str) -> bool {
    let material = |has: fn(&super::json::MaterialExtensions) -> bool| {
        document.materials.iter().any(|m| has(&m.extensions))
    };
    match name {
        "KHR_materials_anisotropy" => material(|e| e.anisotropy.is_some()),
        "KHR_materials_diffuse_transmission" => material(|e| e.diffuse_transmission.is_some()),
        "KHR_materials_dispersion" => material(|e| e.dispersion.is_some()),
        "KHR_materials_iridescence" => material(|e| e.iridescence.is_some()),
        "KHR_materials_pbrSpecularGlossiness" => material(|e| e.glossiness.is_some()),
        "KHR_materials_transmission" => material(|e| e.transmission.is_some()),
        "KHR_materials_volume" => material(|e| e.volume.is_some()),
        "KHR_materials_variants" => document
            .meshes
            .iter()
            .flat_map(|m| &m.primitives)
            .any(|p| p.extensions.variants.is_some()),
        "KHR_animation_pointer" => document.animations.iter().any(|animation| {
            let mut channels = animation.channels.iter();
            channels.any(|channel| channel.target.path == "pointer")
        }),
        _ => true,
    }
}

/// The command that converts a file without the use of a known extension.
pub(super) fn instead(name: &str) -> String {
    match support(name) {
        Some(Support::Encoded(command)) => command.to_owned(),
        _ => "export the model again without it".to_owned(),
    }
}

/// The extensions that a file names, for a report.
pub(super) fn report(document: &Document) -> Vec<ExtensionInfo> {
    let line = |name: &String| ExtensionInfo {
        name: crate::shortened(name).to_string(),
        required: document.extensions_required.contains(name),
        support: match support(name) {
            Some(Support::Full) => "read",
            Some(Support::Partial(what)) => what,
            Some(Support::Encoded(_)) => "not decoded",
            None => "left out",
        },
    };
    document.extensions_used.iter().map(line).collect()
}
