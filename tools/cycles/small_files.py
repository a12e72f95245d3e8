"""A glTF file that is put together in memory."""

import base64
import io

import numpy as np
from PIL import Image

COMPONENTS = {"int8": 5120, "uint8": 5121, "int16": 5122, "uint16": 5123, "uint32": 5125, "float32": 5126}
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


class SmallFile:
    """Parts are added one by one; each method returns the index of what it adds."""

    def __init__(self):
        self.data = bytearray()
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}]}

    def add(self, kind, part):
        parts = self.json.setdefault(kind, [])
        parts.append(part)
        return len(parts) - 1

    def uses(self, *extensions, required=False):
        for name in ("extensionsUsed", "extensionsRequired") if required else ("extensionsUsed",):
            used = self.json.setdefault(name, [])
            used += [each for each in extensions if each not in used]

    def view(self, data, stride=None):
        self.data += bytes(-len(self.data) % 4)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)}
        self.data += data
        return self.add("bufferViews", view | ({"byteStride": stride} if stride else {}))

    def accessor(self, values, normalized=False, padded=False):
        """Numbers of the type that the array has; with `padded`, elements begin at multiples of four bytes."""
        values = np.asarray(values)
        values = values.astype(np.float32) if values.dtype in (np.float64, np.int64) else values
        values = values[:, None] if values.ndim == 1 else values
        accessor = {"componentType": COMPONENTS[values.dtype.name], "count": len(values), "type": TYPES[values.shape[1]]}
        accessor |= {"min": values.min(0).tolist(), "max": values.max(0).tolist()} | ({"normalized": True} if normalized else {})
        width = values.shape[1] * values.itemsize
        stride = None
        if padded and width % 4:
            values = np.pad(values, ((0, 0), (0, (-width % 4) // values.itemsize)))
            stride = values.shape[1] * values.itemsize
        return self.add("accessors", {"bufferView": self.view(values.tobytes(), stride), **accessor})

    def material(self, material):
        self.uses(*material.get("extensions", {}))
        infos = [v for part in (material, material.get("pbrMetallicRoughness", {})) for k, v in part.items() if k.endswith("Texture")]
        for info in infos:
            self.uses(*info.get("extensions", {}))
        return self.add("materials", material)

    def texture(self, texels, sampler=None):
        file = io.BytesIO()
        Image.fromarray(texels).save(file, "PNG")
        image = self.add("images", {"bufferView": self.view(file.getvalue()), "mimeType": "image/png"})
        sampler = self.add("samplers", {"magFilter": 9729, **(sampler or {})})
        return self.add("textures", {"source": image, "sampler": sampler})

    def mesh(self, attributes, indices, material):
        primitive = {"attributes": attributes, "indices": self.accessor(np.array(indices, np.uint32)), "material": material}
        return self.add("meshes", {"primitives": [primitive]})

    def quad(self, material, repeat=1.0, colors=None, normals=False, quantized=False):
        """A square with corners at ±1 in x and z, whose front is above; its texture coordinates go up to `repeat`."""
        positions = np.array([[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]], np.float32)
        coordinates = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], np.float32)
        up = np.tile(np.array([0, 1, 0], np.float32), (4, 1))
        if quantized:
            attributes = {
                "POSITION": self.accessor((positions * 9000).astype(np.int16), padded=True),
                "NORMAL": self.accessor((up * 127).astype(np.int8), normalized=True, padded=True),
                "TEXCOORD_0": self.accessor((coordinates * 65535).astype(np.uint16), normalized=True),
            }
        else:
            attributes = {"POSITION": self.accessor(positions), "TEXCOORD_0": self.accessor(coordinates * repeat)}
        if colors is not None:
            attributes["COLOR_0"] = self.accessor(colors, normalized=True)
        if normals:
            attributes["NORMAL"] = self.accessor(up)
        return self.mesh(attributes, [0, 1, 2, 0, 2, 3], material)

    def box(self, material):
        """A cube with corners at ±1."""
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float32)
        faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
        indices = [i for a, b, c, d in faces for i in (a, b, c, a, c, d)]
        return self.mesh({"POSITION": self.accessor(corners)}, indices, material)

    def place(self, mesh, **node):
        return self.node({"mesh": mesh, **node})

    def node(self, node):
        index = self.add("nodes", node)
        self.json["scenes"][0]["nodes"].append(index)
        return index

    def camera(self, camera, **node):
        return self.node({"camera": self.add("cameras", camera), **node})

    def light(self, light, **node):
        self.uses("KHR_lights_punctual")
        lights = self.json.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})["lights"]
        lights.append(light)
        return self.node({"extensions": {"KHR_lights_punctual": {"light": len(lights) - 1}}, **node})

    def instances(self, mesh, **attributes):
        self.uses("EXT_mesh_gpu_instancing", required=True)
        accessors = {name: self.accessor(np.array(values, np.float32)) for name, values in attributes.items()}
        return self.node({"mesh": mesh, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": accessors}}})

    def animate(self, node, path, times, values):
        """Keyframes of a property of a node, or, without a node, of what a JSON pointer names."""
        sampler = {"input": self.accessor(times), "output": self.accessor(values), "interpolation": "LINEAR"}
        if node is None:
            self.uses("KHR_animation_pointer")
            target = {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": path}}}
        else:
            target = {"node": node, "path": path}
        if "animations" not in self.json:
            self.add("animations", {"samplers": [], "channels": []})
        animation = self.json["animations"][0]
        animation["samplers"].append(sampler)
        animation["channels"].append({"sampler": len(animation["samplers"]) - 1, "target": target})

    def document(self):
        uri = "data:application/octet-stream;base64," + base64.b64encode(bytes(self.data)).decode()
        return {**self.json, "buffers": [{"byteLength": len(self.data), "uri": uri}]}
