//! A hash of everything in a scene that affects its picture. Pictures and results of studies store it, to identify their
//! scene: they are reused or continued only for a scene with the same hash.

use super::camera::{Lens, Projection};
use super::motion::deformation::{Deformation, Influence, Joint, MorphTarget, Skin, Vertices};
use super::motion::tracks::{Animated, Interpolation, Track};
use super::motion::{AnimatedTransform, Emission, Motion, Node, Transform};
use super::texture::Wrap;
use super::{
    AlphaMode, Camera, Environment, Image, Instance, Material, Mesh, PunctualLight, PunctualShape,
    Scene, Texture,
};
use glam::DAffine3;

impl Scene {
    /// The BLAKE3 hash, as 64 hexadecimal digits, of everything that affects the picture: meshes, materials,
    /// images, instances, lights, environment, cameras and motion. Scenes with the same hash have the same
    /// pictures. Names, and the notices that were given while a file was loaded, do not change it.
    pub fn content_hash(&self) -> String {
        // Full destructuring, so that a new field cannot be forgotten here.
        let Self {
            name: _,
            meshes,
            materials,
            images,
            instances,
            punctual_lights,
            environment,
            cameras,
            motion,
            material_variants: _,
            notices: _,
        } = self;
        let mut hasher = blake3::Hasher::new();
        hasher.update(b"headwater scene 1\0");
        count(&mut hasher, meshes.len());
        meshes.iter().for_each(|mesh| hash_mesh(&mut hasher, mesh));
        count(&mut hasher, materials.len());
        for material in materials {
            hash_material(&mut hasher, material);
        }
        count(&mut hasher, instances.len());
        for instance in instances {
            let Instance {
                name: _,
                mesh,
                object_to_world,
            } = instance;
            hasher.update(&mesh.to_le_bytes());
            hash_affine(&mut hasher, object_to_world);
        }
        count(&mut hasher, cameras.len());
        for camera in cameras {
            let Camera {
                name: _,
                camera_to_world,
                projection,
                aspect_ratio,
            } = camera;
            hash_affine(&mut hasher, camera_to_world);
            // 0 is no valid aspect ratio.
            let aspect = aspect_ratio.unwrap_or(0.0);
            match projection {
                Projection::Perspective { vertical_fov, lens } => {
                    doubles(&mut hasher, &[*vertical_fov, aspect]);
                    if let Some(Lens {
                        diameter,
                        focus_distance,
                    }) = lens
                    {
                        hasher.update(b"lens\0");
                        doubles(&mut hasher, &[*diameter, *focus_distance]);
                    }
                }
                Projection::Orthographic { height } => {
                    hasher.update(b"orthographic\0");
                    doubles(&mut hasher, &[*height, aspect]);
                }
            }
        }
        // Nothing is added for scenes without motion, so that their hashes stay those of versions
        // without motion.
        if let Some(motion) = motion {
            hash_motion(&mut hasher, motion);
        }
        // The same holds for textures.
        if !images.is_empty() {
            hasher.update(b"images\0");
            images
                .iter()
                .for_each(|image| hash_image(&mut hasher, image));
        }
        for light in punctual_lights {
            hash_punctual(&mut hasher, light);
        }
        if let Some(environment) = environment {
            hash_environment(&mut hasher, environment);
        }
        hasher.finalize().to_hex().to_string()
    }
}

fn hash_punctual(hasher: &mut blake3::Hasher, light: &PunctualLight) {
    let PunctualLight {
        name: _,
        light_to_world,
        shape,
        intensity,
        range,
    } = light;
    hasher.update(b"punctual\0");
    hash_affine(hasher, light_to_world);
    let shape = match shape {
        PunctualShape::Point => [0.0; 3],
        PunctualShape::Spot { inner, outer } => [1.0, *inner, *outer],
        PunctualShape::Directional => [2.0, 0.0, 0.0],
    };
    doubles(hasher, &shape);
    // 0 is no valid range.
    doubles(hasher, &[range.unwrap_or(0.0)]);
    hasher.update(bytemuck::bytes_of(intensity));
}

fn hash_environment(hasher: &mut blake3::Hasher, environment: &Environment) {
    let Environment {
        name: _,
        width,
        height,
        texels,
        rotation,
        intensity,
    } = environment;
    hasher.update(b"environment\0");
    hasher.update(&width.to_le_bytes());
    hasher.update(&height.to_le_bytes());
    hasher.update(bytemuck::cast_slice(texels));
    doubles(hasher, &[*rotation, f64::from(*intensity)]);
}

