import bpy
import mathutils

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.engine = "CYCLES"
scene.render.resolution_x = scene.render.resolution_y = 8
scene.render.resolution_percentage = 100
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
scene.render.image_settings.color_mode = "RGB"
scene.view_settings.view_transform = "Raw"
cycles = scene.cycles
cycles.pixel_filter_type = "BOX"
cycles.filter_width = 1
cycles.use_adaptive_sampling = cycles.use_denoising = False
cycles.sample_clamp_indirect = 0
cycles.max_bounces = 6
scene.world = bpy.data.worlds.new("environment")
scene.world.use_nodes = True
background = scene.world.node_tree.nodes["Background"]
background.inputs["Color"].default_value = (1, 1, 1, 1)
background.inputs["Strength"].default_value = 1

camera = bpy.data.cameras.new("camera")
camera.angle = 2 * 0.7853981633974483
camera.clip_start = 0.001
eye = bpy.data.objects.new("camera", camera)
eye.matrix_world = mathutils.Matrix.Translation((0, 0, 1))
scene.collection.objects.link(eye)
scene.camera = eye


def square(name, low, high, kind, color, strength):
    mesh = bpy.data.meshes.new(name)
    corners = [(low[0], low[1], 0), (high[0], low[1], 0), (high[0], high[1], 0), (low[0], high[1], 0)]
    mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    shader = nodes.new(kind)
    shader.inputs["Color"].default_value = (*color, 1)
    if strength:
        shader.inputs["Strength"].default_value = strength
    output = nodes.new("ShaderNodeOutputMaterial")
    material.node_tree.links.new(shader.outputs[0], output.inputs["Surface"])
    mesh.materials.append(material)
    scene.collection.objects.link(bpy.data.objects.new(name, mesh))


square("emitter", (-1, 0), (0, 1), "ShaderNodeEmission", (0.25, 0.5, 1), 4)
square("surface", (0, -1), (1, 0), "ShaderNodeBsdfDiffuse", (0.5, 0.25, 0.125), None)
