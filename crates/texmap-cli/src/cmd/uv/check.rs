//! Arguments that do not go together.

use std::path::{Path, PathBuf};

use super::{By, Map, UvArgs};
use crate::failure::Failure;
use crate::formats;

/// Refuses a line that does nothing, flags without effect and two documents on one stream.
pub(super) fn check(args: &UvArgs) -> Result<(), Failure> {
    let output = args.output.is_some() || args.tangents.is_some();
    if !output && !args.report && !args.json && args.pictures.is_none() {
        return Err(Failure::usage(
            "nothing to do",
            "give -o OUT.obj, --report, --json, --pictures DIR or --tangents FILE.npy",
        ));
    }
    let to_stdout = |path: &Option<PathBuf>| path.as_deref() == Some(Path::new("-"));
    let streams = [
        ("-o -", to_stdout(&args.output)),
        ("--tangents -", to_stdout(&args.tangents)),
        ("--json", args.json),
        ("--report", args.report && !args.json),
    ];
    let mut streams = streams.into_iter().filter(|(_, given)| *given);
    if let (Some((first, _)), Some((second, _))) = (streams.next(), streams.next()) {
        return Err(Failure::usage(
            format!("{first} and {second} do not go together"),
            "name a file",
        ));
    }
    for (flag, path, known) in [
        ("-o", &args.output, "obj"),
        ("--tangents", &args.tangents, "npy"),
    ] {
        if let Some(path) = path {
            formats::ending(flag, path, &[known])?;
        }
    }
    let shape = matches!(
        args.map,
        Some(Map::Plane | Map::Cylinder | Map::Cone | Map::Sphere | Map::Box)
    );
    let round = matches!(args.map, Some(Map::Cylinder | Map::Cone | Map::Sphere));
    let packs = args.pack.is_some() || matches!(args.map, Some(Map::Auto | Map::Unwrap));
    let needs = |given: bool, flag: &str, what: &str| match given {
        true => Err(Failure::usage(
            format!("{flag} has no effect here"),
            format!("it belongs to {what}"),
        )),
        false => Ok(()),
    };
    needs(
        args.by != By::Position && !shape,
        "--by",
        "--map plane, cylinder, cone, sphere or box",
    )?;
    needs(
        args.frame.is_some() && !shape,
        "--frame",
        "--map plane, cylinder, cone, sphere or box",
    )?;
    needs(
        args.repeat.is_some() && !shape,
        "--repeat",
        "--map plane, cylinder, cone, sphere or box",
    )?;
    needs(
        args.fix_seams && !round,
        "--fix-seams",
        "--map cylinder, cone or sphere",
    )?;
    needs(
        args.gutter.is_some() && !packs,
        "--gutter",
        "--pack, --map auto or --map unwrap",
    )?;
    needs(
        args.texture_size.is_some() && !args.report && !args.json,
        "--texture-size",
        "--report or --json",
    )?;
    needs(
        args.no_caps && !matches!(args.map, Some(Map::Cylinder | Map::Cone)),
        "--no-caps",
        "--map cylinder or cone",
    )?;
    needs(
        args.eye.is_some() && args.by != By::Reflection,
        "--eye",
        "--by reflection",
    )?;
    needs(
        args.tile.is_some() && (args.map != Some(Map::Plane) || args.by != By::Position),
        "--tile",
        "--map plane --by position",
    )?;
    if args.by == By::Reflection && args.eye.is_none() {
        return Err(Failure::usage(
            "--by reflection needs an eye",
            "give --eye x,y,z",
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        uv: UvArgs,
    }

    fn checked(flags: &str) -> Result<(), String> {
        let words = ["uv", "a.obj"].into_iter().chain(flags.split_whitespace());
        check(&Line::parse_from(words).uv)
            .map_err(|refusal| format!("{}: {}", refusal.what, refusal.why))
    }

    #[test]
    fn flags_without_effect_are_refused() {
        for (flags, flag, home) in [
            (
                "--map plane --fix-seams -o b.obj",
                "--fix-seams",
                "cylinder, cone or sphere",
            ),
            (
                "--map box --fix-seams -o b.obj",
                "--fix-seams",
                "cylinder, cone or sphere",
            ),
            (
                "--map auto --fix-seams -o b.obj",
                "--fix-seams",
                "cylinder, cone or sphere",
            ),
            ("--map sphere --gutter 4 -o b.obj", "--gutter", "--pack"),
            ("--gutter 4 --report", "--gutter", "--pack"),
            (
                "--map auto --texture-size 64 -o b.obj",
                "--texture-size",
                "--report",
            ),
            (
                "--pictures p --texture-size 64",
                "--texture-size",
                "--report",
            ),
        ] {
            let told = checked(flags).unwrap_err();
            let begin = format!("{flag} has no effect here: it belongs to ");
            assert!(
                told.starts_with(&begin) && told.contains(home),
                "{flags}: {told}"
            );
        }
        for flags in [
            "--map cone --fix-seams -o b.obj",
            "--map auto --gutter 4 -o b.obj",
            "--map unwrap --gutter 4 -o b.obj",
            "--pack 64 --gutter 4 -o b.obj",
            "--texture-size 64 --report",
            "--texture-size 64 --json",
        ] {
            assert_eq!(checked(flags), Ok(()), "{flags}");
        }
    }
}
