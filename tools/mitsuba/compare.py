"""A scene rendered by Headwater and by Mitsuba, and how far they are apart."""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import mitsuba as mi
import numpy as np

import files

mi.set_variant("llvm_ad_rgb")

import surface  # noqa: E402: its classes are of the variant

# Mitsuba's samples are drawn in so many passes, whose means tell how far the mean may be off.
PASSES = 16


def run(*arguments):
    """Headwater with these arguments; returns what it prints."""
    command = [os.environ["HEADWATER_RUN"], *map(str, arguments)]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    if done.returncode:
        raise SystemExit(done.returncode)
    return done.stdout


def linear(srgb):
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def image(name, texture, is_color):
    if texture is None:
        return None
    texels = texture.texels
    if is_color:
        texels = np.concatenate([linear(texels[..., :3]), texels[..., 3:]], -1)
    return surface.Image(name, texels, texture.wrap, texture.nearest)


def bsdf(mesh):
    """The surface of a mesh; one for all meshes that carry the same."""
    material = mesh.material
    key = (id(material), mesh.colors is not None, mesh.normals is not None)
    if key in bsdfs:
        return bsdfs[key]
    made = surface.Surface(surface.Lobes(
        base_color=[float(x) for x in material.base_color],
        base=image("base", material.base_color_texture, True),
        metallic=material.metallic,
        roughness=material.roughness,
        rough=image("rough", material.rough_texture, False),
        dielectric_f0=[float(x) for x in material.dielectric_f0],
        dielectric_f90=material.dielectric_f90,
        strength=image("strength", material.specular_texture, False),
        tint=image("tint", material.specular_color_texture, True),
        bumps=image("bumps", material.normal_texture, False),
        normal_scale=material.normal_scale,
        alpha=float(material.alpha),
        cutoff=material.cutoff if material.alpha_mode == "MASK" else None,
        specular=material.dielectric_f90 > 0 or material.metallic > 0,
        has_colors=mesh.colors is not None,
        has_normals=mesh.normals is not None,
    ))
    if material.alpha_mode != "OPAQUE":
        # Mitsuba's emitters emit by all of their area, whatever their BSDF lets through.
        if material.emission.any() and (material.alpha < 1 or material.base_color_texture is not None or mesh.colors is not None):
            raise SystemExit("emitters with alpha are not known here")
        made = mi.load_dict({"type": "mask", "opacity": surface.Alpha(made.of), "bsdf": made})
    bsdfs[key] = made
    return made


# By material and by what a mesh carries.
bsdfs = {}


def placed(mesh, texture):
    """The coordinates of a texture on a mesh."""
    if texture.coordinates not in mesh.coordinates:
        raise SystemExit("textures on meshes without their coordinates are not known here")
    return mesh.coordinates[texture.coordinates] @ texture.transform[:, :2].T + texture.transform[:, 2]


def emitter(material):
    texture = material.emissive_texture
    if texture is None:
        return mi.load_dict({"type": "area", "radiance": {"type": "rgb", "value": [float(x) for x in material.emission]}})
    values = linear(texture.texels[..., :3]) * material.emission
    return mi.load_dict({"type": "area", "radiance": surface.Glow(surface.Image("", values, texture.wrap, texture.nearest))})


def shapes(mesh, size):
    """A mesh; twice if it emits from both sides, since Mitsuba's lights have one."""
    material = mesh.material
    emits = bool(material.emission.any())
    for side in [1.0, -1.0] if emits and material.double_sided else [1.0]:
        triangles = mesh.triangles if side > 0 else mesh.triangles[:, [0, 2, 1]]
        positions = mesh.positions
        if emits and material.double_sided:
            corners = positions[triangles]
            normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            away = normal.sum(0) / max(np.linalg.norm(normal.sum(0)), 1e-30)
            positions = positions + away * 1e-5 * size
        properties = mi.Properties()
        properties["bsdf"] = bsdf(mesh)
        if emits:
            properties["emitter"] = emitter(material)
        glows = emits and material.emissive_texture is not None
        made = mi.Mesh("mesh", len(positions), len(triangles), properties, has_vertex_texcoords=glows)
        values = mi.traverse(made)
        values["vertex_positions"] = positions.ravel().astype(np.float32)
        values["faces"] = triangles.ravel().astype(np.uint32)
        if glows:
            values["vertex_texcoords"] = placed(mesh, material.emissive_texture).ravel().astype(np.float32)
        values.update()
        carried = {}
        if mesh.normals is not None:
            carried["normal"] = mesh.normals
        if mesh.colors is not None:
            carried["color"], carried["alpha"] = mesh.colors[:, :3], mesh.colors[:, 3:]
        if mesh.tangents is not None:
            carried["tangent"], carried["side"] = mesh.tangents[:, :3], mesh.tangents[:, 3:]
        for name, texture in (
            ("base", material.base_color_texture), ("rough", material.rough_texture), ("bumps", material.normal_texture),
            ("strength", material.specular_texture), ("tint", material.specular_color_texture),
        ):
            if texture is not None:
                carried[name] = np.pad(placed(mesh, texture), ((0, 0), (0, 1)))
        for name, of in carried.items():
            made.add_attribute(f"vertex_{name}", of.shape[1], of.ravel().astype(np.float32))
        yield made


