"""Writes the binary mesh files of this folder: STL and glTF, good ones and broken ones."""
import base64
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
        {"name": "glass", "pbrMetallicRoughness": {"roughnessFactor": 0, "metallicFactor": 0},
         "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1},
                        "KHR_materials_volume": {"thicknessFactor": 0.1}}},
        {"name": "glow", "emissiveFactor": [1, 0.5, 0.25],
         "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8}}},
        {"name": "brass", "alphaMode": "BLEND",
         "pbrMetallicRoughness": {"baseColorFactor": [0.9, 0.7, 0.3, 0.5], "roughnessFactor": 0.3}},
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


# What glTF holds beyond plain meshes.
buffer, views = b"", []


def view(numbers, form="f"):
    global buffer
    buffer += b"\0" * (-len(buffer) % 4)
    put = struct.pack(f"<{len(numbers)}{form}", *numbers)
    views.append({"buffer": 0, "byteOffset": len(buffer), "byteLength": len(put)})
    buffer += put
    return len(views) - 1


def accessor(kind, count, view=None, component=5126, **more):
    place = {} if view is None else {"bufferView": view}
    return {**place, "componentType": component, "count": count, "type": kind, **more}


def material(name, extensions, **surface):
    return {"name": name, "pbrMetallicRoughness": {"metallicFactor": 0, **surface},
            "extensions": {f"KHR_materials_{key}": value for key, value in extensions.items()}}


def mesh(name, material, **attributes):
    return {"name": name, "primitives": [{"attributes": attributes, "indices": 2, "material": material}]}


square = view([0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0])
other = {"count": 1, "indices": {"bufferView": view([2], "H"), "componentType": 5123},
         "values": {"bufferView": view([1, 2, 0])}}
accessors = [
    accessor("VEC3", 4, square, min=[0, 0, 0], max=[1, 1, 0]),
    accessor("VEC2", 4, view([0, 1, 1, 1, 1, 0, 0, 0])),
    accessor("SCALAR", 6, view([0, 1, 2, 0, 2, 3], "H"), 5123),
    accessor("VEC3", 4, view([1, 0, 0] * 2 + [0, 0, 1] * 2)),
    accessor("VEC3", 3, view([0, 0, 0, 10, 0, 0, 20, 0, 0])),
    accessor("VEC4", 4, view([0] * 16, "B"), 5121),
    accessor("VEC4", 4, view([1, 0, 0, 0] * 4)),
    accessor("VEC3", 4, square, min=[0, 0, 0], max=[1, 2, 0], sparse=other),
    accessor("SCALAR", 4),
]
tile = {"index": 0, "extensions": {"KHR_texture_transform": {"offset": [0.5, 0], "scale": [2, 2]}}}
pointer = {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": "/nodes/0/scale"}}}
odd = {
    "asset": {"version": "2.0", "extras": None},
    "extensionsUsed": [
        "EXT_mesh_gpu_instancing", "KHR_texture_transform", "KHR_materials_clearcoat", "KHR_materials_sheen",
        "KHR_materials_unlit", "KHR_materials_pbrSpecularGlossiness", "KHR_lights_punctual", "KHR_texture_basisu",
        "KHR_animation_pointer", "ACME_physics"],
    "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point"}]}, "ACME_physics": [1, "two", None]},
    "scenes": [{"nodes": [0, 1, 2, 3, 4, 5, 6]}, {"name": "empty"}],
    "nodes": [
        {"name": "row", "mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 4}}}},
        {"name": "bound", "mesh": 1, "skin": 0, "scale": [0.01, 0.01, 0.01]},
        {"name": "joint", "translation": [0, 0, 7]},
        {"name": "colored", "mesh": 2, "translation": [0, 4, 0]},
        {"name": "bent", "mesh": 3, "translation": [4, 4, 0]},
        {"name": "bulb", "extensions": {"KHR_lights_punctual": {"light": 0}}},
        {"name": "eye", "camera": 0},
    ],
    "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}],
    "skins": [{"joints": [2]}],
    "animations": [{"samplers": [{"input": 8, "output": 8}], "channels": [{"sampler": 0, "target": pointer}]}],
    "meshes": [
        mesh("square", 0, POSITION=0, TEXCOORD_0=1, _TEMPERATURE=8),
        mesh("hung", 1, POSITION=0, JOINTS_0=5, WEIGHTS_0=6),
        mesh("painted", 2, POSITION=0, COLOR_0=3),
        mesh("sparse", 3, POSITION=7),
    ],
    "materials": [
        material("tile", {"clearcoat": {"clearcoatFactor": 1}}, baseColorTexture=tile),
        material("plush", {"sheen": {"sheenColorFactor": [1, 1, 1]}}, roughnessFactor=1.5),
        material("flat", {"unlit": {}}),
        material("chalk", {"pbrSpecularGlossiness": {"diffuseFactor": [0.1, 0.2, 0.7, 1], "specularFactor": [0, 0, 0]}}),
        material("unused", {"sheen": {"sheenColorFactor": [1, 1, 1]}}, baseColorTexture={"index": 1}),
    ],
    "textures": [{"source": 0, "sampler": 0}, {"extensions": {"KHR_texture_basisu": {"source": 1}}}],
    "samplers": [{"wrapS": 33071, "wrapT": 33071, "magFilter": 9728}],
    "images": [{"uri": "../textures/quads.png"}, {"uri": "grain.ktx2"}],
    "accessors": accessors,
    "bufferViews": views,
    "buffers": [{"byteLength": len(buffer),
                 "uri": "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()}],
}
odd["meshes"][3]["primitives"].append({"attributes": {"POSITION": 0}, "indices": 2, "mode": 1})
open("odd.gltf", "w").write(json.dumps(odd, indent=1) + "\n")
