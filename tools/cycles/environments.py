"""Environments as Headwater shows them: the middle column of the image looks along −Z, and rows go from the zenith down."""

import numpy as np
import OpenEXR


def neutral():
    """Headwater's environment for scenes without light, by the formula in its documentation."""
    height, width = 32, 64
    down = np.pi * (np.arange(height) + 0.5)[:, None] / height
    around = 2 * np.pi * ((np.arange(width) + 0.5)[None] / width - 0.5)
    direction = np.stack(np.broadcast_arrays(np.sin(down) * np.sin(around), np.cos(down), -np.sin(down) * np.cos(around)), -1)
    brightest = np.array([0.5, 0.8, 0.6]) / np.linalg.norm([0.5, 0.8, 0.6])
    near = 0.5 + 0.5 * direction @ brightest
    return np.repeat((0.2 + 0.9 * near**2)[..., None], 3, -1)


def read(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = file.channels()
        return np.stack([channels[c].pixels.astype(np.float64) for c in "RGB"], -1)


def refined(texels):
    """More texels of the same interpolated image. At the poles Headwater keeps the outer rows, and Blender does not; with
    small texels the difference is negligible."""
    height, width, _ = texels.shape
    factor = -(-1024 // height)
    if factor == 1:
        return texels
    x = (np.arange(width * factor) + 0.5) / factor - 0.5
    y = np.clip((np.arange(height * factor) + 0.5) / factor - 0.5, 0, height - 1)
    left, top = np.floor(x).astype(int), np.minimum(np.floor(y).astype(int), height - 2)
    across, down = (x - left)[None, :, None], (y - top)[:, None, None]
    rows = texels[:, left % width] * (1 - across) + texels[:, (left + 1) % width] * across
    return rows[top] * (1 - down) + rows[top + 1] * down


def write(texels, path):
    channels = {name: np.ascontiguousarray(texels[..., i], np.float32) for i, name in enumerate("RGB")}
    header = {"type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION}
    OpenEXR.File(header, channels).write(str(path))
