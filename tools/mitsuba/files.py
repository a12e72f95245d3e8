"""Scenes in files, read independently of Headwater: glTF 2.0 and OBJ.

Everything is brought to world space in 64 bits. What the comparison does not know is an error, not an approximation.
"""

import base64
import io
import json
import pathlib
import struct
import urllib.parse
from dataclasses import dataclass, field

import numpy as np
from PIL import Image

# Extensions that a file may require.
KNOWN = {
    "KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_materials_ior", "KHR_materials_specular",
    "KHR_materials_unlit", "KHR_mesh_quantization", "KHR_texture_transform",
}
COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


@dataclass
class Texture:
    """An image of values 0…1 in four channels, rows from the top; colours are still sRGB."""

    texels: np.ndarray
    wrap: tuple = ("repeat", "repeat")
    nearest: bool = False
    # Which coordinates it has, and what is done to them: a matrix of 2 × 3.
    coordinates: int = 0
    transform: np.ndarray = field(default_factory=lambda: np.eye(2, 3))


@dataclass
class Material:
    name: str = ""
    base_color: np.ndarray = field(default_factory=lambda: np.ones(3))
    base_color_texture: Texture | None = None
    alpha: float = 1.0
    alpha_mode: str = "OPAQUE"
    cutoff: float = 0.5
    emission: np.ndarray = field(default_factory=lambda: np.zeros(3))
    emissive_texture: Texture | None = None
    double_sided: bool = False
    # Of the full model; Lambert surfaces have none of it.
    metallic: float = 0.0
    roughness: float = 1.0
    rough_texture: Texture | None = None
    # Before the limit of 1, and before the strength multiplies it.
    dielectric_f0: np.ndarray = field(default_factory=lambda: np.zeros(3))
    dielectric_f90: float = 0.0
    specular_texture: Texture | None = None
    specular_color_texture: Texture | None = None
    normal_texture: Texture | None = None
    normal_scale: float = 1.0


@dataclass
class Mesh:
    """Triangles of one material; counter-clockwise is the front."""

    positions: np.ndarray
    triangles: np.ndarray
    material: Material
    normals: np.ndarray | None = None
    coordinates: dict = field(default_factory=dict)
    colors: np.ndarray | None = None
    # Of the full model, and in w the side of the bitangent.
    tangents: np.ndarray | None = None


@dataclass
class Camera:
    """It looks along −Z of `to_world`; the field of view is the vertical one, in degrees."""

    to_world: np.ndarray
    fov: float


@dataclass
class Light:
    """A point, or without a position a direction in which light goes."""

    color: np.ndarray
    position: np.ndarray | None = None
    direction: np.ndarray | None = None


@dataclass
class Scene:
    meshes: list
    camera: Camera | None = None
    lights: list = field(default_factory=list)

    def bounds(self):
        low = np.min([m.positions.min(0) for m in self.meshes], 0)
        return low, np.max([m.positions.max(0) for m in self.meshes], 0)


