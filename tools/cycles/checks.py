"""Small glTF files, each for one feature that Blender's importer reads, which both renderers must show alike."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from small_files import SmallFile


@dataclass
class Check:
    """A file and how it is rendered. `lambert` removes what both renderers define differently."""

    name: str
    document: Callable
    lambert: bool = False
    environment: str = "none"
    look_at: str | None = "1,3,4,0,0.3,0,40"
    start_time: float = 0.0
    variant: str | None = None
    # Options of Blender's exporter, which writes the file that Headwater reads.
    exported: dict | None = None


MATTE = {"KHR_materials_specular": {"specularFactor": 0.0}}
BLACK = {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0, "roughnessFactor": 1}


def matte(color=(0.8, 0.8, 0.8, 1.0), **more):
    """A diffuse material: without its specular lobe both renderers have the same one."""
    extensions = {**MATTE, **more.pop("extensions", {})}
    pbr = {"baseColorFactor": list(color), "metallicFactor": 0.0, **more.pop("pbr", {})}
    return {"pbrMetallicRoughness": pbr, "doubleSided": True, "extensions": extensions, **more}


def emitter(color, strength=1.0, **more):
    glow = {"KHR_materials_emissive_strength": {"emissiveStrength": strength}}
    return {"pbrMetallicRoughness": BLACK, "emissiveFactor": list(color), "extensions": {**MATTE, **glow}, **more}


def stage(file):
    """A floor with a box on it."""
    file.place(file.quad(file.material(matte())), scale=[3, 1, 3])
    file.place(file.box(file.material(matte((0.7, 0.3, 0.2, 1.0)))), translation=[0.3, 0.4, 0.2], rotation=[0, 0.2588, 0, 0.9659], scale=[0.3, 0.4, 0.2])
    return file


def lit(kind, rotation=(-0.5, 0.2, 0.1, 0.83666), **light):
    def document():
        file = stage(SmallFile())
        file.light({"type": kind, "color": [1.0, 0.7, 0.4], **light}, translation=[-0.6, 1.8, 0.9], rotation=list(rotation))
        return file.document()

    return document


def emission():
    """An emitter with a strength and a texture, which shines from one side."""
    file = stage(SmallFile())
    texture = file.texture(colors())
    lamp = emitter([1.0, 0.8, 0.6], 9.0, emissiveTexture={"index": texture})
    file.place(file.quad(file.material(lamp)), translation=[-0.4, 1.5, 0.3], rotation=[1, 0, 0, 0], scale=[0.4, 1, 0.4])
    return file.document()


def camera(parameters):
    """Emitters of several colours, seen by a camera of the file, whose node is scaled."""

    def document():
        file = SmallFile()
        for x, y, color in ((0, 0, [1, 1, 1]), (1.1, 0.4, [1, 0, 0]), (-0.8, 0.7, [0, 1, 0]), (0.3, -0.6, [0, 0, 1])):
            quad = file.quad(file.material(emitter(color, doubleSided=True)))
            file.place(quad, translation=[x, y, -3], rotation=[0.7071, 0, 0, 0.7071], scale=[0.3, 1, 0.2])
        file.camera(parameters, translation=[0.2, 0.1, 1.0], rotation=[0, 0, 0.08716, 0.99619], scale=[2, 2, 2])
        return file.document()

    return document


def colors(alpha=False):
    """4 × 3 texels of all kinds of colours."""
    values = np.random.default_rng(1).integers(20, 255, (3, 4, 4), np.uint8)
    if not alpha:
        values[..., 3] = 255
    return values


def textured(sampler=None, transform=None, **more):
    def document():
        file = SmallFile()
        info = {"index": file.texture(colors("alphaMode" in more), sampler)}
        if transform is not None:
            info["extensions"] = {"KHR_texture_transform": transform}
        file.place(file.quad(file.material(matte(pbr={"baseColorTexture": info}, **more)), repeat=2.3), translation=[0, 0.5, 0])
        file.place(file.quad(file.material(matte((0.9, 0.5, 0.1, 1.0)))), scale=[3, 1, 3])
        return file.document()

    return document


def vertex_colors():
    file = SmallFile()
    shades = np.array([[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 255]], np.uint8)
    file.place(file.quad(file.material(matte((0.9, 0.8, 0.7, 1.0))), colors=shades))
    return file.document()


def unlit():
    """An unlit surface over a floor: it neither receives light nor gives any."""
    file = stage(SmallFile())
    plain = {"pbrMetallicRoughness": {"baseColorFactor": [0.2, 0.9, 0.4, 1.0]}, "extensions": {"KHR_materials_unlit": {}}, "doubleSided": True}
    file.place(file.quad(file.material(plain)), translation=[-0.5, 0.6, 0.4], rotation=[0.2588, 0, 0, 0.9659], scale=[0.5, 1, 0.3])
    return file.document()


def backs():
    """Surfaces with one side: the camera looks through their backs, other rays do not. One is mirrored."""
    file = stage(SmallFile())
    one_side = file.material(matte((0.2, 0.3, 0.9, 1.0), doubleSided=False))
    for x, scale in ((-0.8, [0.4, 1, 0.3]), (0.8, [-0.4, 1, 0.3])):
        for z, rotation in ((0.7, [0.2588, 0, 0, 0.9659]), (-0.3, [0.9659, 0, 0, -0.2588])):
            file.place(file.quad(one_side), translation=[x, 0.8, z], rotation=rotation, scale=scale)
    return file.document()


def quantized():
    """Positions, normals and texture coordinates as integers."""
    file = SmallFile()
    info = {"index": file.texture(colors()), "extensions": {"KHR_texture_transform": {"scale": [1.5, 2.5], "offset": [0.1, 0.2]}}}
    material = file.material(matte(pbr={"baseColorTexture": info}))
    file.place(file.quad(material, quantized=True), translation=[0.1, 0.2, 0.0], scale=[0.0001, 0.0001, 0.0001])
    file.uses("KHR_mesh_quantization", required=True)
    return file.document()


def instances():
    file = stage(SmallFile())
    file.instances(
        file.box(file.material(matte((0.2, 0.6, 0.3, 1.0)))),
        TRANSLATION=[[-1, 0.2, 0.5], [-0.6, 0.3, -0.7], [1.1, 0.2, -0.3]],
        ROTATION=[[0, 0, 0, 1], [0, 0.3827, 0, 0.9239], [0.2588, 0, 0, 0.9659]],
        SCALE=[[0.2, 0.2, 0.2], [0.1, 0.3, 0.2], [0.3, 0.1, 0.1]],
    )
    return file.document()


def metals():
    """Rough metals, flat: both renderers have GGX with one scattering and Schlick's Fresnel term."""
    file = SmallFile()
    for index, roughness in enumerate((0.25, 0.45, 0.7, 1.0)):
        pbr = {"baseColorFactor": [0.9, 0.6, 0.3, 1.0], "metallicFactor": 1.0, "roughnessFactor": roughness}
        quad = file.quad(file.material({"pbrMetallicRoughness": pbr, "doubleSided": True}))
        file.place(quad, translation=[index % 2 - 0.5, 0.3, index // 2 - 0.5], rotation=[0.1, 0.05 * index, 0, 0.99], scale=[0.45, 1, 0.45])
    return file.document()


def reflectance(textures=False):
    """Black dielectric mirrors, seen from above: `KHR_materials_specular` and `KHR_materials_ior` at normal incidence,
    where the Fresnel terms of the two renderers agree."""

    def document():
        file = SmallFile()
        pbr = {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0.0, "roughnessFactor": 0.0}
        for index, (factor, color, ior) in enumerate(((1, [1, 1, 1], 1.5), (0.5, [1, 1, 1], 1.5), (1, [0.9, 0.5, 0.2], 1.5), (1, [1, 1, 1], 1.9))):
            specular = {"specularFactor": factor, "specularColorFactor": color}
            if textures:
                specular["specularTexture"] = {"index": file.texture(colors(alpha=True))}
                specular["specularColorTexture"] = {"index": file.texture(colors())}
            extensions = {"KHR_materials_specular": specular, "KHR_materials_ior": {"ior": ior}}
            quad = file.quad(file.material({"pbrMetallicRoughness": pbr, "doubleSided": True, "extensions": extensions}))
            file.place(quad, translation=[index % 2 - 0.5, 0, index // 2 - 0.5], scale=[0.45, 1, 0.45])
        return file.document()

    return document


def normal_map():
    """A matte surface with a normal map, once mirrored."""
    file = SmallFile()
    slopes = np.random.default_rng(2).uniform(-0.3, 0.3, (4, 4, 2))
    normals = np.concatenate([slopes, np.ones((4, 4, 1))], -1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    texels = np.concatenate([np.round(normals * 127.5 + 127.5), np.full((4, 4, 1), 255)], -1).astype(np.uint8)
    material = file.material(matte(normalTexture={"index": file.texture(texels)}))
    for x, scale in ((-0.55, [0.5, 0.5, 0.5]), (0.55, [-0.5, 0.5, 0.5])):
        file.place(file.quad(material, normals=True), translation=[x, 0, 0], scale=scale)
    file.light({"type": "directional", "intensity": 3.0}, rotation=[-0.5, 0.2, 0.1, 0.83666])
    return file.document()


def variants():
    """`KHR_materials_variants`: the second of two, for one of two meshes."""
    file = stage(SmallFile())
    file.json.setdefault("extensions", {})["KHR_materials_variants"] = {"variants": [{"name": "red"}, {"name": "green"}]}
    file.uses("KHR_materials_variants")
    own, red, green = (file.material(matte((*color, 1.0))) for color in ([0.5, 0.5, 0.5], [0.9, 0.1, 0.1], [0.1, 0.8, 0.2]))
    mesh = file.box(own)
    mappings = [{"material": red, "variants": [0]}, {"material": green, "variants": [1]}]
    file.json["meshes"][mesh]["primitives"][0]["extensions"] = {"KHR_materials_variants": {"mappings": mappings}}
    file.place(mesh, translation=[-0.7, 0.3, 0.5], scale=[0.3, 0.3, 0.3])
    return file.document()


def motion():
    """Translation and rotation by keyframes, between two of them."""
    file = stage(SmallFile())
    node = file.place(file.box(file.material(matte((0.2, 0.6, 0.3, 1.0)))), scale=[0.2, 0.2, 0.2])
    file.animate(node, "translation", [0.0, 1.0], [[-1.0, 0.2, 0.5], [0.0, 0.6, 1.0]])
    file.animate(node, "rotation", [0.0, 1.0], [[0, 0, 0, 1], [0, 0.7071, 0, 0.7071]])
    return file.document()


def animated_emission():
    """`KHR_animation_pointer`: the colour of an emitter by keyframes."""
    file = stage(SmallFile())
    lamp = file.material(emitter([1.0, 0.8, 0.6], 9.0, doubleSided=True))
    file.place(file.quad(lamp), translation=[-0.4, 1.5, 0.3], scale=[0.4, 1, 0.4])
    file.animate(None, f"/materials/{lamp}/emissiveFactor", [0.0, 1.0], [[1.0, 0.0, 0.0], [0.0, 0.5, 1.0]])
    return file.document()


ABOVE = "0,8,0.001,0,0,0,16"
CHECKS = [
    Check("camera", camera({"type": "perspective", "perspective": {"yfov": 0.6, "aspectRatio": 1.5, "znear": 0.1}}), look_at=None),
    Check("orthographic-camera", camera({"type": "orthographic", "orthographic": {"xmag": 1.5, "ymag": 1.0, "znear": 0.1, "zfar": 100}}), look_at=None),
    Check("emission", emission),
    Check("point-light", lit("point", intensity=5.0)),
    Check("directional-light", lit("directional", intensity=3.0)),
    Check("spot-light", lit("spot", intensity=9.0, spot={"innerConeAngle": 0.2, "outerConeAngle": 0.6})),
    Check("texture-transform", textured(transform={"offset": [0.2, 0.3], "rotation": 0.5, "scale": [0.7, 1.6]}), environment="neutral"),
    Check("texture-wrap", textured({"wrapS": 33648, "wrapT": 33071}), environment="neutral"),
    Check("mask", textured(alphaMode="MASK", alphaCutoff=0.5), environment="neutral"),
    Check("blend", textured(alphaMode="BLEND"), environment="neutral"),
    Check("vertex-colors", vertex_colors, environment="neutral"),
    Check("unlit", unlit, environment="neutral"),
    Check("backs", backs, environment="neutral"),
    Check("quantization", quantized, environment="neutral"),
    Check("instances", instances, environment="neutral"),
    Check("metals", metals, environment="neutral"),
    Check("reflectance", reflectance(), environment="neutral", look_at=ABOVE),
    Check("reflectance-textures", reflectance(True), environment="neutral", look_at=ABOVE),
    Check("normal-map", normal_map),
    Check("variants", variants, environment="neutral", variant="green"),
    Check("motion", motion, environment="neutral", start_time=0.5),
    Check("animation-pointer", animated_emission, start_time=0.5),
    Check("draco", instances, environment="neutral", exported={
        "export_draco_mesh_compression_enable": True, "export_draco_position_quantization": 24, "export_draco_normal_quantization": 24}),
    Check("webp", textured(), environment="neutral", exported={"export_image_format": "WEBP", "export_image_quality": 100}),
]
