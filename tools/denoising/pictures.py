"""Pictures of Headwater: EXR files with one part, and the denoiser that works on them."""

import contextlib
import os
import pathlib
import sys
import tempfile

import numpy as np
import OpenEXR
import pyoidn

from command import Wrong

# Names of the channels that the denoiser takes, with the names that it has for them.
COLOR = ["R", "G", "B"]
GUIDES = {
    "albedo": ["albedo.R", "albedo.G", "albedo.B"],
    "normal": ["normal.X", "normal.Y", "normal.Z"],
}


class Picture:
    """The channels of an EXR file, by name, and its metadata."""

    def __init__(self, path):
        self.path = path
        try:
            with open(path, "rb") as file:
                if file.read(4) != b"\x76\x2f\x31\x01":
                    raise Wrong(f"{path} is not an EXR file")
            # The file's own objects lose their values when it is closed.
            with silence(), OpenEXR.File(str(path), separate_channels=True) as file:
                parts = len(file.parts)
                self.header = dict(file.header())
                self.channels = {name: channel.pixels.copy() for name, channel in file.channels().items()}
                self.linear = {name: channel.pLinear for name, channel in file.channels().items()}
        except OSError as error:
            raise Wrong(f"{path} cannot be read: {error.strerror or error}") from error
        except (RuntimeError, ValueError, TypeError) as error:
            raise Wrong(f"{path} is damaged or incomplete") from error
        if parts != 1:
            raise Wrong(f"{path} has {parts} parts; only files with one part can be denoised")
        missing = [name for name in COLOR if name not in self.channels]
        if missing:
            raise Wrong(f"{path} has no channel {missing[0]}")

    def layer(self, names):
        """Some channels as one array of 32-bit numbers."""
        for name in names:
            pixels = self.channels[name]
            if pixels.shape != self.channels["R"].shape:
                raise Wrong(f"{self.path}: the channels R and {name} differ in size")
            if not np.isfinite(pixels).all():
                raise Wrong(f"{self.path}: the channel {name} has values that are not finite")
        return np.stack([self.channels[name].astype(np.float32) for name in names], -1)

    def guides(self):
        """The guides that the file has."""
        found = {guide: names for guide, names in GUIDES.items() if all(name in self.channels for name in names)}
        return {guide: self.layer(names) for guide, names in found.items()}

    def denoised(self, guides, emission=0.0):
        """The radiance without noise. Emission that the camera sees has none; what is given of it is left as it is."""
        return pyoidn.denoise(self.layer(COLOR) - emission, hdr=True, **guides) + emission

    def write(self, path):
        """Writes the file. It gets its name when it is complete."""
        channels = {}
        for name, pixels in self.channels.items():
            channels[name] = OpenEXR.Channel(name, pixels, 1, 1, self.linear[name])
        with beside(path) as temporary:
            OpenEXR.File({k: v for k, v in self.header.items() if k != "channels"}, channels).write(str(temporary))


@contextlib.contextmanager
def silence():
    """Nothing is printed meanwhile: the library of EXR files prints its own account of an error to both streams."""
    streams = [sys.stdout, sys.stderr]
    with open(os.devnull, "w") as nothing:
        kept = []
        for stream in streams:
            stream.flush()
            kept.append(os.dup(stream.fileno()))
            os.dup2(nothing.fileno(), stream.fileno())
        try:
            yield
        finally:
            for stream, old in zip(streams, kept):
                os.dup2(old, stream.fileno())
                os.close(old)


@contextlib.contextmanager
def beside(path):
    """A file in the same folder, which takes the place of `path` at the end, or goes if something fails."""
    path = pathlib.Path(path)
    handle, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    os.close(handle)
    temporary = pathlib.Path(name)
    try:
        # Only the owner may read a file of mkstemp.
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)
        yield temporary
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
