//! Reads the instances of a node: the copies of its mesh that `EXT_mesh_gpu_instancing` places.

use super::accessors::Accessors;
use super::damaged;
use super::nodes::{Placed, is_rotation};
use crate::{Error, Result};
use glam::{DAffine3, DQuat, DVec3};

/// The memory that one instance takes in the scene and its motion, in bytes, rounded up. The name of the node, which each
/// instance gets, is not included.
const INSTANCE_BYTES: u128 = 512;

/// The transforms from the instances of a node to the node itself. `None` if the node shows its mesh once, because it does not
/// have the extension, or only attributes that do not place instances. Fails if an accessor or a transform is wrong, or if
/// the instances take too much memory.
pub fn transforms(accessors: &Accessors<'_>, placed: &Placed<'_>) -> Result<Option<Vec<DAffine3>>> {
    let Some(instancing) = &placed.node.extensions.instancing else {
        return Ok(None);
    };
    let what = format!("instances of {}", placed.label());
    let mut count = None;
    let mut numbers = |name: &str, kind: &str, components: usize| {
        let Some(&accessor) = instancing.attributes.get(name) else {
            return Ok(None);
        };
        let used_as = format!("{name} of the {what}");
        let numbers = accessors.numbers(accessor, &used_as, (kind, components), false)?;
        let found = numbers.len() / components;
        if let Some(other) = count.replace(found)
            && other != found
        {
            return Err(damaged(format!(
                "accessor {accessor} ({used_as}): has {found} elements, another attribute has {other}"
            )));
        }
        Ok(Some(numbers))
    };
    let translations = numbers("TRANSLATION", "VEC3", 3)?;
    let rotations = numbers("ROTATION", "VEC4", 4)?;
    let scales = numbers("SCALE", "VEC3", 3)?;
    let Some(count) = count else {
        return Ok(None);
    };
    let bytes = INSTANCE_BYTES + placed.node.name.len() as u128;
    accessors.unfolding.take(&what, count as u128 * bytes)?;
    let vector = |numbers: &Option<Vec<f64>>, i: usize, missing: DVec3| {
        (numbers.as_ref()).map_or(missing, |numbers| DVec3::from_slice(&numbers[3 * i..]))
    };
    let transform = |i: usize| {
        let wrong = |fault: &str| Error::input(format!("{what}: instance {i}: {fault}"));
        let rotation = (rotations.as_ref()).map_or(DQuat::IDENTITY, |numbers| {
            DQuat::from_slice(&numbers[4 * i..])
        });
        if !is_rotation(rotation) {
            return Err(wrong(
                "its rotation is not a unit quaternion; export it again",
            ));
        }
        let transform = DAffine3::from_scale_rotation_translation(
            vector(&scales, i, DVec3::ONE),
            rotation.normalize(),
            vector(&translations, i, DVec3::ZERO),
        );
        match (placed.to_world * transform).is_finite() {
            true => Ok(transform),
            false => Err(wrong("its transform is not finite; export it again")),
        }
    };
    (0..count).map(transform).collect::<Result<_>>().map(Some)
}