class Gltf:
    """A glTF file with its buffers."""

    def __init__(self, path, full):
        self.full = full
        data = path.read_bytes()
        self.folder = path.parent
        self.binary = None
        if data[:4] == b"glTF":
            length = struct.unpack_from("<I", data, 12)[0]
            self.document = json.loads(data[20 : 20 + length])
            if 20 + length < len(data):
                size = struct.unpack_from("<I", data, 20 + length)[0]
                self.binary = data[28 + length : 28 + length + size]
        else:
            self.document = json.loads(data)
        self.name_materials()
        required = set(self.list("extensionsRequired")) - KNOWN
        if required:
            raise SystemExit(f"{', '.join(sorted(required))} is not known here")
        self.buffers = [self.binary if "uri" not in b else self.bytes_of(b["uri"]) for b in self.list("buffers")]

    def name_materials(self):
        """Gives primitives without a material glTF's default one, so that both renderers read the same of it."""
        materials = self.document.setdefault("materials", [])
        lacking = [p for m in self.list("meshes") for p in m["primitives"] if "material" not in p]
        for primitive in lacking:
            primitive["material"] = len(materials)
        if lacking:
            materials.append({})

    def list(self, name):
        return self.document.get(name, [])

    def bytes_of(self, uri):
        if uri.startswith("data:"):
            return base64.b64decode(uri.split(",", 1)[1])
        return (self.folder / urllib.parse.unquote(uri)).read_bytes()

    def view(self, index):
        view = self.document["bufferViews"][index]
        start = view.get("byteOffset", 0)
        return self.buffers[view["buffer"]][start : start + view["byteLength"]], view.get("byteStride")

    def array(self, index):
        accessor = self.document["accessors"][index]
        if "sparse" in accessor:
            raise SystemExit("sparse accessors are not known here")
        kind = np.dtype(COMPONENTS[accessor["componentType"]])
        width = WIDTHS[accessor["type"]]
        data, stride = self.view(accessor["bufferView"])
        values = np.ndarray(
            (accessor["count"], width), kind, data, accessor.get("byteOffset", 0),
            (stride or width * kind.itemsize, kind.itemsize),
        )
        if accessor.get("normalized"):
            return np.maximum(values / np.iinfo(kind).max, -1.0)
        return values.astype(np.float64) if kind.kind == "f" else values.astype(np.int64)

    def texture(self, info):
        """None where its image is missing."""
        if info is None:
            return None
        extensions = dict(info.get("extensions", {}))
        moved = extensions.pop("KHR_texture_transform", {})
        if extensions:
            raise SystemExit(f"textures with {list(extensions)} are not known here")
        texture = self.document["textures"][info["index"]]
        webp = texture.get("extensions", {}).get("EXT_texture_webp", texture)
        image = self.document["images"][webp["source"]]
        sampler = self.list("samplers")[texture["sampler"]] if "sampler" in texture else {}
        try:
            data = self.bytes_of(image["uri"]) if "uri" in image else self.view(image["bufferView"])[0]
        except FileNotFoundError:
            return None
        wrap = {10497: "repeat", 33648: "mirror", 33071: "clamp"}
        image = Image.open(io.BytesIO(data))
        if image.mode not in ("1", "L", "LA", "P", "PA", "RGB", "RGBA", "RGBX"):
            raise SystemExit(f"images of mode {image.mode} are not known here")
        scale, turn = np.diag(moved.get("scale", [1.0, 1.0])), moved.get("rotation", 0.0)
        # As the extension's words and its test model have it, against its code: counter-clockwise, with v downwards.
        turn = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        return Texture(
            np.asarray(image.convert("RGBA"), np.float64) / 255.0,
            wrap=tuple(wrap[sampler.get(key, 10497)] for key in ("wrapS", "wrapT")),
            nearest=sampler.get("magFilter") == 9728,
            coordinates=moved.get("texCoord", info.get("texCoord", 0)),
            transform=np.column_stack([turn @ scale, moved.get("offset", [0.0, 0.0])]),
        )

    def material(self, index):
        source = self.document["materials"][index]
        pbr = source.get("pbrMetallicRoughness", {})
        extensions = source.get("extensions", {})
        strength = extensions.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
        color = np.array(pbr.get("baseColorFactor", [1.0] * 4))
        material = Material(
            name=source.get("name", ""),
            base_color=color[:3],
            base_color_texture=self.texture(pbr.get("baseColorTexture")),
            alpha=color[3],
            alpha_mode=source.get("alphaMode", "OPAQUE"),
            cutoff=source.get("alphaCutoff", 0.5),
            emission=np.array(source.get("emissiveFactor", [0.0] * 3)) * strength,
            emissive_texture=self.texture(source.get("emissiveTexture")),
            double_sided=source.get("doubleSided", False),
        )
        if self.full:
            specular = extensions.get("KHR_materials_specular", {})
            ior = extensions.get("KHR_materials_ior", {}).get("ior", 1.5)
            reflected = ((ior - 1) / (ior + 1)) ** 2 if ior > 0 else 1.0
            material.dielectric_f0 = reflected * np.array(specular.get("specularColorFactor", [1.0] * 3))
            material.dielectric_f90 = specular.get("specularFactor", 1.0)
            material.specular_texture = self.texture(specular.get("specularTexture"))
            material.specular_color_texture = self.texture(specular.get("specularColorTexture"))
            material.metallic, material.roughness = pbr.get("metallicFactor", 1.0), pbr.get("roughnessFactor", 1.0)
            material.rough_texture = self.texture(pbr.get("metallicRoughnessTexture"))
            material.normal_texture = self.texture(source.get("normalTexture"))
            material.normal_scale = source.get("normalTexture", {}).get("scale", 1.0)
        return material

    def light(self, index, to_world):
        """None for a spot, whose falloff Mitsuba does not have: in the file that is rendered it is dark."""
        light = self.document["extensions"]["KHR_lights_punctual"]["lights"][index]
        color = np.array(light.get("color", [1.0] * 3)) * light.get("intensity", 1.0)
        if light["type"] == "point":
            return Light(color, position=to_world[:3, 3])
        if light["type"] == "directional":
            return Light(color, direction=-to_world[:3, 2] / np.linalg.norm(to_world[:3, 2]))
        return None

    def scene(self):
        materials = [self.material(i) for i in range(len(self.list("materials")))]
        scene = Scene([])
        scenes = self.list("scenes")
        roots = scenes[self.document.get("scene", 0)]["nodes"] if scenes else range(len(self.list("nodes")))
        pending = [(root, np.eye(4)) for root in reversed(roots)]
        while pending:
            index, parent = pending.pop()
            node = self.document["nodes"][index]
            to_world = parent @ local(node)
            pending += [(child, to_world) for child in reversed(node.get("children", []))]
            if "camera" in node and scene.camera is None:
                camera = self.document["cameras"][node["camera"]]["perspective"]
                scene.camera = Camera(to_world, np.degrees(camera["yfov"]))
            if "KHR_lights_punctual" in node.get("extensions", {}):
                light = self.light(node["extensions"]["KHR_lights_punctual"]["light"], to_world)
                scene.lights += [light] if light is not None else []
            if "mesh" in node:
                for primitive in self.document["meshes"][node["mesh"]]["primitives"]:
                    scene.meshes.append(self.mesh(primitive, to_world, materials))
        return scene

    def mesh(self, primitive, to_world, materials):
        if primitive.get("mode", 4) != 4:
            raise SystemExit("primitives other than triangles are not known here")
        attributes = primitive["attributes"]
        positions = self.array(attributes["POSITION"])
        count = len(positions)
        indices = self.array(primitive["indices"])[:, 0] if "indices" in primitive else np.arange(count)
        triangles = indices.reshape(-1, 3)
        matrix = to_world[:3, :3]
        # A mirrored mesh keeps its front.
        if np.linalg.det(matrix) < 0:
            triangles = triangles[:, [0, 2, 1]]
        mesh = Mesh(positions @ matrix.T + to_world[:3, 3], triangles, materials[primitive["material"]] if "material" in primitive else Material())
        if "NORMAL" in attributes:
            normals = self.array(attributes["NORMAL"]) @ np.linalg.inv(matrix)
            mesh.normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
        for key, accessor in attributes.items():
            if key.startswith("TEXCOORD_"):
                mesh.coordinates[int(key[9:])] = self.array(accessor)
        if "COLOR_0" in attributes:
            colors = self.array(attributes["COLOR_0"])
            if not np.allclose(colors, 1.0):
                mesh.colors = colors if colors.shape[1] == 4 else np.column_stack([colors, np.ones(count)])
        if mesh.material.normal_texture is not None:
            if "TANGENT" not in attributes:
                raise SystemExit("normal maps on meshes without tangents are not known here")
            tangents = self.array(attributes["TANGENT"])
            mesh.tangents = np.column_stack([tangents[:, :3] @ matrix.T, tangents[:, 3] * np.sign(np.linalg.det(matrix))])
        return mesh


