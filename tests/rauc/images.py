"""What the tests of updates start from: keys, a kiosk's disk, and bundles that are good, do not boot, or make the kiosk ill."""

import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
RECIPE = HERE.parents[1] / "systemd/rauc"
sys.path.insert(0, str(HERE.parent / "vm"))
import kiosk  # noqa: E402

SLOT_MIB, STATE_MIB, ESP_MIB = 1024, 2048, 64
SCENE_SIZE, SKY_SIZE = (192, 108), 160  # as little as software GL can be given to draw
# The cloud's kernel is a quarter of the usual one; what drives cameras and screens is missing there, and not needed here.
KERNEL = "linux-image-cloud-amd64"
ARGUMENTS = "console=ttyS0 quiet loglevel=4 systemd.show_status=false no_timer_check"
# Units that only cost an emulated machine time.
IDLE_UNITS = ("systemd-logind.service", "systemd-timesyncd.service", "systemd-pstore.service", "dev-hugepages.mount", "dev-mqueue.mount",
              "sys-kernel-tracing.mount", "sys-fs-fuse-connections.mount", "modprobe@fuse.service", "modprobe@configfs.service",
              "modprobe@efi_pstore.service", "getty@tty1.service", "systemd-networkd.service")


def run(*command, **options):
    subprocess.run([str(part) for part in command], check=True, timeout=1800, stdout=subprocess.DEVNULL, **options)


def newest(folder, pattern):
    return max(folder.glob(pattern), key=lambda path: path.stat().st_mtime)


def make_keys(folder, name):
    run("openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "3650", "-subj", f"/CN={name}", "-keyout",
        folder / f"{name}.key", "-out", folder / f"{name}.pem", stderr=subprocess.DEVNULL)


def make_packages(build, folder):
    run("cpack", "-G", "DEB", "--config", build / "CPackConfig.cmake", "-B", folder, cwd=build)
    return sorted(folder.glob("kasumi*.deb"))


def make_configuration(build, folder):
    """The kiosk's /etc/kasumi: a fixture's recordings for cameras, and no screen."""
    folder.mkdir()
    run(build / "kasumi-generate-fixture", "fine-morning", "--scene-size", "{}x{}".format(*SCENE_SIZE), "--sky-size", SKY_SIZE,
        "--frames", "4", "--period", "1", "--truth-frames", "0", "--scene-format", "MJPG", "--out", folder / "fixture")
    for name in ("temple.glb", "sky-mask.png", "scene-mask.png"):
        shutil.copy(folder / "fixture" / name, folder)
    replay = 'source = "replay"\nfixture = "fixture"\n'
    configuration = kiosk.configuration(folder / "fixture", scene=replay, sky=replay,
                                        display='kind = "headless"\nwidth = {}\nheight = {}\n'.format(*SCENE_SIZE))
    # The papers' model of the sky costs least.
    text = re.sub(r'(?m)^(sky_model|aod_550|angstrom_exponent|aerosol) = .*\n', "", configuration)
    (folder / "kasumi.toml").write_text(text.replace("[site]\n", '[site]\nsky_model = "preetham"\n'))


def squash(root, out):
    """A variant of the image: packed as make-root packs, but in a hurry."""
    out.unlink(missing_ok=True)
    run("mksquashfs", root, out, "-quiet", "-no-progress", "-comp", "gzip", "-Xcompression-level", "1", "-b", "256K")


def variant(unpacked, out, version, change):
    """The unpacked root as another version, after change(root); only what is changed is copied."""
    root = out.with_suffix(".root")
    shutil.rmtree(root, ignore_errors=True)
    run("cp", "-al", unpacked, root)
    release = root / "usr/lib/os-release"
    text = release.read_text().replace("IMAGE_VERSION=1\n", f"IMAGE_VERSION={version}\n")
    release.unlink()
    release.write_text(text)
    change(root)
    squash(root, out)
    shutil.rmtree(root)


def never_shows_a_picture(root):
    """Its GL driver is missing."""
    for driver in (root / "usr/lib/x86_64-linux-gnu/dri").iterdir():
        driver.unlink()


def makes_the_doctor_complain(root):
    """Shows pictures, but can remember nothing."""
    fstab = root / "etc/fstab"
    text = fstab.read_text()
    fstab.unlink()
    fstab.write_text(text.replace("/var/lib/kasumi    none   bind   ", "/var/lib/kasumi    none   bind,ro"))
    assert "bind,ro" in fstab.read_text()


