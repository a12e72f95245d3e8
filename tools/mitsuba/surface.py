"""The surfaces of glTF 2.0, appendix B, as a BSDF of Mitsuba, written from the specification.

All of it happens in world space with normals of its own: Mitsuba's meshes stay flat, because its lights shine along the
shading normal. What else a vertex has, the meshes carry as attributes.
"""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

# Headwater's conventions, which the specification leaves open: the cosine to the viewer that a shading normal has at least,
# and the roughness below which a surface is a mirror.
MIN_FACING = 0.01
MIRROR_ROUGHNESS = 0.01


def attribute(name, si, channels, active):
    read = {1: si.shape.eval_attribute_1, 3: si.shape.eval_attribute_3}[channels]
    return read(f"vertex_{name}", si, active)


@dataclass
class Lobes:
    """The values that a surface has everywhere; images multiply them, and so do the colours of vertices."""

    base_color: list
    base: object
    metallic: float
    roughness: float
    rough: object
    dielectric_f0: list
    dielectric_f90: float
    # The alpha of one multiplies the dielectric's f90, the colour of the other its f0.
    strength: object
    tint: object
    bumps: object
    normal_scale: float
    alpha: float
    # None where alpha is a share.
    cutoff: float | None
    # Whether there is anything above Lambert.
    specular: bool
    has_colors: bool
    has_normals: bool


class Image:
    """A texture of linear values, read at the coordinates that the meshes have under a name."""

    def __init__(self, name, values, wrap, nearest):
        self.name, self.wrap, self.size = name, wrap, (values.shape[1], values.shape[0])
        # One texel more on each side, so that each axis wraps as it should where texels are interpolated.
        for axis, mode in ((1, wrap[0]), (0, wrap[1])):
            last = values.shape[axis] - 1
            ends = [last, 0] if mode == "repeat" else [0, last]
            values = np.concatenate([values.take([ends[0]], axis), values, values.take([ends[1]], axis)], axis)
        filter_mode = dr.FilterMode.Nearest if nearest else dr.FilterMode.Linear
        data = mi.TensorXf(np.ascontiguousarray(values, np.float32))
        self.texels = mi.Texture2f(data, filter_mode=filter_mode, wrap_mode=dr.WrapMode.Clamp)

    def at(self, si, active):
        return self.read(attribute(self.name, si, 3, active), active)

    def read(self, coordinates, active):
        folded = []
        for axis in range(2):
            x, mode, size = coordinates[axis], self.wrap[axis], self.size[axis]
            if mode == "repeat":
                x = x - dr.floor(x)
            elif mode == "mirror":
                x = 1 - dr.abs(x - 2 * dr.floor(x / 2) - 1)
            else:
                x = dr.clip(x, 0, 1)
            folded.append((x * size + 1) / (size + 2))
        return self.texels.eval(mi.Point2f(folded), active)


class Glow(mi.Texture):
    """The radiance that each point of a mesh emits.

    It claims to be the same everywhere, so that Mitsuba draws points of the mesh: where it draws points of a texture, each
    must be in one place only.
    """

    def __init__(self, image):
        mi.Texture.__init__(self, mi.Properties())
        self.image = image

    def eval(self, si, active=True):
        return mi.Color3f(self.image.read(si.uv, active)[:3])

    def is_spatially_varying(self):
        return False

    def mean(self):
        return mi.Float(1)

    def to_string(self):
        return "Glow[]"


class Alpha(mi.Texture):
    """The fraction of light that a material stops: its coverage."""

    def __init__(self, of):
        mi.Texture.__init__(self, mi.Properties())
        self.of = of

    def eval_1(self, si, active=True):
        of = self.of
        alpha = mi.Float(of.alpha)
        if of.has_colors:
            alpha *= attribute("alpha", si, 1, active)
        if of.base is not None:
            alpha *= of.base.at(si, active)[3]
        if of.cutoff is not None:
            return dr.select(alpha >= of.cutoff, mi.Float(1), mi.Float(0))
        return dr.clip(alpha, 0, 1)

    def eval(self, si, active=True):
        return mi.Color3f(self.eval_1(si, active))

    def mean(self):
        return mi.Float(0.5)

    def to_string(self):
        return "Alpha[]"


