//! A scene with its view, as a plan describes it.

use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt::{self, Formatter};

/// A scene of a plan. In the plan it is a name alone, or a table with these fields.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(remote = "Self", deny_unknown_fields)]
pub struct PlannedScene {
    /// The name of a procedural scene, with its parameters, or the path of a file.
    #[serde(rename = "scene")]
    pub name: String,
    /// The camera as `x,y,z,x,y,z` or `x,y,z,x,y,z,degrees`: eye, target and vertical field of view. `None`: the scene's
    /// first camera.
    pub look_at: Option<String>,
    /// The environment that lights the scene: an image file, or a generated sky such as `sky:sun=40`. `None`: no
    /// environment.
    pub environment: Option<String>,
    /// The number of samples per pixel of the scene's references; `None`: the number that the plan gives for all scenes.
    pub reference_spp: Option<u32>,
}

impl PlannedScene {
    /// The scene with this name, seen by its first camera, without an environment.
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
    /// Reads a name or a table. The implementation is manual, because serde's untagged enums do not name a wrong key in
    /// their errors.
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
