"""A scene file as Blender's importers read it, and pictures of it by Cycles.

The importers decide what the file means. What is changed afterwards bridges differences of the renderers that the page
CYCLES.md lists; all of it is in this file.
"""

import math
import pathlib

import bpy
import mathutils
import numpy as np
import OpenEXR

# The most passes through transparent surfaces; Headwater has no limit.
TRANSPARENT = 1024

# A property of materials that emit from their front only, although the camera sees both sides: those of OBJ files.
ONE_SIDE = "emits from one side"


def rewrite(path, other, options):
    """Imports a file and exports it with other options, such as a compression."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=str(path))
    bpy.ops.export_scene.gltf(filepath=str(other), export_format="GLB", **options)


def read(path, time, variant):
    """Imports a file into an empty scene, at a time in seconds; its materials are those of a variant, if one is named."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if path.suffix.lower() == ".obj":
        bpy.ops.wm.obj_import(filepath=str(path), forward_axis="NEGATIVE_Z", up_axis="Y")
        for material in bpy.data.materials:
            material[ONE_SIDE] = True
    else:
        # A candela per unit of radiant intensity and a lux per unit of irradiance, as in Headwater.
        bpy.ops.import_scene.gltf(filepath=str(path), export_import_convert_lighting_mode="COMPAT")
    scene = bpy.context.scene
    if variant:
        names = [each.name for each in bpy.data.scenes[0].gltf2_KHR_materials_variants_variants]
        bpy.data.scenes[0].gltf2_active_variant = names.index(variant)
        bpy.ops.scene.gltf2_display_variant()
    frame = time * scene.render.fps / scene.render.fps_base
    scene.frame_set(math.floor(frame), subframe=frame % 1)
    for each in bpy.data.objects:
        # Cycles moves the origins of shadow rays on smooth surfaces unless this is 0.
        each.cycles.shadow_terminator_geometry_offset = 0.0
        each.cycles.shadow_terminator_offset = 0.0
    for image in bpy.data.images:
        decode(image)
    return scene


def decode(image):
    """Colours become linear before Cycles interpolates them, as glTF wants it; by itself it decodes afterwards."""
    if image.colorspace_settings.name != "sRGB" or image.size[0] == 0 or image.is_float:
        return
    texels = np.empty(image.size[0] * image.size[1] * 4, np.float32)
    image.pixels.foreach_get(texels)
    texels = texels.reshape(-1, 4).astype(np.float64)
    color = texels[:, :3]
    texels[:, :3] = np.where(color <= 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4)
    made = bpy.data.images.new(image.name + " linear", *image.size, alpha=True, float_buffer=True, is_data=True)
    made.alpha_mode = "CHANNEL_PACKED"
    made.pixels.foreach_set(texels.astype(np.float32).ravel())
    made.update()
    image.user_remap(made)


class Surface:
    """The node tree of a material, whose surface is changed step by step."""

    def __init__(self, material):
        self.material = material
        material.use_nodes = True
        self.tree = material.node_tree
        self.output = next(n for n in self.tree.nodes if n.type == "OUTPUT_MATERIAL" and n.is_active_output)
        links = self.output.inputs["Surface"].links
        self.shader = links[0].from_socket if links else None
        self.principled = next((n for n in self.tree.nodes if n.type == "BSDF_PRINCIPLED"), None)

    def node(self, kind, **inputs):
        made = self.tree.nodes.new(kind)
        for name, value in inputs.items():
            self.join(value, made.inputs[name])
        return made

    def join(self, value, socket):
        """Gives a socket a value or another socket's."""
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        else:
            socket.default_value = value

    def given(self, name):
        """The source of an input of the Principled BSDF: the socket that is linked to it, or its value."""
        socket = self.principled.inputs[name]
        if socket.links:
            return socket.links[0].from_socket
        value = socket.default_value
        return tuple(value) if hasattr(value, "__len__") else value

    def math(self, operation, *values):
        made = self.tree.nodes.new("ShaderNodeMath")
        made.operation = operation
        for value, socket in zip(values, made.inputs):
            self.join(value, socket)
        return made.outputs[0]

    def mixed(self, factor, first, second):
        made = self.tree.nodes.new("ShaderNodeMixShader")
        for value, socket in zip((factor, first, second), made.inputs):
            self.join(value, socket)
        return made.outputs[0]

    def transparent(self):
        return self.node("ShaderNodeBsdfTransparent", Color=(1, 1, 1, 1)).outputs[0]

    def done(self):
        if self.shader is not None:
            self.tree.links.new(self.shader, self.output.inputs["Surface"])


