"""Writes the binary mesh files of this folder: STL and glTF, good ones and broken ones."""
import json
import struct

corners = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


def stl(triangles):
    out = b"solid cube, and binary all the same".ljust(80) + struct.pack("<I", len(triangles))
    for t in triangles:
        out += struct.pack("<3f", 0, 0, 0) + b"".join(struct.pack("<3f", *corners[i]) for i in t) + b"\0\0"
    return out


cube = stl(triangles)
open("cube.stl", "wb").write(cube)
open("cut.stl", "wb").write(cube[:300])
open("lie.stl", "wb").write(cube[:80] + b"\xff\xff\xff\xff" + cube[84:])

data = b"".join(struct.pack("<3f", *c) for c in corners) + b"".join(struct.pack("<3H", *t) for t in triangles)
document = {
    "asset": {"version": "2.0"},
    "buffers": [{"byteLength": len(data)}],
    "bufferViews": [{"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 72}],
    "accessors": [
        {"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
        {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"},
    ],
    "materials": [
        {"name": "paint", "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.2, 0.1, 1], "metallicFactor": 0}},
        {"name": "glass", "pbrMetallicRoughness": {"roughnessFactor": 0},
         "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}},
        {"name": "glow", "emissiveFactor": [1, 0.5, 0.25],
         "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8}}},
        {"name": "brass", "alphaMode": "BLEND",
         "pbrMetallicRoughness": {"baseColorFactor": [0.9, 0.7, 0.3, 1], "roughnessFactor": 0.3}},
    ],
    "meshes": [
        {"name": n, "primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": m}]}
        for m, n in enumerate(["crate", "pane", "bulb", "knob"])
    ],
    "nodes": [
        {"name": "table", "children": [1, 2, 3, 4]},
        {"mesh": 0},
        {"name": "window", "mesh": 1, "translation": [2, 0, 0], "scale": [0.1, 1, 1]},
        {"name": "lamp", "mesh": 2, "translation": [0, 2, 0], "rotation": [0, 0.38268343, 0, 0.92387953]},
        {"mesh": 3, "translation": [-2, 0, 0]},
    ],
    "scenes": [{"nodes": [0]}],
}


def glb(document, data):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


whole = glb(document, data)
open("table.glb", "wb").write(whole)
open("cut.glb", "wb").write(whole[:1000])
lie = json.loads(json.dumps(document))
lie["accessors"][1]["count"] = 4000000000
open("lie.glb", "wb").write(glb(lie, data))
loop = json.loads(json.dumps(document))
loop["nodes"][1]["children"] = [0]
open("loop.glb", "wb").write(glb(loop, data))
packed = json.loads(json.dumps(document))
packed["extensionsRequired"] = ["KHR_draco_mesh_compression"]
open("draco.glb", "wb").write(glb(packed, data))
outside = json.loads(json.dumps(document))
outside["buffers"][0]["uri"] = "../../../data.bin"
open("outside.gltf", "w").write(json.dumps(outside))