fn hash_motion(hasher: &mut blake3::Hasher, motion: &Motion) {
    let Motion {
        nodes,
        instances,
        cameras,
        lights,
        emission,
        deformations,
    } = motion;
    let index = |hasher: &mut blake3::Hasher, index: Option<u32>| {
        hasher.update(&index.unwrap_or(u32::MAX).to_le_bytes());
    };
    hasher.update(b"motion\0");
    count(hasher, nodes.len());
    for Node { parent, transform } in nodes {
        index(hasher, *parent);
        match transform {
            Transform::Fixed(transform) => {
                hasher.update(b"still");
                hash_affine(hasher, transform);
            }
            Transform::Moving(moving) => {
                let AnimatedTransform {
                    translation,
                    rotation,
                    scale,
                } = &**moving;
                hasher.update(b"moving");
                hash_animated(hasher, translation, |v| v.to_array().to_vec());
                hash_animated(hasher, rotation, |q| q.to_array().to_vec());
                hash_animated(hasher, scale, |v| v.to_array().to_vec());
            }
        }
    }
    for attached in [instances, cameras] {
        count(hasher, attached.len());
        attached.iter().for_each(|node| index(hasher, *node));
    }
    // Nothing for scenes without lights, so that their hashes stay as they were.
    lights.iter().for_each(|node| index(hasher, *node));
    count(hasher, emission.len());
    for Emission {
        material,
        color,
        strength,
    } in emission
    {
        index(hasher, Some(*material));
        hash_animated(hasher, color, |v| v.to_array().to_vec());
        hash_animated(hasher, strength, |v| vec![v]);
    }
    for deformation in deformations {
        hash_deformation(hasher, deformation);
    }
}

fn hash_deformation(hasher: &mut blake3::Hasher, deformation: &Deformation) {
    let Deformation {
        mesh,
        rest,
        targets,
        skin,
    } = deformation;
    let Vertices {
        positions,
        normals,
        tangents,
    } = rest;
    hasher.update(b"deformation\0");
    hasher.update(&mesh.to_le_bytes());
    for vectors in [positions, normals] {
        count(hasher, vectors.len());
        hasher.update(bytemuck::cast_slice(vectors));
    }
    hasher.update(bytemuck::cast_slice(tangents));
    count(hasher, targets.len());
    for MorphTarget {
        weight,
        positions,
        normals,
        tangents,
    } in targets
    {
        hash_animated(hasher, weight, |v| vec![v]);
        for vectors in [positions, normals, tangents] {
            count(hasher, vectors.len());
            hasher.update(bytemuck::cast_slice(vectors));
        }
    }
    let Some(Skin {
        joints,
        first_influence,
        influences,
        world_to_object,
    }) = skin
    else {
        return;
    };
    count(hasher, joints.len());
    for Joint { node, inverse_bind } in joints {
        hasher.update(&node.to_le_bytes());
        hash_affine(hasher, inverse_bind);
    }
    hasher.update(bytemuck::cast_slice(first_influence));
    for Influence { joint, weight } in influences {
        hasher.update(bytemuck::bytes_of(&[*joint, weight.to_bits()]));
    }
    hash_affine(hasher, world_to_object);
}

fn hash_animated<T: Copy>(
    hasher: &mut blake3::Hasher,
    animated: &Animated<T>,
    numbers: impl Fn(T) -> Vec<f64>,
) {
    let Animated { rest, track } = animated;
    doubles(hasher, &numbers(*rest));
    let Some(track) = track else {
        count(hasher, 0);
        return;
    };
    let Track {
        interpolation,
        times,
        values,
    } = track;
    count(hasher, times.len());
    hasher.update(&[match interpolation {
        Interpolation::Step => 0,
        Interpolation::Linear => 1,
        Interpolation::CubicSpline => 2,
    }]);
    doubles(hasher, times);
    values.iter().for_each(|v| doubles(hasher, &numbers(*v)));
}