def environment(path):
    """Headwater's middle column looks along −Z, Mitsuba's along +Z; and Mitsuba's outer rows are at the poles."""
    texels = np.array(mi.Bitmap(str(path)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False))
    height, width, _ = texels.shape
    rows = np.clip((np.arange(2 * height + 1) / (2 * height)) * height - 0.5, 0, height - 1)
    low = np.minimum(rows.astype(int), height - 2)
    part = (rows - low)[:, None, None]
    texels = texels[low] * (1 - part) + texels[low + 1] * part
    turn = mi.ScalarTransform4f().rotate([0, 1, 0], 180)
    return {"type": "envmap", "bitmap": mi.Bitmap(texels.astype(np.float32)), "to_world": turn}


def look_at(scene, text):
    """Eye, target and vertical field of view: those asked for, the scene's, or some that show all of it."""
    if text is not None:
        numbers = [float(x) for x in text.split(",")]
        return numbers[:3], numbers[3:6], numbers[6] if len(numbers) > 6 else 45.0
    if scene.camera is not None:
        eye = scene.camera.to_world[:3, 3]
        return list(eye), list(eye - scene.camera.to_world[:3, 2]), scene.camera.fov
    low, high = scene.bounds()
    center, radius = (low + high) / 2, np.linalg.norm(high - low) / 2
    away = np.array([0.5, 0.4, 1.0])
    return list(center + away / np.linalg.norm(away) * radius / np.sin(np.radians(20.0))), list(center), 40.0


