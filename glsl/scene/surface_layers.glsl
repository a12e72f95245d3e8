#pragma once
// The layers of a material at a point of a surface: with their textures, the normal of the coat and the direction of anisotropy.
#include "scene/normal_map.glsl"

// True if textures may change the layers from point to point. A scene in which they do names its surfaces.
const bool HAS_LAYER_TEXTURES = HAS_TEXTURES && SURFACES_NAMED;

// A texture of values that are no colours, at a point of a triangle.
vec4 layer_texel(uint texture, GpuInstance instance, uint primitive, vec2 weights) {
    GpuTexture used = load_textures(texture);
    return texture_at(used, uv_at(instance, primitive, weights, used.set), false);
}

// `point` has the normal of the mesh, before a normal map turns it.
Layers layers_at(uint index, GpuInstance instance, uint primitive, vec2 weights, TrianglePoint point) {
    Layers layers = layers_at(index);
    if (!HAS_LAYERS) return layers;
    GpuMaterialLayers used = load_material_layers(scene.at.material_count + index);
    if (HAS_COAT && HAS_LAYER_TEXTURES && used.coat_texture != NONE) {
        layers.coat *= layer_texel(used.coat_texture, instance, primitive, weights).r;
    }
    if (HAS_COAT && HAS_LAYER_TEXTURES && used.coat_roughness_texture != NONE) {
        layers.coat_roughness *= layer_texel(used.coat_roughness_texture, instance, primitive, weights).g;
    }
    if (HAS_TRANSMISSION && HAS_LAYER_TEXTURES && used.transmission_texture != NONE) {
        layers.transmission *= layer_texel(used.transmission_texture, instance, primitive, weights).r;
    }
    if (HAS_COAT_NORMALS) {
        TrianglePoint coat = point;
        if (used.coat_normal_texture != NONE) {
            turn_normal(coat, used.coat_normal_texture, used.coat_normal_scale, instance, primitive, weights);
        }
        layers.coat_normal = coat.shading_normal;
    }
    if (HAS_ANISOTROPY && layers.anisotropy > 0.0) {
        vec2 direction = vec2(1.0, 0.0);
        if (HAS_LAYER_TEXTURES && used.anisotropy_texture != NONE) {
            vec3 value = layer_texel(used.anisotropy_texture, instance, primitive, weights).rgb;
            vec2 mapped = value.rg * 2.0 - 1.0;
            float size = dot(mapped, mapped);
            if (size > TINY) direction = mapped * inversesqrt(size);
            layers.anisotropy *= value.b;
        }
        vec2 turn = on_circle(used.anisotropy_turns);
        direction = vec2(turn.x * direction.x - turn.y * direction.y, turn.y * direction.x + turn.x * direction.y);
        vec3 tangent, bitangent;
        if (mesh_tangents(instance, primitive, weights, point.shading_normal, tangent, bitangent)) {
            layers.grain = direction.x * tangent + direction.y * bitangent;
        }
    }
    return layers;
}

// The shading frame around a normal; with an anisotropic lobe its tangent is the direction in which the lobe is wider.
void shading_frame(vec3 normal, Layers layers, out vec3 tangent, out vec3 bitangent) {
    tangent_frame(normal, tangent, bitangent);
    if (!HAS_ANISOTROPY) return;
    vec3 along = layers.grain - dot(layers.grain, normal) * normal;
    float size = dot(along, along);
    // At a silhouette, the normal may have been bent into it.
    if (size <= 1e-9) return;
    tangent = along * inversesqrt(size);
    bitangent = cross(normal, tangent);
}

// The layers with their vectors in a shading frame, from which the BSDF is made.
Layers in_frame(Layers layers, vec3 tangent, vec3 bitangent, vec3 normal) {
    if (!HAS_COAT_NORMALS) return layers;
    vec3 coat = layers.coat_normal;
    layers.coat_normal = vec3(dot(coat, tangent), dot(coat, bitangent), dot(coat, normal));
    return layers;
}
