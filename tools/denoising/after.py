"""Measures the error of presets before and after denoising, relative to path tracing with the same time."""

import argparse
import json
import math
import os
import pathlib
import resource
import shlex
import statistics
import subprocess
import sys
import time

import numpy as np

import command
from command import Wrong
from pictures import COLOR, Picture, beside

# Numbers of samples per pixel of path tracing, between which errors are interpolated.
SAMPLES = [1, 2, 3, 4, 6, 8]
# The frame of a preset that is denoised: its history is long enough to be that of a running application.
LAST_FRAME = 8
PRESETS = ["fast", "balanced", "accurate"]
# Frames of the two runs whose difference is the time of a frame: loading and compilation drop out.
SHORT, LONG = 1, 17
# Random numbers of the references; those of the pictures count from 0.
REFERENCE_SEEDS = [1001, 1002]
# The errors of the tables: names in the results, titles, and the power of the squared error that a table shows.
MEASURES = [("relmse", "relMSE", 1.0), ("clamped_mse", "Clamped RMSE", 0.5)]
# Two-sided 95 % quantiles of Student's t for 1, 2, 3 … degrees of freedom.
STUDENT = [12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26, 2.23, 2.20, 2.18, 2.16, 2.14, 2.13, 2.12, 2.11, 2.10]


def say(text):
    print(f"after-denoising: {text}", file=sys.stderr, flush=True)