def passes(scene, view, options):
    """Pictures of Mitsuba with different seeds, which have all samples together."""
    eye, target, fov = view
    low, high = scene.bounds()
    size = float(np.linalg.norm(high - low))
    parts = {
        "type": "scene",
        # It alone of Mitsuba's integrators lets light pass what covers a part, without counting it as a bounce.
        "integrator": {"type": "volpath", "max_depth": options.bounces + 1, "rr_depth": 1000},
        "sensor": {
            "type": "perspective",
            "fov": float(fov),
            "fov_axis": "y",
            "near_clip": 1e-5 * size,
            "far_clip": 1e5 * size,
            "to_world": mi.ScalarTransform4f().look_at(list(map(float, eye)), list(map(float, target)), [0, 1, 0]),
            "film": {
                "type": "hdrfilm",
                "width": options.width,
                "height": options.height,
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
                "component_format": "float32",
            },
        },
    }
    if options.environment:
        parts["environment"] = environment(options.environment)
    for light in scene.lights:
        value = {"type": "rgb", "value": [float(x) for x in light.color]}
        if light.position is not None:
            place = [float(x) for x in light.position]
            parts[f"light{len(parts)}"] = {"type": "point", "intensity": value, "position": place}
        else:
            direction = [float(x) for x in light.direction]
            parts[f"light{len(parts)}"] = {"type": "directional", "irradiance": value, "direction": direction}
    for mesh in scene.meshes:
        for shape in shapes(mesh, size):
            parts[f"mesh{len(parts)}"] = shape
    loaded = mi.load_dict(parts)
    made = []
    for seed in range(PASSES):
        picture = np.array(mi.render(loaded, spp=max(1, options.spp // PASSES), seed=seed), np.float64)
        if not np.isfinite(picture).all():
            raise SystemExit("Mitsuba's picture has values that are not finite")
        made.append(picture)
    return np.array(made)


def mean_and_error(pictures, mask):
    means = pictures[:, mask].mean((1, 2))
    return means.mean(), means.std(ddof=1) / len(means) ** 0.5


def compare(ours, theirs, mask):
    """The ratio of means over some pixels, and its standard error."""
    mean, error = ours["RGB"][mask].mean(), (ours["stderr"][mask] ** 2).sum() ** 0.5 / (3 * mask.sum())
    # Channels of a pixel share their paths: at worst they err together.
    error *= 3**0.5
    their_mean, their_error = mean_and_error(theirs, mask)
    if mean <= 0 or their_mean <= 0:
        raise SystemExit("a picture is black: does the scene have light?")
    ratio = mean / their_mean
    return ratio, ratio * ((error / mean) ** 2 + (their_error / their_mean) ** 2) ** 0.5


def channels(path):
    """The channels of Headwater's picture, by layer."""
    picture = mi.Bitmap(str(path))
    names = [field.name for field in picture.struct_()]
    values = np.array(picture, np.float64)

    def layer(*wanted):
        return np.stack([values[..., names.index(name)] for name in wanted], -1)

    return {"RGB": layer(*"RGB"), "stderr": layer(*(f"stderr.{c}" for c in "RGB")), "depth": layer("depth.Z")[..., 0]}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", type=pathlib.Path, help="a file: .gltf, .glb, .obj")
    parser.add_argument("--full", action="store_true", help="surfaces as in glTF 2.0, appendix B, instead of Lambert")
    parser.add_argument("--environment", help="an image, .exr, or a sky such as sky:sun=40")
    parser.add_argument("--look-at", metavar="EX,EY,EZ,TX,TY,TZ[,DEGREES]")
    parser.add_argument("--width", type=int, default=320)
    parser.add_argument("--height", type=int, default=240)
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--bounces", type=int, default=5)
    parser.add_argument("-o", "--output", type=pathlib.Path, help="a folder that keeps both pictures")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        output = options.output or folder
        output.mkdir(parents=True, exist_ok=True)
        rendered = options.scene
        if options.scene.suffix == ".obj":
            if options.full:
                raise SystemExit("--full is of glTF alone")
            scene, obj, mtl, images = files.obj_scene(options.scene)
            rendered = folder / "rendered.obj"
            rendered.write_text(obj)
            (folder / "rendered.mtl").write_text(mtl)
            for name, data in images.items():
                (folder / name).write_bytes(data)
        else:
            gltf = files.Gltf(options.scene, options.full)
            scene = gltf.scene()
            rendered = folder / "rendered.glb"
            rendered.write_bytes(files.rendered_gltf(gltf))
        if options.environment and options.environment.startswith("sky"):
            sky = folder / "sky.exr"
            run("scene", "generate", options.environment, "-o", sky)
            options.environment = str(sky)
        view = look_at(scene, options.look_at)
        ours, theirs = output / "headwater.exr", output / "mitsuba.exr"
        numbers = ",".join(repr(float(x)) for x in [*view[0], *view[1], view[2]])
        arguments = ["reference", rendered, "-o", ours, "--spp", options.spp, "--bounces", options.bounces, "--jitter", "on"]
        arguments += ["--width", options.width, "--height", options.height, f"--look-at={numbers}"]
        arguments += ["--allow-missing"] if rendered.suffix != ".obj" else []
        arguments += ["--environment", options.environment] if options.environment else []
        run(*arguments, "--aov", "depth")
        pictures = passes(scene, view, options)
        mi.Bitmap(pictures.mean(0).astype(np.float32)).write(str(theirs))
        flip = json.loads(run("compare", ours, theirs, "--json"))["flip"]
        found = channels(ours)
        everywhere, objects = np.full(found["depth"].shape, True), found["depth"] > 0
        line = "{} ratio of means {:.4f} ± {:.4f}".format(options.scene.stem, *compare(found, pictures, everywhere))
        if not objects.all():
            line += ", of objects {:.4f} ± {:.4f}".format(*compare(found, pictures, objects))
        print(f"{line}, FLIP {flip:.3f}")


if __name__ == "__main__":
    try:
        main()
    except (OSError, ValueError, KeyError) as error:
        sys.exit(f"compare-with-mitsuba: {type(error).__name__}: {error}")
