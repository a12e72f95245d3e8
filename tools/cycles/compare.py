"""A scene rendered by Headwater and by Cycles, and how far they are apart."""

import argparse
import contextlib
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np
import OpenEXR
from PIL import Image

import checks
import environments
import lambert
from statistics_of_pairs import BLOCK, RESOLUTION, Pair

# The samples of Cycles are drawn in so many passes, whose spread tells how far their mean may be off.
PASSES = 16

# A check fails if a ratio of means, or the mean of a block, differs by so many standard errors.
SIGMAS = 5.0


def run(*arguments):
    """Headwater with these arguments; returns what it prints."""
    done = subprocess.run([os.environ["HEADWATER_RUN"], *map(str, arguments)], stdout=subprocess.PIPE, text=True)
    if done.returncode:
        raise SystemExit(done.returncode)
    return done.stdout


@contextlib.contextmanager
def quiet():
    """Standard output goes nowhere meanwhile: Blender writes its progress there."""
    sys.stdout.flush()
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


def headwater(scene, options, output):
    """Renders with Headwater; returns its picture, standard errors, distances, and camera."""
    arguments = ["reference", scene, "-o", output, "--spp", options.spp, "--bounces", options.bounces, "--jitter"]
    arguments += ["--width", options.width, "--aov", "depth"]
    arguments += ["--height", options.height] if options.height else []
    arguments += [f"--look-at={options.look_at}"] if options.look_at else []
    arguments += ["--environment", options.environment] if options.environment else []
    arguments += ["--allow-missing"] if options.allow_missing else []
    arguments += ["--start-time", options.start_time] if options.start_time else []
    arguments += ["--material-variant", options.material_variant] if options.material_variant else []
    run(*arguments)
    with OpenEXR.File(str(output), separate_channels=True) as file:
        channels = {name: channel.pixels.astype(np.float64) for name, channel in file.channels().items()}
        camera = json.loads(file.header()["headwater"])["headwater.camera"]
    numbers = [float(x) for x in re.findall(r"-?[\d.]+(?:e-?\d+)?", camera)]

    def layer(*names):
        return np.stack([channels[name] for name in names], -1)

    picture, errors = layer(*"RGB"), layer(*(f"stderr.{c}" for c in "RGB"))
    return picture, errors, channels["depth.Z"], (numbers[:3], numbers[3:6], numbers[6:9], numbers[9])


def environment(scene, options, folder):
    """The environment that Headwater shows, as a file for Blender; None if there is none."""
    name = options.environment
    if name is None:
        more = ["--allow-missing"] if options.allow_missing else []
        if scene.suffix.lower() in (".gltf", ".glb") and b"EXT_lights_image_based" in scene.read_bytes():
            raise SystemExit("compare-with-cycles: Blender does not read EXT_lights_image_based; give --environment")
        inspected = json.loads(run("scene", "inspect", scene, "--json", *more))
        name = "neutral" if inspected["requirements"]["environment"] else "none"
    if name == "none":
        return None
    if name.startswith("sky"):
        run("scene", "generate", name, "-o", folder / "sky.exr")
        name = folder / "sky.exr"
    texels = environments.neutral() if name == "neutral" else environments.read(name)
    environments.write(environments.refined(texels), folder / "environment.exr")
    return folder / "environment.exr"


def cycles(scene_file, scene, options, size, view, folder):
    """Pictures of Cycles: of the file's own camera if Headwater has used one of the file, otherwise of Headwater's."""
    import blender

    surroundings = environment(scene, options, folder)
    with quiet():
        scene = blender.read(scene_file, options.start_time, options.material_variant)
        blender.change_surfaces(options.lambert)
        blender.change_spots()
        blender.surround(scene, surroundings)
        if options.look_at or not blender.take_camera(scene, view[0]):
            blender.place_camera(scene, view)
        blender.prepare(scene, size, options.bounces)
        return blender.render(scene, folder, options.spp, PASSES)


def side_by_side(pair, deviations, path):
    """A PNG file: Headwater, Cycles, and the deviations of the blocks (red: Headwater is brighter; full at 5)."""
    white = np.percentile(pair.ours.max(-1), 99.0) or 1.0

    def shown(picture):
        linear = np.clip(picture / white, 0, 1)
        return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)

    signed = deviations[np.arange(deviations.shape[0])[:, None], np.arange(deviations.shape[1]),
                        np.abs(deviations).argmax(-1)]
    signed = np.clip(np.kron(signed, np.ones((BLOCK, BLOCK))) / SIGMAS, -1, 1)
    colors = np.ones((*pair.ours.shape[:2], 3)) * 0.5
    area = colors[: signed.shape[0], : signed.shape[1]]
    area[...] = 1.0 - np.abs(signed)[..., None] * np.where(signed[..., None] > 0, [0, 1, 1], [1, 1, 0])
    row = np.concatenate([shown(pair.ours), shown(pair.their_mean), colors], 1)
    Image.fromarray((row * 255 + 0.5).astype(np.uint8)).save(path)


