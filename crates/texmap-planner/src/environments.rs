//! The environments that a picture reads: how large they are, and why.

use texmap_light::{Environment, EnvironmentLayout};

use texmap_scene::{Background, Scene};

/// An environment that something reads.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentChoice {
    /// Index into [`Effects::environments`](texmap_scene::Effects::environments).
    pub environment: usize,
    /// Layout of the environment.
    pub chart: EnvironmentLayout,
    /// Width and height of a face in texels.
    pub size: (u32, u32),
    /// The exponent of the lobe that a specular map was gathered with, if it is known.
    pub exponent: Option<f32>,
    /// Texels a side of a cube's faces that this lobe needs.
    pub needed: Option<u32>,
    /// Reason for the size, in words.
    pub why: String,
}

/// Environments that materials with triangles and the sky read.
pub(super) fn used(scene: &Scene) -> Vec<EnvironmentChoice> {
    let materials = || {
        let drawn = scene.meshes.iter().filter(|m| !m.triangles.is_empty());
        drawn.filter_map(|m| scene.materials.get(m.material))
    };
    let environments = scene.effects.environments.iter().enumerate();
    let choice = |(index, environment): (usize, &Environment)| {
        let specular = materials().any(|m| m.specular_map == Some(index));
        let mirrored = materials().any(|m| m.reflection.is_some_and(|r| r.environment == index));
        let sky = scene.effects.background == Some(Background::Environment(index));
        let why = if specular {
            of_lobe(environment)
        } else if mirrored && environment.levels() > 1 {
            "mirrored: as it was given, with a level for each footprint".to_owned()
        } else if mirrored {
            "mirrored: as it was given, without levels".to_owned()
        } else if sky {
            "the sky: as it was given".to_owned()
        } else {
            return None;
        };
        let exponent = environment.exponent();
        Some(EnvironmentChoice {
            environment: index,
            chart: environment.layout(),
            size: environment.size(),
            exponent,
            needed: exponent.map(Environment::blurred_size),
            why,
        })
    };
    environments.filter_map(choice).collect()
}

fn of_lobe(environment: &Environment) -> String {
    let Some(exponent) = environment.exponent() else {
        return "specular map: as it was given, of no known lobe".to_owned();
    };
    let needed = Environment::blurred_size(exponent);
    let lobe = format!("specular map of exponent {exponent}");
    let enough = format!(
        "{needed} texels a side of a cube's faces keep look-ups within a hundredth of its range"
    );
    if environment.layout() == EnvironmentLayout::Cube && environment.size().1 == needed {
        format!("{lobe}: {enough}")
    } else {
        format!("{lobe}: as it was given, where {enough}")
    }
}

#[cfg(test)]
mod tests {
    use texmap_math::glam::DVec3;

    use super::*;
    use texmap_scene::{Material, Mesh, Reflection};

    fn sky(size: u32) -> Environment {
        let light = |d: DVec3| [d.x.abs() as f32, 0.5, 0.25];
        Environment::from_fn(EnvironmentLayout::Cube, size, light).unwrap()
    }

    /// A triangle that mirrors environment 0 and has highlights of environment 1; nothing reads 2.
    fn scene(map: Environment) -> Scene {
        let material = Material {
            reflection: Some(Reflection {
                environment: 0,
                reflectivity: 0.5,
                within: None,
            }),
            specular_map: Some(1),
            ..Material::default()
        };
        let mut scene = super::super::tests::scene();
        scene.materials = vec![material];
        scene.meshes = vec![Mesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        }];
        scene.effects.environments = vec![sky(8), map, sky(4)];
        scene
    }

    #[test]
    fn what_is_read_is_named_with_its_size_and_reason() {
        let map =
            sky(16).specular_map(EnvironmentLayout::Cube, Environment::blurred_size(9.0), 9.0);
        let choices = used(&scene(map.unwrap()));
        let numbers: Vec<usize> = choices.iter().map(|c| c.environment).collect();
        assert_eq!(numbers, [0, 1]);
        assert_eq!((choices[0].size, choices[0].exponent), ((8, 8), None));
        assert!(choices[0].why.starts_with("mirrored"));
        let map = &choices[1];
        assert_eq!(
            (map.size, map.exponent, map.needed),
            ((30, 30), Some(9.0), Some(30))
        );
        assert!(map.why.contains("exponent 9: 30 texels"), "{}", map.why);
    }

    #[test]
    fn a_map_of_another_size_or_lobe_is_not_called_chosen() {
        let larger = sky(8).blur(EnvironmentLayout::Cube, 40, 9.0).unwrap();
        let choices = used(&scene(larger));
        assert_eq!(choices[1].needed, Some(30));
        assert!(choices[1].why.contains("as it was given, where 30"));
        let choices = used(&scene(sky(8)));
        assert_eq!(choices[1].needed, None);
        assert!(choices[1].why.contains("no known lobe"));
        // Negative twin: without triangles nothing is read; a sky is.
        let mut bare = scene(sky(8));
        bare.meshes[0].triangles.clear();
        assert_eq!(used(&bare), []);
        bare.effects.background = Some(Background::Environment(2));
        assert_eq!(used(&bare)[0].environment, 2);
    }
}
