"""A glTF file whose surfaces are diffuse, as one JSON object."""

import base64
import json
import struct
import urllib.parse


def of(path):
    """The file with everything that both renderers define differently left out: specular lobes, normal maps, ranges."""
    document = whole(path)
    for material in document.get("materials", []):
        change(material)
    for light in document.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", []):
        light.pop("range", None)
    used = document.setdefault("extensionsUsed", [])
    if "KHR_materials_specular" not in used:
        used.append("KHR_materials_specular")
    # Primitives without a material have glTF's default one, which has a specular lobe.
    lacking = [p for mesh in document.get("meshes", []) for p in mesh["primitives"] if "material" not in p]
    for primitive in lacking:
        primitive["material"] = len(document.get("materials", []))
    if lacking:
        document.setdefault("materials", []).append(change({}))
    return document


def change(material):
    pbr = material.setdefault("pbrMetallicRoughness", {})
    pbr["metallicFactor"], pbr["roughnessFactor"] = 0.0, 1.0
    pbr.pop("metallicRoughnessTexture", None)
    for texture in ("normalTexture", "occlusionTexture"):
        material.pop(texture, None)
    extensions = material.get("extensions", {})
    kept = {k: v for k, v in extensions.items() if k in ("KHR_materials_emissive_strength", "KHR_materials_unlit")}
    material["extensions"] = {**kept, "KHR_materials_specular": {"specularFactor": 0.0}}
    return material


def whole(path):
    """The document with all buffers and images inside."""
    data = path.read_bytes()
    binary = None
    if data[:4] == b"glTF":
        length = struct.unpack_from("<I", data, 12)[0]
        document = json.loads(data[20 : 20 + length])
        if 20 + length < len(data):
            binary = data[28 + length : 28 + length + struct.unpack_from("<I", data, 20 + length)[0]]
    else:
        document = json.loads(data)
    for part in document.get("buffers", []) + document.get("images", []):
        uri = part.get("uri")
        if uri is None and "byteLength" in part and binary is not None:
            part["uri"] = data_uri(binary)
        elif uri is not None and not uri.startswith("data:"):
            file = path.parent / urllib.parse.unquote(uri)
            # A missing file stays missing.
            if file.exists():
                part["uri"] = data_uri(file.read_bytes())
    return document


def data_uri(data):
    kinds = {b"\x89PNG": "image/png", b"\xff\xd8\xff\xe0": "image/jpeg", b"RIFF": "image/webp"}
    kind = kinds.get(data[:4], "image/jpeg" if data[:2] == b"\xff\xd8" else "application/octet-stream")
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"
