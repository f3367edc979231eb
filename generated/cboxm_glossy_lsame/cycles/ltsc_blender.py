"""Builds scenes of ltsc in Blender and renders them with Cycles. The same for all scenes; do not edit.

A scene is a Python file that calls the functions below and ends with `finish()`. It runs in Blender, or in a Python
that has the module `bpy`:

    blender -b -P scene.py -- --render image.exr --samples 64
    python scene.py --save scene.blend

Lengths are scene units, angles degrees, colors and radiance linear RGB. Checked with Blender 4.5.
"""

import argparse
import math
import os
import sys

import bpy
import mathutils
import numpy

FOLDER = os.path.dirname(os.path.abspath(__file__))
textures = {}
materials = {}
meshes = {}
groups = {}
empties = {}
# Objects of the scene itself, or of the group that is being filled.
place = None


def scene(name):
    """Begins with nothing: no objects, no light, and every setting that would change the image off."""
    global place
    bpy.ops.wm.read_factory_settings(use_empty=True)
    it = bpy.context.scene
    it.name = name
    place = it.collection
    it.render.engine = "CYCLES"
    it.render.resolution_percentage = 100
    it.render.use_persistent_data = False
    # Linear radiance: a float file ignores the view transform, but not the exposure.
    it.view_settings.view_transform = "Raw"
    it.view_settings.exposure = 0
    it.render.image_settings.file_format = "OPEN_EXR"
    it.render.image_settings.color_depth = "32"
    it.render.image_settings.color_mode = "RGB"
    it.render.use_compositing = False
    it.render.use_sequencer = False
    it.render.film_transparent = False
    cycles = it.cycles
    cycles.device = "CPU"
    cycles.film_exposure = 1
    # Without these defaults Blender clamps, blurs, denoises and leaves out light.
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.sample_clamp_direct = 0
    cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = 0
    cycles.light_sampling_threshold = 0
    cycles.caustics_reflective = True
    cycles.caustics_refractive = True
    cycles.use_fast_gi = False
    # Lights of different power and size; without it a small one is missed.
    cycles.use_light_tree = True
    cycles.auto_scrambling_distance = False
    cycles.scrambling_distance = 1
    world = bpy.data.worlds.new("world")
    it.world = world
    environment((0, 0, 0))


def film(width, height, gaussian=None):
    """Size in pixels; a pixel is the mean over itself, or a Gaussian as wide as Blender's number says: four standard deviations."""
    it = bpy.context.scene
    it.render.resolution_x = width
    it.render.resolution_y = height
    it.render.pixel_aspect_x = it.render.pixel_aspect_y = 1
    if gaussian is None:
        it.cycles.pixel_filter_type = "BOX"
        # Cycles' box is a pixel wide, whatever this is.
        it.cycles.filter_width = 1
    else:
        it.cycles.pixel_filter_type = "GAUSSIAN"
        it.cycles.filter_width = gaussian


def path(max_depth):
    """Path tracing of `max_depth` segments, those at the camera and at the light included."""
    cycles = bpy.context.scene.cycles
    # Bounces do not count the segments at both ends.
    bounces = max(max_depth - 2, 0)
    cycles.max_bounces = bounces
    cycles.diffuse_bounces = bounces
    cycles.glossy_bounces = bounces
    cycles.transmission_bounces = bounces
    cycles.volume_bounces = 0
    cycles.transparent_max_bounces = 8
    cycles.min_light_bounces = 0
    cycles.min_transparent_bounces = 0


def sampler(samples, seed):
    """Samples per pixel and the start of their numbers, which are a shuffled Sobol sequence."""
    cycles = bpy.context.scene.cycles
    cycles.samples = samples
    cycles.seed = seed
    cycles.sampling_pattern = "TABULATED_SOBOL"


def camera(eye, x, y, z, fov_x, near, far):
    """A pinhole at `eye` that looks along -z; x points right and y up in the image. `fov_x` is the full angle of the width."""
    data = bpy.data.cameras.new("camera")
    data.type = "PERSP"
    data.sensor_fit = "HORIZONTAL"
    data.lens_unit = "FOV"
    data.angle = math.radians(fov_x)
    data.clip_start = near
    data.clip_end = far
    it = bpy.data.objects.new("camera", data)
    it.matrix_world = mathutils.Matrix([[x[i], y[i], z[i], eye[i]] for i in range(3)] + [[0, 0, 0, 1]])
    bpy.context.scene.collection.objects.link(it)
    bpy.context.scene.camera = it


