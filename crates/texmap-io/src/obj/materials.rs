//! The materials of a model: its libraries, the names that none of them defines, and the maps of each.

use std::collections::HashSet;
use std::path::Path;

use texmap_sample::UvTransform;

use super::mtl::{self, Description};
use super::read::Obj;
use super::{Map, Material, Pbr, ReliefKind};
use crate::IoError;
use crate::error::shortened;
use crate::scene_file::Missing;
use crate::textures::{Content, MapSource, Textures};

pub(super) fn libraries(
    path: &Path,
    obj: &Obj,
    missing: Missing,
    textures: &mut Textures,
    warnings: &mut Vec<String>,
) -> Result<Vec<Description>, IoError> {
    let mut materials = Vec::new();
    for (location, name) in &obj.libraries {
        // A name may hold blanks, and a line may hold several names.
        let names: Vec<String> = if textures.source.exists(&textures.source.beside(path, name)) {
            vec![name.clone()]
        } else if let Some(found) = textures.found(location, name, warnings) {
            vec![found]
        } else {
            let here = |name: &str| {
                let found = textures.found(location, name, warnings);
                found.unwrap_or_else(|| name.to_owned())
            };
            name.split_whitespace().map(here).collect()
        };
        for name in names {
            let library = textures.source.beside(path, &name);
            match mtl::read(&library, location, textures, warnings) {
                Ok(read) => materials.extend(read),
                Err(error @ IoError::FileMissing { .. })
                    if missing.is_lenient() || textures.tolerant =>
                {
                    textures.note(&library, location, Err(error.to_string()));
                    warnings.push(format!("{error}: its materials are left out"));
                }
                Err(error @ (IoError::NotAFile { .. } | IoError::OutsideRoot { .. }))
                    if textures.tolerant =>
                {
                    textures.note(&library, location, Err(error.to_string()));
                }
                Err(error) => return Err(error),
            }
        }
    }
    Ok(materials)
}

pub(super) fn check_names(
    obj: &Obj,
    descriptions: &[Description],
    lenient: bool,
    warnings: &mut Vec<String>,
) -> Result<(), IoError> {
    let defined: HashSet<&str> = descriptions.iter().map(|d| d.name.as_str()).collect();
    let mut told: HashSet<&str> = HashSet::new();
    for (location, name) in &obj.materials {
        if defined.contains(name.as_str()) || !told.insert(name) {
            continue;
        }
        let error = IoError::UnknownMaterial {
            location: location.clone(),
            name: name.clone(),
        };
        // A model that names no library at all uses material names as group names.
        if !(lenient || obj.libraries.is_empty()) {
            return Err(error);
        }
        warnings.push(error.to_string());
    }
    Ok(())
}

/// Finds the maps of all materials, and decodes them at once.
pub(crate) fn decode_maps(
    descriptions: &mut [Description],
    textures: &mut Textures,
    warnings: &mut Vec<String>,
) {
    for map in descriptions
        .iter_mut()
        .flat_map(|d| d.maps.iter_mut())
        .flatten()
    {
        if let Some(found) = textures.found(&map.location, &map.name, warnings) {
            map.name = found;
        }
    }
    let maps = descriptions
        .iter()
        .flat_map(|d| d.maps.iter().zip(CONTENTS));
    let wanted = maps.filter_map(|(map, content)| {
        let map = map.as_ref()?;
        let path = textures.source.beside(&map.location.file, &map.name);
        Some((path, map.location.clone(), content))
    });
    let wanted = wanted.collect();
    textures.decode_ahead(wanted);
}

/// Content of each of [`mtl::MAPS`].
const CONTENTS: [Content; mtl::MAPS.len()] = [
    Content::Color,
    Content::Data,
    Content::Color,
    Content::Color,
    Content::Data,
    Content::Data,
    Content::Data,
    Content::Data,
    Content::Color,
    Content::Data,
    Content::Data,
    Content::Data,
    Content::Data,
    Content::Data,
];

