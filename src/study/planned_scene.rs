//! A scene as a plan writes it.

use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt::{self, Formatter};

/// A scene of a plan: written as its name alone, or as a table.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(remote = "Self", deny_unknown_fields)]
pub struct PlannedScene {
    /// A procedural name or a file.
    #[serde(rename = "scene")]
    pub name: String,
    /// The eye and the target, and optionally the vertical field of view in degrees; without them, the scene's first camera is
    /// used.
    pub look_at: Option<String>,
    /// The environment: a file or a sky, as `--environment` takes it.
    pub environment: Option<String>,
    /// The number of samples per pixel of its references, instead of the plan's number.
    pub reference_spp: Option<u32>,
}

impl PlannedScene {
    /// A scene as it is, seen by its first camera.
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
    /// The implementation is manual, because serde's untagged enums do not name the wrong key.
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