class Nodes:
    """The nodes of a material."""

    def __init__(self, name):
        self.material = bpy.data.materials.new(name)
        self.material.use_nodes = True
        self.tree = self.material.node_tree
        self.tree.nodes.clear()

    def new(self, kind, **inputs):
        """A node with values or links of its inputs, named with `_` for a blank."""
        node = self.tree.nodes.new(kind)
        for name, value in inputs.items():
            self.set(node.inputs[name.replace("_", " ")], value)
        return node

    def set(self, socket, value):
        if isinstance(value, str):
            # The name of a texture.
            node = self.tree.nodes.new("ShaderNodeTexImage")
            node.image = textures[value]
            node.interpolation = "Linear"
            node.extension = "REPEAT"
            value = node.outputs["Color"]
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        elif socket.type == "RGBA":
            socket.default_value = (*value, 1)
        else:
            socket.default_value = value

    def end(self, surface):
        self.new("ShaderNodeOutputMaterial", Surface=surface)
        return self.material


def texture(name, file, linear=False):
    """An image, below or beside the folder of this file, by the mesh's coordinates; (0, 0) is its lower left corner."""
    it = bpy.data.images.load(os.path.join(FOLDER, file))
    it.name = name
    it.colorspace_settings.name = "Non-Color" if linear else "sRGB"
    # Alpha means nothing to a surface.
    it.alpha_mode = "CHANNEL_PACKED"
    textures[name] = it


def material(name, surface):
    """A material; `surface` makes its nodes, and is called again for emitters that have it."""
    nodes = Nodes(name)
    materials[name] = (nodes.end(surface(nodes)), surface)


def diffuse(reflectance):
    return lambda nodes: nodes.new("ShaderNodeBsdfDiffuse", Color=reflectance, Roughness=0).outputs[0]


def conductor(eta, k, alpha):
    def surface(nodes):
        # Blender's roughness is the square root of the width of the GGX distribution.
        node = nodes.new("ShaderNodeBsdfMetallic", Roughness=math.sqrt(alpha))
        # The distribution for several bounces would add energy.
        node.distribution = "GGX"
        # The inputs exist only then.
        node.fresnel_type = "PHYSICAL_CONDUCTOR"
        nodes.set(node.inputs["IOR"], eta)
        nodes.set(node.inputs["Extinction"], k)
        return node.outputs[0]

    return surface


def dielectric(interior, exterior, alpha):
    def surface(nodes):
        node = nodes.new(
            "ShaderNodeBsdfGlass", Color=(1, 1, 1), Roughness=math.sqrt(alpha), IOR=interior / exterior
        )
        node.distribution = "GGX"
        return node.outputs[0]

    return surface


def one_sided(front):
    """`front` on the side of the normals, black from behind."""

    def surface(nodes):
        back = nodes.new("ShaderNodeBsdfDiffuse", Color=(0, 0, 0), Roughness=0)
        backfacing = nodes.new("ShaderNodeNewGeometry").outputs["Backfacing"]
        both = nodes.new("ShaderNodeMixShader", Fac=backfacing)
        nodes.tree.links.new(front(nodes), both.inputs[1])
        nodes.tree.links.new(back.outputs[0], both.inputs[2])
        return both.outputs[0]

    return surface


def mirror(reflectance):
    def surface(nodes):
        node = nodes.new("ShaderNodeBsdfAnisotropic", Color=reflectance, Roughness=0)
        node.distribution = "GGX"
        return node.outputs[0]

    return surface


def principled(base, metallic, roughness, ior):
    def surface(nodes):
        node = nodes.new("ShaderNodeBsdfPrincipled", Metallic=metallic, Roughness=roughness, IOR=ior)
        node.distribution = "GGX"
        nodes.set(node.inputs["Base Color"], base)
        return node.outputs[0]

    return surface


