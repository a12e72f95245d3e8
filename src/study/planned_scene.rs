//! A scene as a plan writes it.

use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt::{self, Formatter};

/// A scene of a plan: written as its name alone, or as a table.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedScene {
    /// A procedural name or a file.
    pub name: String,
    /// Eye and target, and optionally the vertical field of view in degrees; without, the scene is seen
    /// by its first camera.
    pub look_at: Option<String>,
    /// Samples a pixel of its references, instead of the plan's.
    pub reference_spp: Option<u32>,
}

impl PlannedScene {
    /// A scene as it is, seen by its first camera.
    pub fn named(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            look_at: None,
            reference_spp: None,
        }
    }
}

impl<'de> Deserialize<'de> for PlannedScene {
    /// By hand, since serde's untagged enums do not say which key is wrong.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NameOrTable;
        impl<'de> Visitor<'de> for NameOrTable {
            type Value = PlannedScene;

            fn expecting(&self, f: &mut Formatter<'_>) -> fmt::Result {
                f.write_str("a scene's name, or a table with scene, look_at and reference_spp")
            }

            fn visit_str<E>(self, name: &str) -> Result<PlannedScene, E> {
                Ok(PlannedScene::named(name))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<PlannedScene, A::Error> {
                #[derive(Deserialize)]
                #[serde(deny_unknown_fields)]
                struct Seen {
                    scene: String,
                    look_at: Option<String>,
                    reference_spp: Option<u32>,
                }
                let seen = Seen::deserialize(MapAccessDeserializer::new(map))?;
                Ok(PlannedScene {
                    name: seen.scene,
                    look_at: seen.look_at,
                    reference_spp: seen.reference_spp,
                })
            }
        }
        deserializer.deserialize_any(NameOrTable)
    }
}
