"""Loads an OBJ file with Mitsuba 3, builds Embree's tree, and prints the times as JSON."""

import json
import sys
import time

import mitsuba

mitsuba.set_variant("scalar_rgb")
times = [(time.perf_counter(), time.process_time())]
shape = mitsuba.load_dict({"type": "obj", "filename": sys.argv[1]})
times.append((time.perf_counter(), time.process_time()))
scene = mitsuba.load_dict({"type": "scene", "shape": shape})
times.append((time.perf_counter(), time.process_time()))
stages = ["reading", "building trees"]
print(json.dumps({
    stage: [after - before for before, after in zip(times[index], times[index + 1])]
    for index, stage in enumerate(stages)
}))