def mesh(name, file):
    """A binary PLY file of triangles, below or beside the folder of this file."""
    with open(os.path.join(FOLDER, file), "rb") as source:
        header = []
        while not header or header[-1] != "end_header":
            line = source.readline()
            if not line:
                raise ValueError(f"{file}: the header has no end")
            header.append(line.decode("ascii").strip())
        if header[:2] != ["ply", "format binary_little_endian 1.0"]:
            raise ValueError(f"{file}: no binary PLY file")
        counts = {words[1]: int(words[2]) for words in map(str.split, header) if words[0] == "element"}
        columns = [words[2] for words in map(str.split, header) if words[:2] == ["property", "float"]]
        vertices = numpy.fromfile(source, "<f4", counts["vertex"] * len(columns)).reshape(-1, len(columns))
        faces = numpy.fromfile(source, [("count", "u1"), ("corners", "<i4", 3)], counts["face"])
    if len(vertices) != counts["vertex"] or len(faces) != counts["face"]:
        raise ValueError(f"{file}: the file is cut off")
    of = {column: at for at, column in enumerate(columns)}
    corners = faces["corners"].ravel()
    it = bpy.data.meshes.new(name)
    it.vertices.add(len(vertices))
    it.vertices.foreach_set("co", vertices[:, :3].ravel())
    it.loops.add(len(corners))
    it.loops.foreach_set("vertex_index", corners)
    it.polygons.add(len(faces))
    it.polygons.foreach_set("loop_start", numpy.arange(0, len(corners), 3, dtype="i4"))
    it.update(calc_edges=True)
    if "s" in of:
        uvs = it.uv_layers.new(name="uv")
        uvs.data.foreach_set("uv", vertices[:, of["s"] : of["s"] + 2][corners].ravel())
    if "nx" in of:
        normals = vertices[:, of["nx"] : of["nx"] + 3]
        it.normals_split_custom_set_from_vertices(normals.tolist())
    else:
        it.shade_flat()
    meshes[name] = it


def put(name, data, matrix):
    it = bpy.data.objects.new(name, data)
    if matrix is not None:
        whole = mathutils.Matrix([*matrix, (0, 0, 0, 1)])
        if whole.to_3x3().is_orthogonal_axis_vectors:
            it.matrix_world = whole
        else:
            # An object's own transform is a place, a turn and a scale; a shear fits only between it and its parent.
            it.parent = origin()
            it.matrix_parent_inverse = whole
    place.objects.link(it)
    return it


def origin():
    """An empty at the origin, the parent of what is sheared."""
    if "origin" not in empties:
        empties["origin"] = bpy.data.objects.new("origin", None)
        bpy.context.scene.collection.objects.link(empties["origin"])
    return empties["origin"]


def shape(name, mesh, material, matrix=None):
    """A mesh with a material; the matrix has three rows."""
    it = put(name, meshes[mesh], matrix)
    dress(it, materials[material][0])


def dress(it, used):
    """Gives an object its material; the mesh may have others elsewhere."""
    # Shading normals would otherwise be bent away from grazing light.
    for offset in ("geometry", "normal", "shading"):
        if hasattr(it, f"shadow_terminator_{offset}_offset"):
            setattr(it, f"shadow_terminator_{offset}_offset", 0)
    if not it.data.materials:
        it.data.materials.append(None)
    it.material_slots[0].link = "OBJECT"
    it.material_slots[0].material = used


def emitter(name, mesh, material, radiance, matrix=None):
    """A mesh that emits `radiance` on its front, and scatters as the material does."""
    nodes = Nodes(name)
    base = materials[material][1]
    strength = max(radiance)
    color = tuple(part / strength for part in radiance) if strength > 0 else (0, 0, 0)
    light = nodes.new("ShaderNodeEmission", Color=color, Strength=strength)
    front = nodes.new("ShaderNodeAddShader")
    nodes.tree.links.new(base(nodes), front.inputs[0])
    nodes.tree.links.new(light.outputs[0], front.inputs[1])
    # Blender's emission has two sides: the back gets the bare surface.
    backfacing = nodes.new("ShaderNodeNewGeometry").outputs["Backfacing"]
    both = nodes.new("ShaderNodeMixShader", Fac=backfacing)
    nodes.tree.links.new(front.outputs[0], both.inputs[1])
    nodes.tree.links.new(base(nodes), both.inputs[2])
    made = nodes.end(both.outputs[0])
    made.cycles.emission_sampling = "FRONT"
    it = put(name, meshes[mesh], matrix)
    dress(it, made)


