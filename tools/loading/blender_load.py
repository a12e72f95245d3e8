"""Imports a glTF file with Blender, then decodes its images, and prints the times as JSON.

The importer keeps images as files in memory; Blender decodes an image when it is first shown or rendered."""

import json
import os
import sys
import time

import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)
# The importer prints a line for each mesh.
output = os.dup(1)
os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
times = [(time.perf_counter(), time.process_time())]
bpy.ops.import_scene.gltf(filepath=sys.argv[1])
times.append((time.perf_counter(), time.process_time()))
for image in bpy.data.images:
    image.pixels[0]
times.append((time.perf_counter(), time.process_time()))
stages = ["importing", "decoding images"]
text = json.dumps({
    stage: [after - before for before, after in zip(times[index], times[index + 1])]
    for index, stage in enumerate(stages)
})
os.write(output, f"\n{text}\n".encode())
