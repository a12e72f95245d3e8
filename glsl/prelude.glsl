#pragma once
// Extensions that every shader uses, and the declarations shared with Rust. Every file includes it first, since
// extensions must stand before all code.
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_basic : require
#if GEOMETRY_ADDRESSES
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#endif
#if TRACE_RAY_QUERY
#extension GL_EXT_ray_query : require
#endif
#if TEXTURE_IMAGES
#extension GL_EXT_nonuniform_qualifier : require
#extension GL_EXT_samplerless_texture_functions : require
#endif

#include "declarations.glsl"