def environment(radiance, tint=(1, 1, 1), turn=None):
    """The same radiance from all directions, or that of a texture: its middle is +y, to the right of it lies +x, above it +z.

    A texture is multiplied by the tint, and turned by the matrix of three rows.
    """
    world = bpy.context.scene.world
    world.use_nodes = True
    nodes = world.node_tree.nodes
    nodes.clear()
    background = nodes.new("ShaderNodeBackground")
    if isinstance(radiance, str):
        image = nodes.new("ShaderNodeTexEnvironment")
        image.image = textures[radiance]
        # Blender has +x in the middle: directions are turned by a quarter about z before it looks them up, and before that turned back.
        lookup = mathutils.Matrix.Rotation(-math.pi / 2, 3, "Z")
        if turn is not None:
            lookup = lookup @ mathutils.Matrix([row[:3] for row in turn]).transposed()
        mapping = nodes.new("ShaderNodeMapping")
        mapping.vector_type = "POINT"
        mapping.inputs["Rotation"].default_value = lookup.to_euler("XYZ")
        directions = nodes.new("ShaderNodeTexCoord")
        strength = max(tint)
        times = nodes.new("ShaderNodeVectorMath")
        times.operation = "MULTIPLY"
        times.inputs[1].default_value = [part / strength if strength > 0 else 0 for part in tint]
        for source, sink in [
            (directions.outputs["Generated"], mapping.inputs["Vector"]),
            (mapping.outputs["Vector"], image.inputs["Vector"]),
            (image.outputs["Color"], times.inputs[0]),
            (times.outputs["Vector"], background.inputs["Color"]),
        ]:
            world.node_tree.links.new(source, sink)
        background.inputs["Strength"].default_value = strength
    else:
        strength = max(radiance)
        background.inputs["Color"].default_value = (*(part / strength if strength > 0 else 0 for part in radiance), 1)
        background.inputs["Strength"].default_value = strength
    output = nodes.new("ShaderNodeOutputWorld")
    world.node_tree.links.new(background.outputs[0], output.inputs["Surface"])


def light(name, kind, color, energy):
    data = bpy.data.lights.new(name, kind)
    data.color = [part / max(color) if max(color) > 0 else 0 for part in color]
    data.energy = energy
    data.cycles.use_multiple_importance_sampling = True
    return data


def point(name, position, intensity):
    """A point light; intensity in W/sr."""
    # Blender spreads its watts over the whole sphere of directions (measured with 4.5).
    data = light(name, "POINT", intensity, max(intensity) * 4 * math.pi)
    data.shadow_soft_size = 0
    put(name, data, [(1, 0, 0, position[0]), (0, 1, 0, position[1]), (0, 0, 1, position[2])])


def directional(name, x, y, z, irradiance):
    """Parallel light that travels along -z; irradiance in W/m2 on a surface that faces it."""
    data = light(name, "SUN", irradiance, max(irradiance))
    data.angle = 0
    put(name, data, [(x[i], y[i], z[i], 0) for i in range(3)])


def spot(name, position, x, y, z, intensity, angle, blend):
    """A cone of light around -z; `angle` is its half angle, `blend` the share of it that fades."""
    data = light(name, "SPOT", intensity, max(intensity) * 4 * math.pi)
    data.shadow_soft_size = 0
    data.spot_size = math.radians(2 * angle)
    data.spot_blend = blend
    put(name, data, [(x[i], y[i], z[i], position[i]) for i in range(3)])


class group:
    """`with group(name):` fills a group that instances place."""

    def __init__(self, name):
        self.name = name

    def __enter__(self):
        global place
        place = groups[self.name] = bpy.data.collections.new(self.name)

    def __exit__(self, *_):
        global place
        place = bpy.context.scene.collection


def instance(name, group, matrix):
    """Places a group; the matrix has three rows."""
    it = put(name, None, matrix)
    it.instance_type = "COLLECTION"
    it.instance_collection = groups[group]


def finish(arguments=None):
    """Does what the command line asks for."""
    if arguments is None:
        if "--" in sys.argv:
            arguments = sys.argv[sys.argv.index("--") + 1 :]
        else:
            # Blender's own arguments are not ours.
            arguments = [] if bpy.app.binary_path else sys.argv[1:]
    parser = argparse.ArgumentParser(prog="scene.py", description="Builds the scene in Blender.")
    parser.add_argument("--save", metavar="FILE.blend", help="write the scene for Blender")
    parser.add_argument("--render", metavar="FILE.exr", help="render to a linear 32-bit image")
    parser.add_argument("--samples", type=int, help="samples per pixel")
    parser.add_argument("--seed", type=int, help="start of the random numbers")
    parser.add_argument("--threads", type=int, help="threads; all processors if nothing is said")
    given = parser.parse_args(arguments)
    it = bpy.context.scene
    if given.samples is not None:
        it.cycles.samples = given.samples
    if given.seed is not None:
        it.cycles.seed = given.seed
    if given.threads is not None:
        it.render.threads_mode = "FIXED"
        it.render.threads = given.threads
    if given.save:
        bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(given.save), check_existing=False)
    if given.render:
        it.render.filepath = os.path.abspath(given.render)
        bpy.ops.render.render(write_still=True)
