"""Compares screenshots with pictures rendered without a screen."""

import cv2


def read(path):
    picture = cv2.imread(str(path))
    if picture is None:
        raise AssertionError(f"{path}: not a picture")
    return picture


def psnr_db(picture, references):
    """Against the nearest of the references, because it is random which of the recorded frames is on the screen; 0 if it is of
    another size."""
    screen = read(picture)
    likeness = [cv2.PSNR(screen, reference) for reference in map(read, references) if reference.shape == screen.shape]
    return max(likeness, default=0.0)


def brightness(picture):
    """Mean of all channels, 0 to 255."""
    return float(read(picture).mean())


def contrast(picture):
    """Standard deviation of its brightness: 0 of an empty screen."""
    return float(cv2.cvtColor(read(picture), cv2.COLOR_BGR2GRAY).std())