fn hash_mesh(hasher: &mut blake3::Hasher, mesh: &Mesh) {
    let Mesh {
        name: _,
        positions,
        normals,
        colors,
        tangents,
        uvs,
        triangles,
        parts,
        sources: _,
    } = mesh;
    count(hasher, positions.len());
    hasher.update(bytemuck::cast_slice(positions));
    count(hasher, normals.len());
    hasher.update(bytemuck::cast_slice(normals));
    if !colors.is_empty() {
        hasher.update(b"colors\0");
        hasher.update(bytemuck::cast_slice(colors));
    }
    if !tangents.is_empty() {
        hasher.update(b"tangents\0");
        hasher.update(bytemuck::cast_slice(tangents));
    }
    for (set, uvs) in uvs.iter().enumerate().filter(|(_, uvs)| !uvs.is_empty()) {
        hasher.update(b"uvs\0");
        count(hasher, set);
        hasher.update(bytemuck::cast_slice(uvs));
    }
    count(hasher, triangles.len());
    hasher.update(bytemuck::cast_slice(triangles));
    count(hasher, parts.len());
    for part in parts {
        let numbers = [part.first_triangle, part.triangle_count, part.material];
        hasher.update(bytemuck::bytes_of(&numbers));
    }
}

fn hash_image(hasher: &mut blake3::Hasher, image: &Image) {
    let Image {
        name: _,
        width,
        height,
        texels,
    } = image;
    hasher.update(bytemuck::bytes_of(&[*width, *height]));
    hasher.update(bytemuck::cast_slice(texels));
}

fn hash_texture(hasher: &mut blake3::Hasher, kind: &[u8], texture: &Texture) {
    let Texture {
        image,
        set,
        transform,
        wrap,
        nearest,
    } = texture;
    hasher.update(kind);
    hasher.update(bytemuck::bytes_of(&[*image, *set]));
    hasher.update(bytemuck::bytes_of(&transform.to_cols_array()));
    let wrap = wrap.map(|wrap| match wrap {
        Wrap::Repeat => 0,
        Wrap::Mirror => 1,
        Wrap::Clamp => 2,
    });
    hasher.update(&[wrap[0], wrap[1], u8::from(*nearest)]);
}

fn hash_material(hasher: &mut blake3::Hasher, material: &Material) {
    let Material {
        name: _,
        base_color,
        base_color_texture,
        alpha,
        alpha_mode,
        metallic,
        roughness,
        metallic_roughness_texture,
        normal_texture,
        normal_scale,
        specular,
        specular_color,
        specular_texture,
        specular_color_texture,
        ior,
        unlit,
        emission,
        emissive_texture,
        double_sided,
        culled,
    } = material;
    for color in [base_color, specular_color, emission] {
        hasher.update(bytemuck::bytes_of(color));
    }
    hasher.update(bytemuck::bytes_of(&[
        *metallic, *roughness, *specular, *ior,
    ]));
    hasher.update(&[u8::from(*double_sided)]);
    // Nothing for other materials, so that their hashes stay as they were.
    if *culled {
        hasher.update(b"culled");
    }
    let textures = [
        (b"base", base_color_texture),
        (b"meta", metallic_roughness_texture),
        (b"emit", emissive_texture),
        (b"norm", normal_texture),
        (b"spec", specular_texture),
        (b"tint", specular_color_texture),
    ];
    for (kind, texture) in textures {
        if let Some(texture) = texture {
            hash_texture(hasher, kind, texture);
        }
    }
    let (mode, cutoff) = match alpha_mode {
        AlphaMode::Opaque => (0, 0.0),
        AlphaMode::Mask { cutoff } => (1, *cutoff),
        AlphaMode::Blend => (2, 0.0),
    };
    if mode != 0 {
        hasher.update(&[mode]);
        hasher.update(bytemuck::bytes_of(&[*alpha, cutoff]));
    }
    if *unlit {
        hasher.update(b"unlit");
    }
    if normal_texture.is_some() {
        hasher.update(bytemuck::bytes_of(normal_scale));
    }
}

fn hash_affine(hasher: &mut blake3::Hasher, transform: &DAffine3) {
    doubles(hasher, &transform.to_cols_array());
}

fn doubles(hasher: &mut blake3::Hasher, numbers: &[f64]) {
    hasher.update(bytemuck::cast_slice(numbers));
}

fn count(hasher: &mut blake3::Hasher, count: usize) {
    hasher.update(&(count as u64).to_le_bytes());
}

#[cfg(test)]
mod tests;