def change_surfaces(lambert):
    """Surfaces as both renderers have them: with `lambert` diffuse ones, otherwise nearly those of the file."""
    for material in bpy.data.materials:
        if not material.users or material.is_grease_pencil:
            continue
        surface = Surface(material)
        if surface.principled is not None:
            change_principled(surface, lambert)
        else:
            change_unlit(surface)
        if material.use_backface_culling:
            # The camera looks through the backs; all other rays see them.
            back = surface.node("ShaderNodeNewGeometry").outputs["Backfacing"]
            camera = surface.node("ShaderNodeLightPath").outputs["Is Camera Ray"]
            surface.shader = surface.mixed(surface.math("MULTIPLY", back, camera), surface.shader, surface.transparent())
        surface.done()
        material.cycles.emission_sampling = "FRONT_BACK"
        # By itself Cycles darkens bumps that light grazes.
        material.cycles.use_bump_map_correction = False
    for each in bpy.data.objects:
        # Headwater's faces without a material are grey.
        if each.type == "MESH" and not any(slot.material for slot in each.material_slots):
            material = bpy.data.materials.new("none")
            surface = Surface(material)
            surface.shader = surface.node("ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1)).outputs[0]
            surface.done()
            each.data.materials.clear()
            each.data.materials.append(material)


def change_principled(surface, lambert):
    principled = surface.principled
    # Headwater's specular lobe has one scattering, as glTF's formulas.
    principled.distribution = "GGX"
    color, strength, alpha = (surface.given(name) for name in ("Emission Color", "Emission Strength", "Alpha"))
    glows = isinstance(color, bpy.types.NodeSocket) or isinstance(strength, bpy.types.NodeSocket)
    glows = glows or (strength > 0 and max(color[:3]) > 0)
    surface.join(0.0, principled.inputs["Emission Strength"])
    for link in list(principled.inputs["Emission Strength"].links):
        surface.tree.links.remove(link)
    if lambert:
        base = surface.given("Base Color")
        surface.shader = surface.node("ShaderNodeBsdfDiffuse", Color=base).outputs[0]
        if alpha != 1.0:
            surface.shader = surface.mixed(alpha, surface.transparent(), surface.shader)
    if glows:
        if alpha != 1.0:
            strength = surface.math("MULTIPLY", strength, alpha)
        if surface.material.use_backface_culling or surface.material.get(ONE_SIDE):
            # Cycles' surfaces emit from both sides by themselves.
            back = surface.node("ShaderNodeNewGeometry").outputs["Backfacing"]
            strength = surface.math("MULTIPLY", strength, surface.math("SUBTRACT", 1.0, back))
        emission = surface.node("ShaderNodeEmission", Color=color, Strength=strength).outputs[0]
        both = surface.tree.nodes.new("ShaderNodeAddShader")
        surface.join(surface.shader, both.inputs[0])
        surface.join(emission, both.inputs[1])
        surface.shader = both.outputs[0]


def change_unlit(surface):
    """Rays that are not the camera's see black, as in Headwater; the importer lets them pass."""
    for node in surface.tree.nodes:
        if node.type == "MIX_SHADER" and node.inputs[0].links:
            if node.inputs[0].links[0].from_node.type == "LIGHT_PATH":
                black = surface.node("ShaderNodeBsdfTransparent", Color=(0, 0, 0, 1))
                surface.join(black.outputs[0], node.inputs[1])


def change_spots():
    """Spots fall off as in KHR_lights_punctual: between the two angles of the imported light by a squared ramp."""
    for light in [light for light in bpy.data.lights if light.type == "SPOT" and light.users]:
        outer, blend = light.spot_size / 2, light.spot_blend
        inner = outer * (1 - blend)
        users = [each for each in bpy.data.objects if each.data == light]
        point = bpy.data.lights.new(light.name, "POINT")
        point.color, point.energy, point.shadow_soft_size = light.color, light.energy, light.shadow_soft_size
        point.use_nodes = True
        tree = point.node_tree
        emission = next(n for n in tree.nodes if n.type == "EMISSION")
        # The direction from the light in its own space, in which it shines along −Z.
        space = tree.nodes.new("ShaderNodeTexCoord").outputs["Normal"]
        apart = tree.nodes.new("ShaderNodeSeparateXYZ")
        tree.links.new(space, apart.inputs[0])
        ramp = tree.nodes.new("ShaderNodeMapRange")
        ramp.inputs["From Min"].default_value = -math.cos(outer)
        ramp.inputs["From Max"].default_value = -max(math.cos(inner), math.cos(outer) + 1e-3)
        tree.links.new(apart.outputs["Z"], ramp.inputs["Value"])
        square = tree.nodes.new("ShaderNodeMath")
        square.operation = "MULTIPLY"
        for socket in square.inputs[:2]:
            tree.links.new(ramp.outputs["Result"], socket)
        tree.links.new(square.outputs[0], emission.inputs["Strength"])
        for each in users:
            each.data = point


def surround(scene, path):
    """An environment whose middle column is −Z of the file, which is +Y here; Blender's is +X. None is dark."""
    world = bpy.data.worlds.new("World")
    scene.world = world
    world.use_nodes = True
    tree = world.node_tree
    background = next(n for n in tree.nodes if n.type == "BACKGROUND")
    if path is None:
        background.inputs["Color"].default_value = (0, 0, 0, 1)
        return
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = bpy.data.images.load(str(path))
    mapping = tree.nodes.new("ShaderNodeMapping")
    mapping.inputs["Rotation"].default_value = (0, 0, -math.pi / 2)
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    world.cycles.sampling_method = "MANUAL"
    world.cycles.sample_map_resolution = max(texture.image.size[0], 256)


def to_blender(vector):
    """From the file's axes, where +Y is up, to Blender's, where +Z is."""
    return mathutils.Vector((vector[0], -vector[2], vector[1]))


def take_camera(scene, eye):
    """Takes the imported camera at a position, so that the framing is the importer's; returns False if there is none."""
    cameras = [each for each in bpy.data.objects if each.type == "CAMERA"]
    bpy.context.view_layer.update()
    if cameras:
        scene.camera = min(cameras, key=lambda each: (each.matrix_world.translation - to_blender(eye)).length)
    return bool(cameras)


def place_camera(scene, view):
    """Headwater's camera: eye, direction backwards, direction upwards, vertical field of view in radians."""
    eye, back, up, fov = view
    camera = bpy.data.objects.new("Headwater", bpy.data.cameras.new("Headwater"))
    scene.collection.objects.link(camera)
    back, up = to_blender(back), to_blender(up)
    camera.matrix_world = mathutils.Matrix.LocRotScale(
        to_blender(eye), mathutils.Matrix((up.cross(back), up, back)).transposed().to_quaternion(), None
    )
    camera.data.sensor_fit = "VERTICAL"
    camera.data.angle_y = fov
    scene.camera = camera


def prepare(scene, size, bounces):
    """Settings without anything that biases a picture, and with a box filter of one pixel."""
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.render.threads_mode = "FIXED"
    scene.render.threads = 1
    scene.render.use_persistent_data = True
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.film_transparent = False
    scene.view_settings.view_transform = "Standard"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.use_denoising = False
    # Pixels and seeds are independent of each other.
    cycles.sampling_pattern = "TABULATED_SOBOL"
    cycles.use_adaptive_sampling = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = 0.0
    cycles.light_sampling_threshold = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.use_fast_gi = False
    cycles.pixel_filter_type = "BOX"
    cycles.filter_width = 1.0
    # Cycles counts the bounces after the first surface.
    cycles.max_bounces = bounces - 1
    cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = bounces - 1
    cycles.transparent_max_bounces = TRANSPARENT
    for camera in bpy.data.cameras:
        camera.clip_start, camera.clip_end = min(camera.clip_start, 1e-4), max(camera.clip_end, 1e6)


def render(scene, folder, spp, passes):
    """Pictures with different seeds, which have all samples together, as an array: pass, row, column, channel."""
    made = []
    # The first sample of Cycles is always at the centre of the pixel, so it is left out.
    scene.cycles.use_sample_subset = True
    scene.cycles.sample_offset = 1
    scene.cycles.sample_subset_length = max(1, spp // passes)
    scene.cycles.samples = scene.cycles.sample_subset_length + 1
    for seed in range(passes):
        scene.cycles.seed = 7919 * seed + 1
        path = pathlib.Path(folder) / f"{seed}.exr"
        scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True)
        with OpenEXR.File(str(path), separate_channels=True) as file:
            channels = file.channels()
            made.append(np.stack([channels[c].pixels.astype(np.float64) for c in "RGB"], -1))
    return np.array(made)