/// The material of a description, its maps loaded.
pub(crate) fn material(
    description: Description,
    missing: Missing,
    textures: &mut Textures,
    warnings: &mut Vec<String>,
) -> Result<Material, IoError> {
    let numbers = description.numbers;
    let mut load = |map: Option<mtl::Map>, content| {
        map.map(|map| {
            let path = textures.source.beside(&map.location.file, &map.name);
            let texture = textures.load(&path, &map.location, content, missing)?;
            Ok(placed(&map, texture))
        })
        .transpose()
    };
    let name = description.name;
    let [
        map_kd,
        map_d,
        map_ka,
        map_ks,
        map_ns,
        bump,
        normals,
        disp,
        map_ke,
        map_pr,
        map_pm,
        map_ps,
        map_pc,
        map_pcr,
    ] = description.maps;
    let height = bump.as_ref().and_then(|map| map.height);
    let map_kd = load(map_kd, Content::Color)?;
    let map_d = load(map_d, Content::Data)?;
    let map_ka = load(map_ka, Content::Color)?;
    let map_ks = load(map_ks, Content::Color)?;
    let map_ns = load(map_ns, Content::Data)?;
    let map_ke = load(map_ke, Content::Color)?;
    let bump = load(bump, Content::Data)?;
    let relief = load(normals, Content::Data)?
        .map(|map| (map, ReliefKind::Normals))
        .or(bump.map(|map| (map, ReliefKind::Bump(height.unwrap_or(DEFAULT_BUMP)))));
    let rise = disp.as_ref().and_then(|map| map.height);
    let displacement = load(disp, Content::Data)?.map(|map| (map, rise.unwrap_or(DEFAULT_BUMP)));
    let layers = [map_ps, map_pc, map_pcr].map(|map| load(map, Content::Data));
    let pbr = pbr(
        numbers,
        [map_pr, map_pm],
        layers,
        missing,
        textures,
        warnings,
    )?;
    let ke = match (description.ke, &map_ke) {
        // As beside map_Kd: a black factor stands for none.
        (Some([0.0, 0.0, 0.0]), Some(_)) => {
            warnings.push(format!(
                "material '{}': Ke is black and would hide map_Ke; drawn as white",
                shortened(&name)
            ));
            [1.0; 3]
        }
        (Some(ke), _) => ke,
        (None, Some(_)) => [1.0; 3],
        (None, None) => [0.0; 3],
    };
    let kd = match (description.kd, &map_kd) {
        // Programs that ignore Kd beside a map often write black, which would blacken the map.
        (Some([0.0, 0.0, 0.0]), Some(_)) => {
            warnings.push(format!(
                "material '{}': Kd is black and would hide map_Kd; drawn as white",
                shortened(&name)
            ));
            [1.0; 3]
        }
        (Some(kd), _) => kd,
        (None, Some(_)) => [1.0; 3],
        (None, None) => [0.8; 3],
    };
    Ok(Material {
        name,
        kd,
        ks: description.ks,
        ns: description.ns.unwrap_or(5.0),
        opacity: description.d,
        map_kd,
        map_d,
        map_ka,
        map_ks,
        map_ns,
        ke,
        map_ke,
        relief,
        displacement,
        pbr,
    })
}

/// A texture under the options of its line.
fn placed(map: &mtl::Map, texture: usize) -> Map {
    Map {
        texture,
        transform: UvTransform {
            offset: map.offset,
            scale: map.scale,
            rotation: 0.0,
        },
        clamp: map.clamp,
    }
}

/// The metallic-roughness model of a material that has some word of it: its numbers, the maps of roughness and metalness, and those of
/// sheen, clear coat and its roughness.
fn pbr(
    numbers: [Option<f32>; mtl::NUMBERS.len()],
    packed: [Option<mtl::Map>; 2],
    layers: [Result<Option<Map>, IoError>; 3],
    missing: Missing,
    textures: &mut Textures,
    warnings: &mut Vec<String>,
) -> Result<Option<Pbr>, IoError> {
    let [sheen_map, coat_map, coat_roughness_map] = layers;
    let (sheen_map, coat_map, coat_roughness_map) = (sheen_map?, coat_map?, coat_roughness_map?);
    let map = roughness_and_metalness(&packed, missing, textures, warnings)?;
    let layers = [&sheen_map, &coat_map, &coat_roughness_map];
    let mapped = map.is_some() || layers.iter().any(|map| map.is_some());
    if !mapped && numbers.iter().all(Option::is_none) {
        return Ok(None);
    }
    let [roughness, metallic, sheen, coat, coat_roughness] = numbers;
    let [map_pr, map_pm] = packed.map(|map| map.is_some());
    let number = |mapped: bool, number: Option<f32>| match mapped {
        true => 1.0,
        false => number.unwrap_or(0.0),
    };
    Ok(Some(Pbr {
        roughness: if map_pr { Some(1.0) } else { roughness },
        metallic: number(map_pm, metallic),
        sheen: number(sheen_map.is_some(), sheen),
        coat: number(coat_map.is_some(), coat),
        coat_roughness: number(coat_roughness_map.is_some(), coat_roughness),
        map,
        sheen_map,
        coat_map,
        coat_roughness_map,
    }))
}

/// One texture of the maps of roughness and metalness, which have the options of the first.
fn roughness_and_metalness(
    maps: &[Option<mtl::Map>; 2],
    missing: Missing,
    textures: &mut Textures,
    warnings: &mut Vec<String>,
) -> Result<Option<Map>, IoError> {
    if let [Some(a), Some(b)] = maps
        && placed(a, 0) != placed(b, 0)
    {
        warnings.push(format!(
            "{}: map_Pm has other options than map_Pr at line {}, whose options are taken for both",
            b.location, a.location.line
        ));
    }
    let sources = maps.each_ref().map(|map| {
        map.as_ref().map(|map| MapSource {
            path: textures.source.beside(&map.location.file, &map.name),
            location: map.location.clone(),
        })
    });
    let Some(first) = maps.iter().flatten().next() else {
        return Ok(None);
    };
    let texture = textures.load_packed(sources, missing)?;
    Ok(Some(placed(first, texture)))
}

/// Height of a bump or displacement without `-bm`, units of the model.
const DEFAULT_BUMP: f32 = 0.02;