class Here:
    """The values of a surface at a point."""


class Surface(mi.BSDF):
    """Lambert under a GGX lobe, seen from both sides."""

    def __init__(self, of):
        mi.BSDF.__init__(self, mi.Properties())
        self.of = of
        flags = mi.BSDFFlags
        both = flags.FrontSide | flags.BackSide
        varies = flags.SpatiallyVarying
        self.m_components = [flags.DiffuseReflection | flags.GlossyReflection | both | varies, flags.DeltaReflection | both]
        self.m_flags = self.m_components[0] | self.m_components[1]

    def at(self, si, active):
        of = self.of
        here = Here()
        color, metallic, roughness = mi.Color3f(of.base_color), mi.Float(of.metallic), mi.Float(of.roughness)
        if of.has_colors:
            color *= mi.Color3f(attribute("color", si, 3, active))
        if of.base is not None:
            color *= mi.Color3f(of.base.at(si, active)[:3])
        if of.rough is not None:
            texel = of.rough.at(si, active)
            roughness, metallic = roughness * texel[1], metallic * texel[2]
        here.viewer = si.to_world(si.wi)
        here.geometric = dr.normalize(dr.mulsign(mi.Vector3f(si.n), dr.dot(si.n, here.viewer)))
        normal = here.geometric
        if of.has_normals:
            normal = dr.normalize(mi.Vector3f(attribute("normal", si, 3, active)))
        if of.bumps is not None:
            normal = self.mapped(normal, si, active)
        normal = dr.mulsign(normal, dr.dot(normal, here.geometric))
        facing = dr.dot(normal, here.viewer)
        bent = dr.normalize(normal + (MIN_FACING - facing) * here.viewer)
        here.frame = mi.Frame3f(dr.select(facing < MIN_FACING, bent, normal))
        here.out = here.frame.to_local(here.viewer)
        here.diffuse = color * (1 - metallic)
        here.f0, here.f90 = mi.Color3f(of.dielectric_f0), mi.Float(of.dielectric_f90)
        if of.tint is not None:
            here.f0 *= mi.Color3f(of.tint.at(si, active)[:3])
        if of.strength is not None:
            here.f90 *= of.strength.at(si, active)[3]
        here.f0 = dr.minimum(here.f0, 1) * here.f90
        here.color, here.metallic = color, metallic
        here.mirror = roughness < MIRROR_ROUGHNESS
        here.lobe = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, dr.maximum(dr.square(roughness), 1e-4))
        here.alpha = dr.maximum(dr.square(roughness), 1e-4)
        # The chance of the lobe, which may be any that is above 0 where the lobe is.
        dielectric, metal = self.fresnel(here, here.out.z)
        specular = mi.luminance(dr.lerp(dielectric, metal, metallic))
        share = specular / dr.maximum(specular + mi.luminance(here.diffuse), 1e-10)
        share = dr.select(dr.max(here.diffuse) > 0, dr.clip(share, 0.1, 0.9), 1)
        here.chance = share if of.specular else mi.Float(0)
        return here

    def mapped(self, normal, si, active):
        tangent = mi.Vector3f(attribute("tangent", si, 3, active))
        tangent = dr.normalize(tangent - normal * dr.dot(normal, tangent))
        bitangent = dr.cross(normal, tangent) * dr.sign(attribute("side", si, 1, active))
        turned = 2 * mi.Vector3f(self.of.bumps.at(si, active)[:3]) - 1
        turned = turned * mi.Vector3f(self.of.normal_scale, self.of.normal_scale, 1)
        result = dr.normalize(tangent * turned.x + bitangent * turned.y + normal * turned.z)
        side = dr.mulsign(mi.Vector3f(si.n), dr.dot(si.n, normal))
        facing = dr.dot(result, side)
        return dr.select(facing < MIN_FACING, dr.normalize(result + (MIN_FACING - facing) * side), result)

    def fresnel(self, here, cosine):
        """Schlick's, of the dielectric and of the metal."""
        grazing = dr.power(dr.clip(1 - cosine, 0, 1), 5)
        return here.f0 + (here.f90 - here.f0) * grazing, here.color + (1 - here.color) * grazing

    def value(self, here, direction):
        """The BSDF times the cosine, and the density."""
        to = here.frame.to_local(direction)
        lit = (here.out.z > 0) & (to.z > 0) & (dr.dot(direction, here.geometric) > 0)
        half = dr.normalize(here.out + to)
        cosine = dr.dot(to, half)
        f = here.diffuse / dr.pi
        density = (1 - here.chance) * to.z / dr.pi
        if self.of.specular:
            dielectric, metal = self.fresnel(here, cosine)
            a = dr.square(here.alpha)
            visibility = 0.5 / (to.z * dr.sqrt(a + (1 - a) * dr.square(here.out.z))
                                + here.out.z * dr.sqrt(a + (1 - a) * dr.square(to.z)))
            lobe = dr.select(here.mirror, 0, here.lobe.eval(half) * visibility)
            f = (f * (1 - dr.max(dielectric)) + dr.lerp(dielectric, metal, here.metallic) * lobe)
            density += here.chance * dr.select(here.mirror, 0, here.lobe.pdf(here.out, half) / (4 * cosine))
        lit &= density > 0
        return dr.select(lit, f * to.z, 0), dr.select(lit, density, 0)

    def sample(self, ctx, si, sample1, sample2, active=True):
        here = self.at(si, active)
        lobe = sample1 < here.chance
        to = mi.warp.square_to_cosine_hemisphere(sample2)
        if self.of.specular:
            half, _ = here.lobe.sample(here.out, sample2)
            half = dr.select(here.mirror, mi.Normal3f(0, 0, 1), half)
            to = dr.select(lobe, mi.reflect(here.out, half), to)
        direction = here.frame.to_world(to)
        value, density = self.value(here, direction)
        mirror = lobe & here.mirror
        dielectric, metal = self.fresnel(here, here.out.z)
        weight = dr.select(mirror, dr.lerp(dielectric, metal, here.metallic) / here.chance, value / density)
        good = active & (dr.dot(direction, here.geometric) > 0) & (to.z > 0) & (mirror | (density > 0))
        bs = mi.BSDFSample3f()
        bs.wo = si.to_local(direction)
        bs.pdf = dr.select(good, dr.select(mirror, here.chance, density), 0)
        bs.eta = 1.0
        bs.sampled_type = dr.select(
            mirror, mi.UInt32(+mi.BSDFFlags.DeltaReflection), mi.UInt32(+mi.BSDFFlags.GlossyReflection)
        )
        bs.sampled_component = dr.select(mirror, mi.UInt32(1), mi.UInt32(0))
        return bs, dr.select(good, weight, 0)

    def eval(self, ctx, si, wo, active=True):
        return self.eval_pdf(ctx, si, wo, active)[0]

    def pdf(self, ctx, si, wo, active=True):
        return self.eval_pdf(ctx, si, wo, active)[1]

    def eval_pdf(self, ctx, si, wo, active=True):
        value, density = self.value(self.at(si, active), si.to_world(wo))
        return dr.select(active, value, 0), dr.select(active, density, 0)

    def eval_pdf_sample(self, ctx, si, wo, sample1, sample2, active=True):
        value, density = self.eval_pdf(ctx, si, wo, active)
        return value, density, *self.sample(ctx, si, sample1, sample2, active)

    def to_string(self):
        return "Surface[]"
