//! A scene of a plan, with the camera and the environment with which a study renders it.

use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt::{self, Formatter};

/// A scene of a plan, on which a study renders its configurations. In the TOML text of the plan it is either the scene's
/// name alone or a table with these fields.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(remote = "Self", deny_unknown_fields)]
pub struct PlannedScene {
    /// The name of a procedural scene, with its parameters (such as `cornell:finish=metal`), or the path of a scene file. In
    /// the table its key is `scene`.
    #[serde(rename = "scene")]
    pub name: String,
    /// The camera as text, `x,y,z,x,y,z` or `x,y,z,x,y,z,degrees`: positions of the eye and the target in scene units, and
    /// the vertical field of view in degrees (by default 45). `None`: the scene's first camera or, if the scene has no
    /// camera, one that frames the scene.
    pub look_at: Option<String>,
    /// The environment that lights the scene: the path of an image file, or a generated sky such as `sky:sun=40`. The option
    /// `--environment` replaces it. `None`: the scene's own, or a neutral one if the scene has no light at all, unless this option gives
    /// one.
    pub environment: Option<String>,
    /// The number of samples per pixel of the scene's references (path-traced pictures that runs are compared with). `None`:
    /// the number that the plan states for all scenes.
    pub reference_spp: Option<u32>,
}

impl PlannedScene {
    /// The scene with the name `name` and without further keys: seen by its first camera (or, without cameras, by one that
    /// frames the scene), without an environment, and with the plan's number of samples for references. A study uses it for
    /// a scene that the plan gives by its name alone, and for a scene that the command line names but the plan does not.
    pub fn named(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            look_at: None,
            environment: None,
            reference_spp: None,
        }
    }
}

impl<'de> Deserialize<'de> for PlannedScene {
    /// Reads a scene from its name alone or from a table. This is written by hand, because the errors of serde's untagged
    /// enums would not name a wrong key of the table.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NameOrTable;
        impl<'de> Visitor<'de> for NameOrTable {
            type Value = PlannedScene;

            fn expecting(&self, f: &mut Formatter<'_>) -> fmt::Result {
                f.write_str(
                    "a scene's name, or a table with scene, look_at, environment and reference_spp",
                )
            }

            fn visit_str<E>(self, name: &str) -> Result<PlannedScene, E> {
                Ok(PlannedScene::named(name))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<PlannedScene, A::Error> {
                // What `remote` derives: the table's own reading, which has this name too.
                PlannedScene::deserialize(MapAccessDeserializer::new(map))
            }
        }
        deserializer.deserialize_any(NameOrTable)
    }
}