def does_not_boot(unpacked, out):
    """A root with a kernel and without all that it would start."""
    root = out.with_suffix(".root")
    shutil.rmtree(root, ignore_errors=True)
    for folder in ("state", "etc", "dev", "proc", "sys", "run", "usr/lib"):
        (root / folder).mkdir(parents=True)
    (root / "etc/machine-id").touch()
    for name in ("vmlinuz", "initrd.img"):
        shutil.copy(unpacked / name, root / name)
    (root / "usr/lib/os-release").write_text("IMAGE_VERSION=dead\n")
    squash(root, out)
    shutil.rmtree(root)


def bundle(root, folder, name, signer="ours"):
    out = folder / f"{name}.raucb"
    out.unlink(missing_ok=True)
    run(RECIPE / "make-bundle", root, "--cert", folder.parent / f"{signer}.pem", "--key", folder.parent / f"{signer}.key",
        "--keyring", folder.parent / f"{signer}.pem", "--out", out, stderr=subprocess.DEVNULL)
    return out


def fingerprint(build):
    """Of all that the images are made of: they are made again only when it changes."""
    recipe = [path for folder in (RECIPE, HERE) for path in sorted(folder.rglob("*"))
              if path.is_file() and path.name not in ("test_updates.py", "run", "README.md")]
    content = b"".join(path.read_bytes() for path in [*recipe, build / "kasumi", build / "kasumi-report"])
    return hashlib.sha256(content).hexdigest()


def make(build, folder):
    """Makes folder/disk.img, folder/bundles.img (the bundles, as a disk) and folder/vmlinuz, unless they are there already."""
    made = folder / "made"
    if made.exists() and made.read_text() == fingerprint(build):
        return
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name in ("ours", "theirs"):
        make_keys(folder, name)
    make_first(build, folder)
    make_others(build, folder)
    made.write_text(fingerprint(build))


def make_first(build, folder):
    packages = make_packages(build, folder / "packages")
    shutil.copytree(HERE / "overlay", folder / "overlay")
    for unit in IDLE_UNITS:
        os.symlink("/dev/null", folder / "overlay/etc/systemd/system" / unit)
    with open(folder / "make-root.log", "wb") as log:
        run(RECIPE / "make-root", "--version", "1", "--keyring", folder / "ours.pem", "--kernel", KERNEL, "--include", "qemu-guest-agent",
            "--overlay", folder / "overlay", "--level", "1", "--out", folder / "1.squashfs", *packages, stderr=log)


def make_others(build, folder):
    make_configuration(build, folder / "etc")
    run(RECIPE / "make-disk", folder / "1.squashfs", "--out", folder / "disk.img", "--etc", folder / "etc", "--arguments", ARGUMENTS,
        "--slot-mib", SLOT_MIB, "--state-mib", STATE_MIB)
    unpacked = folder / "unpacked"
    run("unsquashfs", "-quiet", "-no-progress", "-dest", unpacked, folder / "1.squashfs")
    shutil.copy(unpacked / "vmlinuz", folder / "vmlinuz")
    bundles = folder / "bundles"
    bundles.mkdir()
    for version, change in {"2": lambda root: None, "dark": never_shows_a_picture, "ill": makes_the_doctor_complain}.items():
        variant(unpacked, folder / f"{version}.squashfs", version, change)
        bundle(folder / f"{version}.squashfs", bundles, version)
    does_not_boot(unpacked, folder / "dead.squashfs")
    shutil.rmtree(unpacked)
    bundle(folder / "dead.squashfs", bundles, "dead")
    bundle(folder / "dead.squashfs", bundles, "foreign", signer="theirs")
    shutil.copy(folder / "dead.squashfs", bundles / "unsigned.raucb")
    whole = bytearray((bundles / "dead.raucb").read_bytes())
    whole[len(whole) // 2] ^= 1
    (bundles / "changed.raucb").write_bytes(whole)
    size = sum(path.stat().st_size for path in bundles.iterdir())
    run("mke2fs", "-q", "-t", "ext4", "-m", "0", "-d", bundles, folder / "bundles.img", f"{(size >> 20) * 21 // 20 + 64}M")
