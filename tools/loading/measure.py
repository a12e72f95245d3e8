"""Loads the same scenes with Headwater, Mitsuba 3 and Blender in turns, and stores times and memory as a measurement."""

import argparse
import datetime
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import files

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
STORED = ROOT / "tests/measurements/loading.json"
HEADWATER = os.environ["HEADWATER_RUN"]
# Small and without bounces, so that the frame itself takes little.
VIEW = "--look-at 0.5,-3,4,0.5,5,0 --width 16 --height 16 --preset path-tracing --bounces 0".split()


def run(command):
    """Runs a command. Returns its output, its messages, and its largest memory in bytes."""
    with tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as messages:
        process = subprocess.Popen(command, stdout=output, stderr=messages)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        texts = []
        for file in [output, messages]:
            file.seek(0)
            texts.append(file.read().decode(errors="replace"))
        if process.returncode != 0:
            sys.exit(f"load-times: {command} failed:\n{texts[1]}")
        return *texts, usage.ru_maxrss * 1024


def headwater(scene, folder):
    """The stages of a render, each with its wall time and CPU time in seconds; the largest memory of loading alone and of the
    render, and the size of the scene on the device, in bytes."""
    report = folder / "report.json"
    outputs = ["--report", report, "-o", folder / "frame.exr"]
    _, messages, rendering = run([HEADWATER, "render", scene, *VIEW, "-v", *outputs])
    stage = re.compile(r"headwater: ([a-z ]+): ([0-9.]+) s \(([0-9.]+) s of CPU time\)")
    stages = {name: [float(wall), float(cpu)] for name, wall, cpu in stage.findall(messages)}
    _, _, loading = run([HEADWATER, "scene", "inspect", scene])
    device = sum(json.loads(report.read_text())["scene_bytes"].values())
    return stages, {"loading": loading, "rendering": rendering, "device": device}


def other(script, scene):
    """The stages of another program, as in `headwater`, and its largest memory."""
    output, _, memory = run([sys.executable, HERE / script, scene])
    # Blender prints lines of its own first.
    stages = json.loads(output.splitlines()[-1])
    return stages, {", ".join(stages): memory}


def medians(runs):
    """The median of each number, over the runs of a program."""
    stages, memory = zip(*runs)
    return (
        {name: [statistics.median(one[name][i] for one in stages) for i in range(2)] for name in stages[0]},
        {name: statistics.median(one[name] for one in memory) for name in memory[0]},
    )


def rows_of_times(file, measured):
    """One row for each stage, and one for their sum where there are several."""
    rows = []
    for program, (stages, _) in measured.items():
        if program == "Headwater":
            stages = {name: times for name, times in stages.items() if name != "hashing the scene"}
        total = [sum(times[i] for times in stages.values()) for i in range(2)]
        for name, (wall, cpu) in [*stages.items(), ("all", total)]:
            rows.append([file, program, name, round(wall, 2), round(cpu, 2)])
    return rows


def rows_of_memory(file, decoded, measured):
    mega = lambda value: round(value / 1e6)
    rows = []
    for program, (_, memory) in measured.items():
        device = memory.pop("device", 0)
        for work, most in memory.items():
            held = decoded + (device if work == "rendering" else 0)
            rows.append([file, program, work, mega(held), mega(most), round(most / held, 2)])
    return rows


def main():
    parser = argparse.ArgumentParser(prog="tools/load-times", description=__doc__)
    parser.add_argument("-o", dest="output", type=Path, default=STORED)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--folder", type=Path, help="where the scenes are kept; without it they are removed")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = args.folder or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        obj, glb, sizes = folder / "grids.obj", folder / "textured.glb", folder / "sizes.json"
        if not sizes.exists():
            shape = (2, 20, 20) if args.quick else (10, 1000, 500)
            textured = (4, 20, 2, 64) if args.quick else (100, 116, 7, 2048)
            decoded = [files.write_obj(obj, *shape), files.write_glb(glb, *textured)]
            sizes.write_text(json.dumps(decoded))
        decoded = json.loads(sizes.read_text())
        run([HEADWATER, "scene", "inspect", obj])  # builds the program, and fills the caches
        scenes = [(obj, "Mitsuba", "mitsuba_load.py"), (glb, "Blender", "blender_load.py")]
        times, memory = [], []
        for (scene, rival, script), size in zip(scenes, decoded):
            runs = {"Headwater": [], rival: []}
            for _ in range(args.repeats):
                runs["Headwater"].append(headwater(scene, Path(scratch)))
                runs[rival].append(other(script, scene))
            measured = {program: medians(of_program) for program, of_program in runs.items()}
            name = f"{scene.suffix[1:].upper()}, {scene.stat().st_size / 1e6:.0f} MB"
            times += rows_of_times(name, measured)
            memory += rows_of_memory(name, size, measured)
        store(args.output, args.repeats, times, memory)
    if args.output == STORED:
        subprocess.run([ROOT / "tools/measurements"], check=True)


def store(path, repeats, times, memory):
    """Writes the measurement. The question and the answer of a stored one are kept, because a person wrote them."""
    git = ["git", "-C", ROOT, "describe", "--always", "--dirty"]
    measured = {
        "date": datetime.date.today().isoformat(),
        "commit": subprocess.run(git, check=True, capture_output=True, text=True).stdout.strip(),
        "device": f"{os.cpu_count()} CPU cores, which others used too",
    }
    common = {"measured": measured, "command": "tools/load-times"}
    old = json.loads(STORED.read_text()) if STORED.exists() else {"question": "", "answer": ""}
    tables = [
        common | {
            "title": "Times",
            "about": f"Medians of {repeats} runs, in seconds. The programs took turns. Headwater's stages are those that `render -v` prints, without the hash of the scene, which the other programs do not compute.",
            "columns": ["file", "program", "stage", "wall time (s)", "CPU time (s)"],
            "rows": times,
        },
        common | {
            "title": "Memory",
            "about": "The most memory of the process, in MB, beside the size of what it holds at the end: while loading, positions, normals, texture coordinates, tangents, indices and decoded texels; while rendering on the CPU, also the device's buffers.",
            "columns": ["file", "program", "work", "held (MB)", "most memory (MB)", "ratio"],
            "rows": memory,
        },
    ]
    document = {"question": old["question"], "answer": old["answer"], "tables": tables}
    path.write_text(json.dumps(document, indent=2, ensure_ascii=False) + "\n")


main()
