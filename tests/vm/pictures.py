"""Pictures of the screen against pictures that were computed without one."""

import cv2


def read(path):
    picture = cv2.imread(str(path))
    if picture is None:
        raise AssertionError(f"{path}: not a picture")
    return picture


def psnr_db(picture, references):
    """To the nearest of the references: which of the recorded frames is on the screen is chance."""
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