def local(node):
    """A node's transform to its parent."""
    if "matrix" in node:
        return np.array(node["matrix"]).reshape(4, 4).T
    x, y, z, w = node.get("rotation", [0.0, 0.0, 0.0, 1.0])
    turn = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])
    matrix = np.eye(4)
    matrix[:3, :3] = turn * np.array(node.get("scale", [1.0] * 3))
    matrix[:3, 3] = node.get("translation", [0.0] * 3)
    return matrix


def rendered_gltf(gltf):
    """The file as .glb. Spots are dark in it and no surface is unlit; without the full model all surfaces are Lambert."""
    document = json.loads(json.dumps(gltf.document))
    binary = bytearray()
    views = document.setdefault("bufferViews", [])
    starts = []
    for data in gltf.buffers:
        binary += bytes(-len(binary) % 4)
        starts.append(len(binary))
        binary += data
    for view in views:
        view["byteOffset"] = view.get("byteOffset", 0) + starts[view["buffer"]]
        view["buffer"] = 0
    for image in document.get("images", []):
        uri = image.get("uri")
        if uri is None:
            continue
        try:
            data = gltf.bytes_of(uri)
        except FileNotFoundError:
            continue
        binary += bytes(-len(binary) % 4)
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        binary += data
        del image["uri"]
        image["bufferView"] = len(views) - 1
        image["mimeType"] = "image/png" if data[:4] == b"\x89PNG" else "image/jpeg"
    binary += bytes(-len(binary) % 4)
    document["buffers"] = [{"byteLength": len(binary)}]
    for material in document.get("materials", []):
        material.get("extensions", {}).pop("KHR_materials_unlit", None)
        if gltf.full:
            continue
        pbr = material.setdefault("pbrMetallicRoughness", {})
        pbr["metallicFactor"], pbr["roughnessFactor"] = 0.0, 1.0
        pbr.pop("metallicRoughnessTexture", None)
        material.pop("normalTexture", None)
        extensions = material.get("extensions", {})
        kept = {k: v for k, v in extensions.items() if k == "KHR_materials_emissive_strength"}
        material["extensions"] = {**kept, "KHR_materials_specular": {"specularFactor": 0.0}}
    lights = document.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])
    for light in lights:
        # Ranges are a means of speed, and not of Mitsuba's lights.
        light.pop("range", None)
        if light["type"] == "spot":
            light["intensity"] = 0.0
    # Animations would need their own accessors only; the scene is compared at rest.
    document.pop("animations", None)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + len(binary)
    return b"".join([
        struct.pack("<4sII", b"glTF", 2, total), struct.pack("<I4s", len(text), b"JSON"), text,
        struct.pack("<I4s", len(binary), b"BIN\0"), bytes(binary),
    ])


