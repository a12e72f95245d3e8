"""Writes the scenes that tools/load-times loads: an OBJ file of many triangles, and a GLB file with textures."""

import io
import json
import math
import struct
from array import array

import numpy
from PIL import Image


def grid(columns, rows, number):
    """A displaced grid of quads, each of two triangles: positions, normals and texture coordinates as flat lists."""
    positions, normals, coordinates = [], [], []
    for j in range(rows + 1):
        y = j / rows
        for i in range(columns + 1):
            x = i / columns
            a, b, c = 7 * x + number, 5 * y, 41 * x + 29 * y
            slope_x = 0.35 * math.cos(a) * math.cos(b) + 0.41 * math.cos(c)
            slope_y = -0.25 * math.sin(a) * math.sin(b) + 0.29 * math.cos(c)
            scale = 1 / math.sqrt(1 + slope_x**2 + slope_y**2)
            positions += (x, y + number, 0.05 * math.sin(a) * math.cos(b) + 0.01 * math.sin(c))
            normals += (-slope_x * scale, -slope_y * scale, scale)
            coordinates += (x, y)
    return positions, normals, coordinates


def corners(columns, rows, first):
    """The corners of the triangles of a grid, as indices of vertices; `first` is that of its first vertex."""
    found = []
    for j in range(rows):
        for i in range(columns):
            a = first + j * (columns + 1) + i
            b = a + columns + 1
            found += (a, a + 1, b + 1, a, b + 1, b)
    return found


def write_obj(path, grids, columns, rows):
    """Writes `grids` objects, each a grid of 2 · `columns` · `rows` triangles, and the texture that they share. Returns the
    size of what a loader holds, in bytes."""
    noise = numpy.random.default_rng(1).integers(0, 256, (256, 256, 3), "u1")
    Image.fromarray(noise).save(path.with_name("stone.png"))
    path.with_suffix(".mtl").write_text("newmtl stone\nKd 1 1 1\nmap_Kd stone.png\n")
    first = 1
    with open(path, "w", buffering=1 << 22) as file:
        file.write(f"mtllib {path.stem}.mtl\n")
        for number in range(grids):
            positions, normals, coordinates = grid(columns, rows, number)
            count = len(coordinates) // 2
            file.write(f"o grid{number}\nusemtl stone\n")
            file.write("v %.6f %.6f %.6f\n" * count % tuple(positions))
            file.write("vt %.6f %.6f\n" * count % tuple(coordinates))
            file.write("vn %.6f %.6f %.6f\n" * count % tuple(normals))
            indices = corners(columns, rows, first)
            thrice = [index for index in indices for _ in range(3)]
            file.write("f %d/%d/%d %d/%d/%d %d/%d/%d\n" * (len(indices) // 3) % tuple(thrice))
            first += count
    return (first - 1) * 32 + grids * columns * rows * 2 * 12 + 256 * 256 * 4


class Glb:
    """A GLB file under construction: its document, and the bytes of its buffer."""

    def __init__(self):
        self.bytes = bytearray()
        self.document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}]}
        for kind in ["nodes", "meshes", "accessors", "bufferViews", "materials", "textures", "images"]:
            self.document[kind] = []

    def add(self, kind, element):
        """Adds an element to a list of the document, and returns its index."""
        self.document[kind].append(element)
        return len(self.document[kind]) - 1

    def view(self, content):
        offset = len(self.bytes)
        self.bytes += content + b"\0" * (-len(content) % 4)
        return self.add("bufferViews", {"buffer": 0, "byteOffset": offset, "byteLength": len(content)})

    def accessor(self, values, code, kind, count, **more):
        view = self.view(array(code, values).tobytes())
        component = {"f": 5126, "I": 5125}[code]
        accessor = {"bufferView": view, "componentType": component, "count": count, "type": kind}
        return self.add("accessors", accessor | more)

    def texture(self, size, kind, random):
        """A texture of `size`² texels with large and small features, as a PNG or JPEG image."""
        coarse = Image.fromarray(random.integers(0, 200, (64, 64, 3), "u1"))
        coarse = numpy.asarray(coarse.resize((size, size), Image.Resampling.BICUBIC))
        texels = coarse + random.integers(0, 32, (size, size, 3), "u1")
        encoded = io.BytesIO()
        how = {"quality": 90} if kind == "jpeg" else {"compress_level": 4}
        Image.fromarray(texels).save(encoded, kind, **how)
        image = {"bufferView": self.view(encoded.getvalue()), "mimeType": f"image/{kind}"}
        return {"index": self.add("textures", {"source": self.add("images", image)})}

    def write(self, path):
        self.document["buffers"] = [{"byteLength": len(self.bytes)}]
        text = json.dumps(self.document).encode()
        text += b" " * (-len(text) % 4)
        with open(path, "wb") as file:
            file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(self.bytes)))
            file.write(struct.pack("<I4s", len(text), b"JSON") + text)
            file.write(struct.pack("<I4s", len(self.bytes), b"BIN\0") + self.bytes)


def write_glb(path, meshes, side, materials, size):
    """Writes `meshes` grids of 2 · `side`² triangles with `materials` materials. Each material has three textures of `size`²
    texels, and the meshes have normals but no tangents. Returns the size of what a loader holds, in bytes; tangents, which
    normal maps need, are a part of it."""
    random = numpy.random.default_rng(2)
    glb = Glb()
    for _ in range(materials):
        textures = [glb.texture(size, kind, random) for kind in ["jpeg", "png", "png"]]
        color, roughness, normal = textures
        metal = {"baseColorTexture": color, "metallicRoughnessTexture": roughness}
        glb.add("materials", {"pbrMetallicRoughness": metal, "normalTexture": normal})
    vertices = (side + 1) ** 2
    for number in range(meshes):
        positions, normals, coordinates = grid(side, side, number)
        single = array("f", positions)
        limits = {
            "min": [min(single[axis::3]) for axis in range(3)],
            "max": [max(single[axis::3]) for axis in range(3)],
        }
        attributes = {
            "POSITION": glb.accessor(positions, "f", "VEC3", vertices, **limits),
            "NORMAL": glb.accessor(normals, "f", "VEC3", vertices),
            "TEXCOORD_0": glb.accessor(coordinates, "f", "VEC2", vertices),
        }
        indices = corners(side, side, 0)
        primitive = {
            "attributes": attributes,
            "indices": glb.accessor(indices, "I", "SCALAR", len(indices)),
            "material": number % materials,
        }
        mesh = glb.add("meshes", {"primitives": [primitive]})
        glb.document["scenes"][0]["nodes"].append(glb.add("nodes", {"mesh": mesh}))
    glb.write(path)
    return meshes * (vertices * 48 + side * side * 2 * 12) + 3 * materials * size * size * 4
