"""A scene rendered by Headwater and by Mitsuba, with Lambert surfaces, and how far they are apart."""

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

mi.set_variant("scalar_rgb")
# One pass has them in one picture, in 32 bits.
SAMPLES_A_PASS = 64


def run(*arguments):
    """Headwater with these arguments; returns what it prints."""
    command = [os.environ["HEADWATER_RUN"], *map(str, arguments)]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    if done.returncode:
        raise SystemExit(done.returncode)
    return done.stdout


def linear(srgb):
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def bitmap(values, texture):
    """A texture of linear values, in one channel or three."""
    return {
        "type": "bitmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(values, np.float32)),
        "raw": True,
        "wrap_mode": texture.wrap,
    }


def color(factor, texture):
    """A colour that an sRGB texture multiplies, if there is any."""
    if texture is None:
        return {"type": "rgb", "value": [float(x) for x in factor]}
    return bitmap(linear(texture.texels[..., :3]) * factor, texture)


def reflectance(mesh):
    material = mesh.material
    if mesh.colors is None:
        return color(material.base_color, material.base_color_texture)
    if material.base_color_texture is not None:
        if np.ptp(mesh.colors[:, :3], axis=0).max() > 1e-6:
            raise SystemExit("vertex colours that vary over a texture are not known here")
        return color(material.base_color * mesh.colors[0, :3], material.base_color_texture)
    return {"type": "mesh_attribute", "name": "vertex_color"}


def surface(mesh):
    material = mesh.material
    bsdf = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": reflectance(mesh)}}
    if material.alpha_mode == "OPAQUE" or material.emission.any():
        return bsdf
    texture = material.base_color_texture
    if texture is None:
        cover = material.alpha if material.alpha_mode == "BLEND" else float(material.alpha >= material.cutoff)
        opacity = float(cover)
    elif material.alpha_mode == "BLEND":
        opacity = bitmap(texture.texels[..., 3:] * material.alpha, texture)
    else:
        # The threshold is of what lies between texels, so these are made finer first.
        fine = mi.Bitmap(np.ascontiguousarray(texture.texels[..., 3:] * material.alpha, np.float32))
        fine = np.array(fine.resample([4 * texture.texels.shape[1], 4 * texture.texels.shape[0]]))
        opacity = bitmap(np.float32(fine.reshape(*fine.shape[:2], 1) >= material.cutoff), texture)
    return {"type": "mask", "opacity": opacity, "bsdf": bsdf}


def shapes(mesh, number, folder, size):
    """A mesh; twice if it emits from both sides, since Mitsuba's lights have one."""
    material = mesh.material
    emits = material.emission.any()
    sides = [1.0, -1.0] if emits and material.double_sided else [1.0]
    for side in sides:
        triangles = mesh.triangles if side > 0 else mesh.triangles[:, [0, 2, 1]]
        # Lights have the normals of their planes, from which they shine.
        normals = None if emits else mesh.normals
        texture = next((t for t in (material.base_color_texture, material.emissive_texture) if t is not None), None)
        coordinates = mesh.coordinates.get(texture.coordinates) if texture is not None else None
        positions = mesh.positions
        if len(sides) > 1:
            corners = positions[triangles]
            normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            away = normal.sum(0) / max(np.linalg.norm(normal.sum(0)), 1e-30)
            positions = positions + away * 1e-5 * size
        made = mi.Mesh(
            "mesh", len(positions), len(triangles),
            has_vertex_normals=normals is not None, has_vertex_texcoords=coordinates is not None,
        )
        if mesh.colors is not None:
            made.add_attribute("vertex_color", 3, (mesh.colors[:, :3] * material.base_color).ravel().astype(np.float32))
        values = mi.traverse(made)
        values["vertex_positions"] = positions.ravel().astype(np.float32)
        values["faces"] = triangles.ravel().astype(np.uint32)
        if normals is not None:
            values["vertex_normals"] = normals.ravel().astype(np.float32)
        if coordinates is not None:
            values["vertex_texcoords"] = coordinates.ravel().astype(np.float32)
        values.update()
        path = str(folder / f"mesh{number}{'+' if side > 0 else '-'}.ply")
        made.write_ply(path)
        shape = {"type": "ply", "filename": path, "face_normals": normals is None, "bsdf": surface(mesh)}
        if emits:
            shape["emitter"] = {"type": "area", "radiance": color(material.emission, material.emissive_texture)}
        yield shape


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


def mitsuba_picture(scene, view, options, folder):
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
    for number, mesh in enumerate(scene.meshes):
        for side, shape in enumerate(shapes(mesh, number, folder, size)):
            parts[f"mesh{number}_{side}"] = shape
    loaded = mi.load_dict(parts)
    total, passes = 0.0, max(1, options.spp // SAMPLES_A_PASS)
    for index in range(passes):
        picture = np.array(mi.render(loaded, spp=min(options.spp, SAMPLES_A_PASS), seed=index))
        total = total + np.nan_to_num(picture.astype(np.float64), nan=0.0, posinf=0.0)
    return total / passes


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", type=pathlib.Path, help="a file: .gltf, .glb, .obj")
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
            scene, obj, mtl = files.obj_scene(options.scene)
            rendered = folder / "lambert.obj"
            rendered.write_text(obj)
            (folder / "lambert.mtl").write_text(mtl)
        else:
            gltf = files.Gltf(options.scene)
            scene = gltf.scene()
            rendered = folder / "lambert.glb"
            rendered.write_bytes(files.lambert_gltf(gltf))
        if options.environment and options.environment.startswith("sky"):
            sky = folder / "sky.exr"
            run("scene", "generate", options.environment, "-o", sky)
            options.environment = str(sky)
        view = look_at(scene, options.look_at)
        ours, theirs = output / "headwater.exr", output / "mitsuba.exr"
        numbers = ",".join(repr(float(x)) for x in [*view[0], *view[1], view[2]])
        arguments = ["reference", rendered, "-o", ours, "--spp", options.spp, "--bounces", options.bounces, "--jitter"]
        arguments += ["--width", options.width, "--height", options.height, f"--look-at={numbers}"]
        arguments += ["--allow-missing"] if rendered.suffix != ".obj" else []
        arguments += ["--environment", options.environment] if options.environment else []
        run(*arguments)
        picture = mitsuba_picture(scene, view, options, folder)
        mi.Bitmap(picture.astype(np.float32)).write(str(theirs))
        compared = json.loads(run("compare", ours, theirs, "--json"))
        wanted = {key: compared[key] for key in ("mean_ratio", "relmse", "flip")}
        print(options.scene.stem, " ".join(f"{key}={value:.5f}" for key, value in wanted.items()))


if __name__ == "__main__":
    try:
        main()
    except (OSError, ValueError, KeyError) as error:
        sys.exit(f"compare-with-mitsuba: {type(error).__name__}: {error}")
