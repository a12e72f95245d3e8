#pragma once
// The lobes of a surface, from the top to the bottom. Each lobe is a type with the functions of the contract below, and a line in
// BSDF_LOBES registers it. A lobe reflects what the lobes above it let through; `below` is that fraction.
//
//   float choice                          member: the probability of sampling the lobe once no lobe above it was selected
//   make_lobe(material, layers, outgoing, lobe)
//                                         sets every member but `choice`
//   reflects(lobe)                        false for a lobe that the material does not have
//   transmits(lobe)                       true for a lobe whose light comes from below the surface: its directions have z < 0
//   passes(lobe, cosine)                  the fraction of light that reaches the lobes below
//   expected(lobe, below, cosine)         luminance that it reflects, approximately: decides how often it is sampled
//   evaluate(lobe, below, probability, outgoing, incoming, half, pdf)
//                                         f; adds to `pdf` the density per solid angle of sampling the lobe, times the
//                                         probability of sampling it
//   is_wide(lobe)                         false for a delta lobe, which is not evaluated
//   draw(lobe, outgoing, u)               a direction with that density
//   albedo(lobe, below, cosine)           the fraction of light that it reflects
//   alpha_of(lobe)                        GGX width of a specular lobe; 0 = a delta lobe, 1 for lobes that are no peak
//   is_matte(lobe)                        true for a lobe of reflection that is no peak and reflects by the material's colour
//   reflect_delta(lobe, below, outgoing, direction)
//                                         of a delta lobe: its direction, and the reflectance
//   summarise(lobe, below, cosine, summary)
//                                         adds the lobe to the summary by which light samplers compare lights
#include "bsdf/layers.glsl"
#include "core/math.glsl"

// A BSDF in a few numbers: one matte lobe and one peak, for estimates of what a light contributes.
struct BsdfSummary {
    // Luminance of f of the matte lobes.
    float diffuse;
    // Luminance that the peak reflects at normal and at grazing incidence; 0 at both for a delta lobe, which reflects no light sample.
    float specular;
    float specular_grazing;
    float alpha_squared;
    // True if the matte lobes count light from behind the surface too.
    bool two_sided;
};

#include "bsdf/coat.glsl"
#include "bsdf/dielectric.glsl"
#include "bsdf/diffuse.glsl"
#include "bsdf/specular.glsl"
#include "bsdf/transmission.glsl"

// Type, member of Bsdf, and 1 if the lobe can be a delta lobe.
#define BSDF_LOBES(LOBE) \
    LOBE(CoatLobe, coat, uint(HAS_COAT)) \
    LOBE(SpecularLobe, specular, 1u) \
    LOBE(TransmissionLobe, transmission, (HAS_TRANSMISSION ? 1u : 0u)) \
    LOBE(DiffuseLobe, diffuse, 0u)
