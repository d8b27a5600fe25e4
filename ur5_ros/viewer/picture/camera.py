"""A pinhole camera in the frame ``base_link``: where points are in a picture."""

import numpy as np

#: Where it stands and what it looks at, for an arm that reaches 1.18 m when stretched [m].
_EYE, _TARGET = np.array([0.92, 1.25, 1.0]), np.array([0.0, 0.05, 0.32])
_REACH = 1.18
#: Half of the angle of view, up and down.
_OPENING = np.tan(np.deg2rad(38.0) / 2)


class Camera:
    """
    A camera that looks at an arm standing on the floor.

    ``width``, ``height``: size of the pictures [pixels]; ``reach``: length of the stretched arm
    [m]; it fills the picture.

    """

    def __init__(self, width: int, height: int, reach: float = _REACH):
        self.width, self.height = width, height
        self._eye = _EYE * reach / _REACH
        ahead = (_TARGET - _EYE) / np.linalg.norm(_TARGET - _EYE)
        right = np.cross(ahead, (0.0, 0.0, 1.0))
        right /= np.linalg.norm(right)
        self._axes = np.stack([right, np.cross(ahead, right), ahead])  # right, down, ahead
        self._focus = height / 2 / _OPENING
        self.view = np.concatenate([self._eye, self._axes.ravel(), [self._focus]])
        """Eye [m], directions to the right, down and ahead, focus [pixels]; shape (13,)."""

    def pixels(self, points: np.ndarray) -> np.ndarray:
        """Return where points (n, 3) [m] are in the picture: (n, 2) [px]."""
        right, down, ahead = self._seen(points).T
        ahead = np.maximum(ahead, 1e-6)
        return np.c_[right / ahead, down / ahead] * self._focus + (self.width / 2, self.height / 2)

    def depth(self, points: np.ndarray) -> np.ndarray:
        """Return how far ahead points (n, 3) are: (n,) [m]."""
        return self._seen(points)[:, 2]

    def window(self, corners: np.ndarray) -> tuple[int, int, int, int]:
        """Return first and last row and column + 1 that can show what lies between corners."""
        if self.depth(corners).min() < 1e-3:
            return 0, self.height, 0, self.width
        spots = self.pixels(corners)
        (left, top), (right, bottom) = spots.min(axis=0), spots.max(axis=0)
        return (*_span(top, bottom, self.height), *_span(left, right, self.width))

    def _seen(self, points: np.ndarray) -> np.ndarray:
        return (points - self._eye) @ self._axes.T


def _span(first: float, last: float, end: int) -> tuple[int, int]:
    return int(np.clip(first - 1.0, 0, end)), int(np.clip(last + 2.0, 0, end))
