"""Removes noise from pictures of Headwater with Open Image Denoise, guided by albedo and normals."""

import argparse
import pathlib
import sys

import pyoidn.version

import command
from command import Wrong
from pictures import COLOR, GUIDES, Picture


def say(text):
    print(f"denoise: {text}", file=sys.stderr)


def outputs(inputs, output):
    """The file that each input becomes."""
    if output.is_dir():
        made = [output / path.name for path in inputs]
        if len(set(made)) < len(made):
            raise Wrong("two inputs have the same file name; they would become one file")
        return made
    if len(inputs) > 1:
        raise Wrong(f"{output} is not a folder; several inputs need one")
    if output.suffix != ".exr":
        raise Wrong(f"{output}: the name of the output must end in .exr")
    if not output.parent.is_dir():
        raise Wrong(f"{output.parent} is not a folder")
    return [output]


def denoise(path, output, emission):
    picture = Picture(path)
    if emission is not None and emission.shape[:2] != picture.channels["R"].shape:
        raise Wrong(f"{path} has another size than the picture of the emission")
    guides = picture.guides()
    missing = [name for name in GUIDES if name not in guides]
    if missing:
        say(f"{path} has no {' and no '.join(missing)}, so it is denoised without; render with --aov albedo,normal")
    result = picture.denoised(guides, 0.0 if emission is None else emission)
    for index, name in enumerate(COLOR):
        picture.channels[name] = result[..., index].astype(picture.channels[name].dtype)
    errors = [name for name in picture.channels if name.startswith("stderr.")]
    if errors:
        say(f"{path}: standard errors are left out, since they are those of the noisy picture")
    for name in errors:
        del picture.channels[name]
    picture.header["denoiser"] = f"Open Image Denoise {pyoidn.version.oidn_version}"
    picture.write(output)


def main():
    parser = argparse.ArgumentParser(
        prog="denoise",
        description=__doc__,
        epilog="All other channels and the metadata are kept, except for standard errors. "
        "Exit status: 0 done, 1 the work failed, 2 the arguments or an input are wrong.",
    )
    parser.add_argument("inputs", nargs="+", type=pathlib.Path, metavar="IN.exr", help="pictures with the channels R, G, B")
    parser.add_argument(
        "-o", "--output", type=pathlib.Path, required=True, metavar="OUT.exr|FOLDER",
        help="the denoised picture, or an existing folder in which each picture keeps its name",
    )
    parser.add_argument(
        "--emission", type=pathlib.Path, metavar="FILE.exr",
        help="a picture of the same view with --bounces 0: this light has no noise, and stays as it is. Without it, light of "
        "lamps that the camera sees leaks over their edges",
    )
    options = parser.parse_args()
    made = outputs(options.inputs, options.output)
    read = [path.resolve() for path in [*options.inputs, options.emission] if path]
    for output in made:
        if output.resolve() in read:
            raise Wrong(f"{output} is also an input, and would be overwritten; choose another output")
    emission = Picture(options.emission).layer(COLOR) if options.emission else None
    for path, output in zip(options.inputs, made):
        denoise(path, output, emission)


if __name__ == "__main__":
    command.run(main, say)
