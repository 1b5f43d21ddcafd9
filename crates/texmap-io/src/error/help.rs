//! The second line of an error: the reason why a file is refused, and a remedy.

use super::{IoError, SourceLocation};

impl IoError {
    /// One line with the reason of the error and a remedy.
    pub fn help(&self) -> String {
        match self {
            Self::FileMissing { named_by: Some(_), .. } => "names are relative to the file that holds the line; put the file there or correct the line (for maps and material libraries, `missing warn` draws without them)".into(),
            Self::FileMissing { .. } => "check the spelling and the working directory".into(),
            Self::NotAFile { .. } => "name a file on a disk, not a directory, a pipe or a device".into(),
            Self::OutsideRoot { .. } => "reading is confined to one folder (--root): put the file there, and name it without links that lead out".into(),
            Self::Read { .. } => "check the permissions of the file".into(),
            Self::Write { .. } => "check that the directory exists and may be written; an older file of this name was left as it was".into(),
            Self::FileTooLarge { .. } => "split the file, or store the model or array in parts".into(),
            Self::NotUtf8 { .. } => "scene, OBJ and MTL files are UTF-8 text; convert the file (for example with iconv)".into(),
            Self::UnknownFormat { .. } => {
                let models = crate::scene::FORMATS.iter().map(|format| format.name);
                let images = crate::image_io::ENDINGS.iter().copied();
                format!("texmap reads {} files, and {} images", endings(models), endings(images))
            }
            Self::UnknownCommand { nearest: Some(nearest), .. } => format!("did you mean `{nearest}`? docs/SCENE_FORMAT.md lists the commands"),
            Self::UnknownCommand { .. } => "docs/SCENE_FORMAT.md lists the commands; `#` begins a comment".into(),
            Self::StrayNumber { .. } => "a line that begins with a number continues the command above it; begin with a command".into(),
            Self::ArgumentCount { .. } => "give as many values as the command takes; every command begins its own line".into(),
            Self::NotANumber { .. } => "write a decimal number such as 12, -0.5 or 1e-3".into(),
            Self::NotFinite { .. } => "NaN, infinities and magnitudes above 3.4e38 cannot be drawn; fix the exporter".into(),
            Self::OutOfRange { allowed, .. } => format!("allowed: {allowed}"),
            Self::UnknownWord { allowed, .. } => format!("allowed: {allowed}"),
            Self::StrayQuote { .. } => "quotes stand around a whole path: \"my file.png\"".into(),
            Self::BadIndex { location, count, .. } => index_help(location, *count),
            Self::TooFewCorners { .. } => "remove the face or give it its missing corners".into(),
            Self::MixedCorners { .. } => "write every corner of a face in the same form: v, v/vt, v//vn or v/vt/vn".into(),
            Self::NeedsAbove { command: "pop", .. } => "each `pop` closes a `push` of the same file; remove one or add the other".into(),
            Self::NeedsAbove { command: "name", .. } => "add the light, face or model before this line; `name` applies to the last one above".into(),
            Self::NeedsAbove { command: command @ "shadow", .. } => format!("add the light before this line; `{command}` applies to the nearest light above"),
            Self::NeedsAbove { needs, .. } => format!("add {needs} before this line"),
            Self::OpenPush { .. } => "close it with `pop`".into(),
            Self::IncludeCycle { .. } => "a file cannot contain itself; remove one of the `include` lines".into(),
            Self::DegenerateFrame { .. } => "give U and V two directions of the texture's plane, neither zero nor parallel".into(),
            Self::BadCamera { .. } => "eye and look must differ, up must not point along the line of sight, and 0 < near < far".into(),
            Self::BadProjector { .. } => "its position and look must differ, and up must not be zero or point along the line of projection".into(),
            Self::BrokenImage { .. } => format!("the file is damaged or of a kind that is not read; write it again ({})", endings(crate::image_io::ENDINGS.iter().copied())),
            Self::ImageLeftOut { feature, .. } => format!("build the program with `--features {feature}`, or write the image as .png"),
            Self::ImageSize { .. } => format!("textures have 1 to {} texels a side and {} in all", crate::image_io::MAX_SIDE, crate::image_io::MAX_TEXELS),
            Self::EnvironmentSize { chart, expected, .. } => format!("a {chart} map is {expected}; name the chart that the image is in, or convert it with `texmap env`"),
            Self::BadShape { .. } => "docs/SCENE_FORMAT.md says what the line takes, and from which sizes on it is refused".into(),
            Self::EmptyScene { .. } => "nothing would be drawn; add `f`, `tf`, `ff` or `obj` lines".into(),
            Self::EmptyMesh { .. } => "nothing would be drawn; the model needs faces (points and lines are not drawn)".into(),
            Self::UnknownMaterial { .. } => "define it in the MTL library, correct the name, or draw without it (`missing warn`)".into(),
            Self::BrokenModel { .. } | Self::BrokenModelLine { .. } => "export the model again, or convert it to OBJ".into(),
            Self::PointCloud { .. } => "only faces are drawn; make a surface of the points first (MeshLab and Open3D do), and export it with faces".into(),
            Self::BrokenGltf { .. } => "export the model again; the glTF validator of Khronos lists every fault of a file".into(),
            Self::UnsupportedGltf { instead, .. } => instead.clone(),
            Self::NamedByGltf { error, .. } => match **error {
                Self::FileMissing { .. } => "names are relative to the folder of the model; put the file there, or export the model as one .glb".into(),
                Self::OutsideRoot { .. } => "a glTF reads files of its own folder and below; `--root DIR` names another folder that holds both".into(),
                Self::BrokenImage { .. } => "glTF pictures are PNG, JPEG or WebP; the file is damaged or of another kind".into(),
                ref other => other.help(),
            },
            Self::UnknownName { of, known, .. } if known.is_empty() => format!("the model has no {of}s; leave the choice out"),
            Self::UnknownName { known, .. } => format!("there are: {known} (`texmap info` lists them)"),
            Self::BrokenArray { .. } => "texmap reads .npy arrays of format 1 to 3, C order, little-endian f4, f8, u1 or u2".into(),
            Self::Memory { refused, .. } => format!("{}, or raise the memory budget", refused.lower),
            Self::BrokenPath { .. } => "a camera path is a JSON list of {\"eye\":[x,y,z],\"look\":[x,y,z]} with optional \"up\" and \"fov\" (degrees); a list of cameras may have \"matrix\" and \"fx\", too".into(),
        }
    }
}

/// `.a, .b and .c`.
fn endings(names: impl Iterator<Item = &'static str>) -> String {
    let names: Vec<String> = names.map(|name| format!(".{name}")).collect();
    match names.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => names.concat(),
    }
}

fn index_help(location: &SourceLocation, count: usize) -> String {
    let one_based = location
        .file
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("obj"));
    match (one_based, count) {
        (_, 0) => "none is defined above this line; list them before the faces".into(),
        (true, n) => format!("indices count from 1 to {n}, or from -1 back to -{n}"),
        (false, n) => format!("indices count from 0 to {}", n - 1),
    }
}
