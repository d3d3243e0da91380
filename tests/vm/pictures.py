"""Compares screenshots with pictures rendered without a screen."""

import cv2


def read(path):
    picture = cv2.imread(str(path))
    if picture is None:
        raise AssertionError(f"{path}: not a picture")
    return picture


def psnr_db(picture, references):
    """Against the nearest of the references, because it is random which of the recorded frames is on the screen."""
    screen = read(picture)
    likeness = []
    for path in references:
        reference = read(path)
        if reference.shape != screen.shape:
            raise AssertionError(f"{picture} is {screen.shape[1]}x{screen.shape[0]}, {path} {reference.shape[1]}x{reference.shape[0]}")
        likeness.append(cv2.PSNR(screen, reference))
    return max(likeness)


def brightness(picture):
    """Mean of all channels, 0 to 255."""
    return float(read(picture).mean())