def compare(path, options, output, exported=None):
    """Renders and compares one file; prints a line, and returns the largest deviation in standard errors.

    With `exported`, options of Blender's exporter, Headwater renders what Blender writes of the file with them.
    """
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        theirs_read = ours_read = path
        if path.suffix.lower() == ".obj":
            # Headwater's OBJ materials without Pr and Pm are diffuse.
            options.lambert = True
        elif options.lambert:
            theirs_read = ours_read = folder / f"{path.stem}.gltf"
            ours_read.write_text(json.dumps(lambert.of(path)))
        if exported:
            import blender

            ours_read = folder / f"{path.stem}.glb"
            with quiet():
                blender.rewrite(path, ours_read, exported)
        output.mkdir(parents=True, exist_ok=True)
        ours, errors, depth, view = headwater(ours_read, options, output / f"{path.stem}.exr")
        theirs = cycles(theirs_read, ours_read, options, (ours.shape[1], ours.shape[0]), view, folder)
    pair = Pair(ours, errors, theirs)
    deviations = pair.deviations()
    environments.write(pair.their_mean, output / f"{path.stem}-cycles.exr")
    side_by_side(pair, deviations, output / f"{path.stem}.png")
    line, worst = path.stem, 0.0
    for name, mask in (("all", np.full(depth.shape, True)), ("objects", depth > 0)):
        found = pair.ratio(mask) if mask.any() and (name == "all" or not mask.all()) else None
        if found:
            line += f" | ratio of means of {name} {found[0]:.5f} ± {found[1]:.5f}"
            worst = max(worst, abs(found[0] - 1) / max(found[1], RESOLUTION))
    row, column, channel = np.unravel_index(np.abs(deviations).argmax(), deviations.shape)
    beyond = (np.abs(deviations) > 3).mean()
    largest = deviations[row, column, channel]
    line += f" | blocks: rms {np.sqrt((deviations**2).mean()):.2f}, beyond 3: {100 * beyond:.2f} %"
    line += f", largest {largest:+.1f} at x {column * BLOCK}, y {row * BLOCK}, {'RGB'[channel]}"
    print(line, flush=True)
    return max(worst, abs(largest))


def check(names, options):
    """Compares small files that are made here, one for each feature; ends with status 1 if one fails."""
    failed = []
    with tempfile.TemporaryDirectory() as temporary:
        for each in checks.CHECKS:
            if names and each.name not in names:
                continue
            path = pathlib.Path(temporary) / f"{each.name}.gltf"
            path.write_text(json.dumps(each.document()))
            options.lambert, options.environment = each.lambert, each.environment
            options.look_at, options.start_time = each.look_at, each.start_time
            options.material_variant = each.variant
            if compare(path, options, options.output or pathlib.Path(temporary), each.exported) > SIGMAS:
                failed.append(each.name)
    if failed:
        raise SystemExit(f"compare-with-cycles: these differ: {', '.join(failed)}")


def main():
    parser = argparse.ArgumentParser(prog="compare-with-cycles", description=__doc__)
    parser.add_argument("scene", nargs="*", help="a file: .gltf, .glb, .obj; with --check names of checks")
    parser.add_argument("--check", action="store_true", help="compare small files that are made for single features")
    parser.add_argument("--lambert", action="store_true", help="diffuse surfaces only, which both renderers define alike")
    parser.add_argument("--environment", metavar="FILE|sky:…|neutral|none", help="as for headwater")
    parser.add_argument("--look-at", metavar="EX,EY,EZ,TX,TY,TZ[,DEGREES]")
    parser.add_argument("--start-time", metavar="SECONDS", type=float, default=0.0, help="as for headwater")
    parser.add_argument("--material-variant", metavar="NAME", help="as for headwater")
    parser.add_argument("--allow-missing", action="store_true", help="as for headwater")
    parser.add_argument("--width", type=int, default=320)
    parser.add_argument("--height", type=int)
    parser.add_argument("--spp", type=int, default=128)
    parser.add_argument("--bounces", type=int, default=5)
    parser.add_argument("-o", "--output", type=pathlib.Path, help="a folder that keeps pictures")
    options = parser.parse_args()
    if options.bounces < 1:
        parser.error("Cycles has at least one bounce")
    unknown = set(options.scene) - {each.name for each in checks.CHECKS} if options.check else set()
    if unknown:
        parser.error(f"no such check: {', '.join(sorted(unknown))}; there are {', '.join(each.name for each in checks.CHECKS)}")
    if not options.check and not options.scene:
        parser.error("name a file, or give --check")
    if options.check:
        check(options.scene, options)
        return
    for scene in map(pathlib.Path, options.scene):
        with tempfile.TemporaryDirectory() as temporary:
            compare(scene, options, options.output or pathlib.Path(temporary))


if __name__ == "__main__":
    try:
        main()
    except (OSError, ValueError, KeyError, RuntimeError) as error:
        sys.exit(f"compare-with-cycles: {type(error).__name__}: {error}")