def run(*arguments):
    """Runs Headwater and returns its CPU time in seconds, which other programs on the machine hardly change."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    process = subprocess.Popen([os.environ["HEADWATER_RUN"], *map(str, arguments)], stdout=subprocess.DEVNULL)
    try:
        status = process.wait()
    except BaseException:
        process.terminate()
        process.wait()
        raise
    if status:
        sys.exit(status if status > 0 else 1)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def split(text):
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise Wrong(f"{text}: {error}") from error
    if not words:
        raise Wrong("a scene or a configuration is empty")
    return words


def errors(picture, halves):
    """Squared errors without the noise of the reference, as `SquaredErrors` in src/metrics/error.rs."""
    a, b1, b2 = (x.astype(np.float64) for x in (picture, *halves))
    squared = (a - b1) * (a - b2)
    low = [x.clip(0, 1) for x in (a, b1, b2)]
    return {
        "relmse": (squared / (((b1 + b2) / 2) ** 2 + 0.01)).mean(),
        "clamped_mse": ((low[0] - low[1]) * (low[0] - low[2])).mean(),
    }


class Scene:
    """A scene: its pictures, and what has been measured in them, in a folder of its own."""

    def __init__(self, text, options):
        self.options = options
        self.words = split(text)
        # Many files are called scene.gltf: the folder tells them apart.
        self.name = "/".join(pathlib.Path(self.words[0]).parts[-2:])
        self.folder = options.output / self.name.replace("/", "-")
        self.folder.mkdir(parents=True, exist_ok=True)
        self.size = ["--width", options.width, "--height", options.height]
        self.bounces = ["--bounces", options.bounces]
        self.state = {"errors": {}, "times": {}, "denoising": []}
        if (self.folder / "state.json").exists():
            self.state = json.loads((self.folder / "state.json").read_text())
        # Pictures of other options must not be mixed with these.
        plan = {
            "scene": self.words,
            "program (HEADWATER_RUN)": os.environ["HEADWATER_RUN"],
            "size": [*self.size, *self.bounces],
            "spp": options.spp,
            **options.configurations,
        }
        old = self.state.setdefault("plan", plan)
        changed = [name for name in plan if old.get(name, plan[name]) != plan[name]]
        if changed:
            raise Wrong(f"{self.folder} has results of another {changed[0]}; choose another folder")
        old.update(plan)

    def save(self):
        with beside(self.folder / "state.json") as file:
            file.write_text(json.dumps(self.state))

    def render(self, file, *arguments):
        if not (self.folder / file).exists():
            # A picture gets its name when it is complete.
            run("render", *self.words, *self.size, *arguments, "--jitter", "off", "-o", self.folder / file)
        return Picture(self.folder / file)

    def halves(self):
        """Two references with independent noise."""
        for seed in REFERENCE_SEEDS:
            path = self.folder / f"reference-{seed}.exr"
            if not path.exists():
                run("reference", *self.words, *self.size, *self.bounces, "--jitter", "off", "--spp", self.options.spp, "--seed", seed, "-o", path)
        return [Picture(self.folder / f"reference-{seed}.exr").layer(COLOR) for seed in REFERENCE_SEEDS]

    def measure(self):
        halves = self.halves()
        emission = self.render("emission.exr", "--preset", "path-tracing", "--bounces", 0).layer(COLOR)
        mean, difference = (halves[0] + halves[1]) / 2, (halves[0] - halves[1]) / 2
        self.state["floor"] = float((difference**2 / (mean**2 + 0.01)).mean())
        done = self.state["errors"]
        for seed in range(self.options.seeds):
            for name, words in self.options.configurations.items():
                key = f"{name}-{seed}"
                if key in done:
                    continue
                picture = self.render(f"{key}.exr", *self.bounces, *words, "--seed", seed, "--aov", "albedo,normal")
                guides = picture.guides()
                pictures = {
                    "before": picture.layer(COLOR),
                    "after": picture.denoised(guides, emission),
                    "whole": picture.denoised(guides),
                }
                done[key] = {when: errors(values, halves) for when, values in pictures.items()}
                if seed == 0:
                    self.denoise_for_time(picture, guides)
                self.save()
        times = self.state["times"]
        while missing := [name for name in self.options.presets if len(times.get(name, [])) < self.options.rounds]:
            self.time_round(missing)
            self.save()

    def denoise_for_time(self, picture, guides):
        """Adds the time of denoising once more; the first time prepares the denoiser, so it does not count."""
        start = time.process_time()
        picture.denoised(guides)
        self.state["denoising"].append(time.process_time() - start)

    def time_round(self, names):
        """The times of a frame of some configurations, each with that of a path-traced frame just before."""
        path_traced = self.frame_time(["--preset", "path-tracing"], 2 * LONG)
        for name in names:
            words = self.options.configurations[name]
            taken = self.frame_time(words[: words.index("--frames")], LONG)
            self.state["times"].setdefault(name, []).append([taken, path_traced])

    def frame_time(self, words, frames):
        temporary = self.folder / "timed.exr"
        # Without --accumulate, frames that no later frame needs are not rendered.
        words = [*self.words, *self.size, *self.bounces, *words, "--jitter", "off", "--accumulate", "-o", temporary]
        short, long = (run("render", *words, "--frames", n) for n in (SHORT, frames))
        temporary.unlink()
        if long <= short:
            raise Wrong(f"{self.name}: a frame takes too little time to be measured; choose a larger picture")
        return (long - short) / (frames - SHORT)

    def logs(self, name, when, measure):
        """The logarithm of the mean error of a configuration, and half of its interval."""
        key, _, power = measure
        values = [self.state["errors"][f"{name}-{seed}"][when][key] for seed in range(self.options.seeds)]
        mean = statistics.mean(values)
        if mean <= 0:
            raise Wrong(f"{self.name}: the noise of the reference hides the error of {name}; choose a higher --spp")
        return power * math.log(mean), power * half_interval(values) / mean

    def cost(self, name):
        """The time of a frame in units of a path-traced frame; the mean of its logarithm, and half of its interval."""
        logs = [math.log(taken / path_traced) for taken, path_traced in self.state["times"][name]]
        return statistics.mean(logs), half_interval(logs)

    def ratio(self, name, when, measure):
        """The error relative to path tracing with the same time: the logarithm, and half of its interval."""
        cost, cost_error = self.cost(name)
        points = [(math.log(n), *self.logs(path_tracing(n), when, measure)) for n in SAMPLES]
        # A time beyond the last point continues the last segment.
        at = next((i for i in range(len(points) - 2) if points[i + 1][0] > cost), len(points) - 2)
        (x1, y1, e1), (x2, y2, e2) = points[at], points[at + 1]
        part = (cost - x1) / (x2 - x1)
        mean, error = self.logs(name, when, measure)
        slope = (y2 - y1) / (x2 - x1)
        # Pictures with more samples contain those with fewer, so their errors are taken to go together.
        reference_error = abs(1 - part) * e1 + abs(part) * e2
        return mean - (y1 + part * (y2 - y1)), math.hypot(error, reference_error, slope * cost_error)


def half_interval(values):
    """Half of the 95 % interval of a mean."""
    return STUDENT[min(len(values) - 1, len(STUDENT)) - 1] * statistics.stdev(values) / len(values) ** 0.5


def path_tracing(samples):
    return f"path tracing {samples}"


def absolute(log, error):
    decimals = max(0, 2 - math.floor(log / math.log(10)))
    return f"{math.exp(log):.{decimals}f} ± {error * math.exp(log):.{decimals}f}"


def relative(log, error):
    return f"{math.exp(log):.2f} ({math.exp(log - error):.2f}–{math.exp(log + error):.2f})"


def preset_rows(scenes, names, measure):
    for name in names:
        together = {"before": [], "after": [], "whole": []}
        for scene in scenes:
            row = [name, scene.name, f"{math.exp(scene.cost(name)[0]):.1f}"]
            row += [absolute(*scene.logs(name, when, measure)) for when in together]
            for when, found in together.items():
                found.append(scene.ratio(name, when, measure))
                row.append(relative(*found[-1]))
            yield row
        if len(scenes) > 1:
            row = [name, "geometric mean", "", "", "", ""]
            for found in together.values():
                logs, errors_of_logs = zip(*found)
                row.append(relative(statistics.mean(logs), math.hypot(*errors_of_logs) / len(found)))
            yield row


def path_rows(scenes):
    """Path tracing itself, and the time of denoising."""
    for scene in scenes:
        frame = statistics.median(path_traced for times in scene.state["times"].values() for _, path_traced in times)
        denoising = statistics.median(scene.state["denoising"][1:])
        row = [scene.name, f"{1000 * frame:.0f}", f"{1000 * denoising:.0f}", f"{scene.state['floor']:.5f}"]
        for samples in (1, 4, 8):
            row += [absolute(*scene.logs(path_tracing(samples), when, MEASURES[0])) for when in ("before", "after")]
        yield row


def table(title, columns, made):
    made = list(made)
    print(f"\n{title}\n")
    widths = [max(len(row[i]) for row in [columns, *made]) for i in range(len(columns))]
    for row in [columns, *made]:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip())
    return {"title": title, "columns": columns, "rows": made}


def tables(scenes, options):
    columns = [f"{n} spp, {when}" for n in (1, 4, 8) for when in ("before", "after")]
    columns = ["scene", "path-traced frame (ms)", "denoising (ms)", "noise of the reference", *columns]
    made = [table("Path tracing: relMSE, and the time of denoising", columns, path_rows(scenes))]
    for measure in MEASURES:
        columns = ["preset", "scene", "time of a frame", "before", "after", "whole"]
        columns += ["ratio before", "ratio after", "ratio whole"]
        made.append(table(f"{measure[1]}, before and after denoising", columns, preset_rows(scenes, options.presets, measure)))
    return made


def configurations(more):
    made = {path_tracing(n): ["--preset", "path-tracing", "--accumulate", "--frames", str(n)] for n in SAMPLES}
    for name in PRESETS:
        made[name] = ["--preset", name, "--frames", str(LAST_FRAME + 1)]
    for text in more:
        name, equals, words = text.partition("=")
        if not equals or not name or "/" in name:
            raise Wrong(f"{text}: a configuration is NAME=OPTIONS, without a slash in its name")
        made[name] = [*split(words), "--frames", str(LAST_FRAME + 1)]
    return made


def main():
    parser = argparse.ArgumentParser(
        prog="after-denoising",
        description=__doc__,
        epilog="Work that was interrupted continues when the same command is called again. Time is CPU time, so the device "
        "must be a CPU. Exit status: 0 done, 1 the work failed, 2 the arguments or an input are wrong.",
    )
    parser.add_argument(
        "scenes", nargs="+", metavar="SCENE",
        help="a scene, in quotes with its own options of render: 'room.glb --environment sky:sun=40'",
    )
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True, metavar="DIR", help="folder of all results")
    parser.add_argument("--configuration", action="append", default=[], metavar="NAME=OPTIONS",
                        help="a further configuration, by options of render: 'cap 4=--preset fast --set …'")
    parser.add_argument("--width", type=int, default=320)
    parser.add_argument("--height", type=int, default=180)
    parser.add_argument("--bounces", type=int, default=5)
    parser.add_argument("--spp", type=int, default=512, help="samples per pixel of each of two references [512]")
    parser.add_argument("--seeds", type=int, default=8, help="pictures of each configuration, at least 2 [8]")
    parser.add_argument("--rounds", type=int, default=4, help="measurements of each time, at least 2 [4]")
    options = parser.parse_args()
    if min(options.seeds, options.rounds) < 2:
        raise Wrong("an interval needs at least two seeds and two rounds")
    options.configurations = configurations(options.configuration)
    options.presets = [name for name in options.configurations if not name.startswith("path tracing")]
    scenes = [Scene(text, options) for text in options.scenes]
    if len({scene.folder for scene in scenes}) < len(scenes):
        raise Wrong("two scenes have the same name")
    for scene in scenes:
        say(scene.name)
        scene.measure()
    made = tables(scenes, options)
    with beside(options.output / "results.json") as file:
        raw = {scene.name: scene.state for scene in scenes}
        file.write_text(json.dumps({"tables": made, "scenes": raw}, indent=1, ensure_ascii=False))


if __name__ == "__main__":
    command.run(main, say)
