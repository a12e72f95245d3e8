//! Procedural scenes: scenes that are generated from a name and parameters instead of read from a file. The
//! same name and parameters give the same scene, equal to the last bit, on every machine.

mod modelling;
mod parameters;
mod props;
mod recipes;

use crate::base::nearest::nearest;
use crate::scene::{Motion, Scene};
use crate::{Error, Result};
use parameters::Values;
pub use parameters::{Parameter, Range};

/// A procedural scene that the command line can name: its name, its description, its parameters and the function that
/// generates it. `headwater scene list` prints all of these but the function.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct Procedural {
    /// The name of the scene on the command line, such as `cornell`. Each scene has a different one.
    pub name: &'static str,
    /// The description of the scene in one line, which `headwater scene list` shows.
    pub description: &'static str,
    /// The parameters that the scene has, in the order in which `headwater scene list` shows them.
    pub parameters: &'static [Parameter],
    #[serde(skip)]
    make: fn(&Values) -> Scene,
}

/// All procedural scenes, in the order in which `headwater scene list` prints them. [`find`] looks up one of
/// them by its name.
pub fn list() -> &'static [Procedural] {
    recipes::SCENES
}

/// Finds the procedural scene whose name on the command line is `name`.
///
/// # Errors
/// No scene has this name; the message suggests the closest name.
pub fn find(name: &str) -> Result<&'static Procedural> {
    recipes::SCENES.iter().find(|s| s.name == name).ok_or_else(|| {
        Error::input(format!(
            "no scene '{name}'{}; 'headwater scene list' names the procedural ones, a file ends in .gltf, .glb or .obj",
            nearest(name, recipes::SCENES.iter().map(|s| s.name))
        ))
    })
}

/// Checks `settings`, pairs of a parameter's name and the text of its value, for the scene with this name. A wrong setting
/// is thus reported at once, without the generation of the scene, which could take long.
///
/// # Errors
/// No scene has this name, a name in `settings` is not one of its parameters, or a value is out of range.
pub fn check(name: &str, settings: &[(String, String)]) -> Result<()> {
    Values::new(find(name)?, settings).map(drop)
}

/// Generates the scene with this name; its moving parts are where they are at time 0. `settings` are pairs of a parameter's
/// name and the text of its value; the other parameters have their defaults.
///
/// # Errors
/// The scene or a parameter is unknown, a value is out of range, or the generated scene is not valid.
pub fn generate(name: &str, settings: &[(String, String)]) -> Result<Scene> {
    let procedural = find(name)?;
    let values = Values::new(procedural, settings)?;
    let mut scene = (procedural.make)(&values);
    scene.name = name.to_owned();
    scene.take_pose(0.0)?;
    scene.motion = scene.motion.take().and_then(Motion::simplified);
    scene.validate()?;
    Ok(scene)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_is_valid_as_it_is_made() {
        for procedural in list() {
            let scene = generate(procedural.name, &[]).unwrap();
            assert_eq!(scene.notices, Vec::<String>::new(), "{}", procedural.name);
            assert_eq!(scene.cameras.len(), 1, "{}", procedural.name);
            assert!(scene.emissive_triangle_count() > 0, "{}", procedural.name);
        }
    }

    /// Parameter values (scene, parameter, value) for which the generation of a scene takes seconds or gigabytes. The test
    /// that generates every scene at both ends of each parameter's range skips these values, unless `HEADWATER_TEST_ALL` is
    /// set.
    const LARGE: &[(&str, &str, &str)] = &[
        ("colourful-mess", "things", "1000"),
        ("street", "lights", "2000000"),
        ("terrain", "triangles", "50000000"),
    ];

    #[test]
    fn the_same_parameters_make_the_same_scene() {
        for procedural in list() {
            let hash = || generate(procedural.name, &[]).unwrap().content_hash();
            assert_eq!(hash(), hash(), "{}", procedural.name);
        }
    }

    #[test]
    fn wrong_names_and_values_are_told_apart() {
        let message = |name: &str, key: &str, value: &str| {
            let settings = [(key.to_owned(), value.to_owned())];
            let error = generate(name, &settings).unwrap_err();
            assert_eq!(error.exit_status(), 2);
            error.to_string()
        };
        assert!(message("cornel", "x", "1").contains("cornell"));
        assert!(message("terrain", "triangle", "8").contains("triangles"));
        assert!(message("terrain", "triangles", "0").contains("2 to 50000000"));
        assert!(message("terrain", "triangles", "many").contains("triangles"));
        assert!(message("furnace", "roughness", "NaN").contains("roughness"));
        assert!(message("furnace", "body", "cow").contains("box | sphere"));
    }

    #[test]
    fn the_street_has_exactly_the_lights_it_is_told() {
        let count = |settings: &[(String, String)]| {
            let scene = generate("street", settings).unwrap();
            scene.emissive_triangle_count()
        };
        assert_eq!(count(&[]), 30_000);
        for lights in [1, 59, 60, 61, 500, 4321, 65_536] {
            assert_eq!(count(&[("lights".into(), lights.to_string())]), lights);
        }
    }

    #[test]
    fn the_city_has_its_lights_and_the_terrain_its_triangles() {
        assert!(
            generate("night-city", &[])
                .unwrap()
                .emissive_triangle_count()
                >= 3000
        );
        let settings = [("triangles".to_owned(), "20000".to_owned())];
        let ground = generate("terrain", &settings).unwrap();
        assert_eq!(ground.meshes[0].triangles.len(), 20000);
    }

    mod thorough {
        use super::*;

        #[test]
        fn every_scene_is_valid_at_both_ends_of_its_parameters() {
            let all = std::env::var_os("HEADWATER_TEST_ALL").is_some();
            for scene in list() {
                for parameter in scene.parameters {
                    let ends = match parameter.values {
                        Range::Whole(low, high) => vec![low.to_string(), high.to_string()],
                        Range::Real(low, high) => vec![low.to_string(), high.to_string()],
                        Range::Words(words) => words.iter().map(|w| (*w).to_owned()).collect(),
                    };
                    for end in ends {
                        if LARGE.contains(&(scene.name, parameter.name, &end)) && !all {
                            continue;
                        }
                        let what = format!("{} {}={end}", scene.name, parameter.name);
                        let made = generate(scene.name, &[(parameter.name.to_owned(), end)]);
                        let made = made.unwrap_or_else(|e| panic!("{what}: {e}"));
                        assert_eq!(made.notices, Vec::<String>::new(), "{what}");
                        let bounds = made.bounds().unwrap_or_else(|| panic!("{what}: empty"));
                        let size = bounds.size();
                        assert!(
                            size.is_finite() && size.min_element() > 0.0,
                            "{what}: {size}"
                        );
                    }
                }
            }
        }
    }
}