def obj_scene(path):
    """An OBJ whose materials are Kd, map_Kd and Ke, and the same without anything else: texts of .obj and .mtl, images."""
    images = {}
    materials, lines, text = {}, [], path.read_text()
    for name in [line.split(None, 1)[1].strip() for line in text.splitlines() if line.startswith("mtllib")]:
        for line in (path.parent / name).read_text().splitlines():
            key, *rest = line.split() or [""]
            if key == "newmtl":
                current = Material(name=" ".join(rest), base_color=np.full(3, 0.5))
                materials[current.name] = current
                lines.append(line)
            elif key in ("Kd", "Ke"):
                value = np.array([float(x) for x in rest])
                setattr(current, "base_color" if key == "Kd" else "emission", value)
                lines.append(line)
            elif key == "map_Kd":
                name = f"image{len(images)}" + pathlib.Path(line).suffix
                if rest[0].startswith("-"):
                    raise SystemExit("options of map_Kd are not known here")
                images[name] = (path.parent / line.split(None, 1)[1].strip().replace("\\", "/")).read_bytes()
                texels = np.asarray(Image.open(io.BytesIO(images[name])).convert("RGBA"), np.float64) / 255.0
                # Its v points up.
                upwards = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 1.0]])
                current.base_color_texture = Texture(texels, transform=upwards)
                lines.append(f"map_Kd {name}")
            elif key in ("map_d", "map_Ke", "map_Pr", "map_Pm", "norm"):
                raise SystemExit(f"{key} is not known here")
    positions, normals, coordinates, faces, current = [], [], [], {}, Material(base_color=np.full(3, 0.5))
    for line in text.splitlines():
        key, *rest = line.split() or [""]
        if key == "v":
            positions.append([float(x) for x in rest[:3]])
        elif key == "vn":
            normals.append([float(x) for x in rest])
        elif key == "vt":
            coordinates.append([float(x) for x in rest[:2]])
        elif key == "usemtl":
            current = materials[" ".join(rest)]
        elif key == "f":
            corners = [[int(x) if x else 0 for x in (c + "//").split("/")[:3]] for c in rest]
            for i in range(1, len(corners) - 1):
                faces.setdefault(current.name, (current, []))[1].append([corners[0], corners[i], corners[i + 1]])
    positions, normals, coordinates = np.array(positions), np.array(normals), np.array(coordinates)
    scene = Scene([])
    for material, list_of_corners in faces.values():
        corners = np.array(list_of_corners).reshape(-1, 3)
        at = np.where(corners < 0, corners + 1 + np.array([len(positions), len(coordinates), len(normals)]), corners)
        mesh = Mesh(positions[at[:, 0] - 1], np.arange(len(at)).reshape(-1, 3), material)
        if len(normals) and (corners[:, 2] != 0).all():
            mesh.normals = normals[at[:, 2] - 1]
        if material.base_color_texture is not None:
            if (corners[:, 1] == 0).any():
                raise SystemExit("faces with map_Kd and without coordinates are not known here")
            mesh.coordinates[0] = coordinates[at[:, 1] - 1]
        scene.meshes.append(mesh)
    named = [line for line in text.splitlines() if not line.startswith("mtllib")]
    return scene, "mtllib rendered.mtl\n" + "\n".join(named), "\n".join(lines) + "\n", images
