"""The distance of two noisy pictures, in units of their noise."""

import numpy as np

# Side of the squares of pixels whose means are compared, in pixels.
BLOCK = 8

# A difference relative to the brighter picture that counts as much as one standard error of noise: environments are
# resampled for Blender, and both programs round.
RESOLUTION = 2e-4


class Pair:
    """Headwater's picture with the standard error of each pixel, and pictures of Cycles with different seeds."""

    def __init__(self, ours, errors, theirs):
        self.ours, self.errors, self.theirs = ours, errors, theirs
        self.their_mean = theirs.mean(0)

    def ratio(self, mask):
        """The ratio of our mean to theirs over some pixels, with its standard error; None if both are black."""
        mean, their_means = self.ours[mask].mean(), self.theirs[:, mask].mean((1, 2))
        their_mean, count = their_means.mean(), len(their_means)
        if mean <= 0 or their_mean <= 0:
            return None if max(mean, their_mean) <= 0 else (np.inf if mean > 0 else 0.0, 0.0)
        # Channels of a pixel share their paths: at worst they err together.
        error = 3**0.5 * (self.errors[mask] ** 2).sum() ** 0.5 / (3 * mask.sum()) / mean
        their_error = their_means.std(ddof=1) / count**0.5 / their_mean
        ratio = mean / their_mean
        return ratio, ratio * np.hypot(error, their_error)

    def deviations(self):
        """For each block of pixels and each channel, the difference of the means in standard errors: row, column, channel.

        Where neither picture has noise, `RESOLUTION` is the unit.
        """
        difference = blocks(self.ours) - blocks(self.their_mean)
        variance = blocks(self.errors**2) / BLOCK**2
        variance += np.var([blocks(each) for each in self.theirs], 0, ddof=1) / len(self.theirs)
        rounding = RESOLUTION * np.maximum(blocks(self.ours), blocks(self.their_mean)) + 1e-9
        return difference / np.sqrt(variance + rounding**2)


def blocks(picture):
    """The means of squares of pixels; what does not fill a square at the edges is left out."""
    height, width = (side // BLOCK * BLOCK for side in picture.shape[:2])
    shape = (height // BLOCK, BLOCK, width // BLOCK, BLOCK, -1)
    return picture[:height, :width].reshape(shape).mean((1, 3))
