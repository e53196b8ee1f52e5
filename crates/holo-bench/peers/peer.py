"""Shared by the scripts of other renderers: import path, command line arguments, output of measurements.

A line of output has fields separated by tabs: samples per pixel; seconds, separated by commas; peak memory of the
process in bytes; images of the central view (PFM, linear RGB, one per seed), separated by commas. `cargo xtask report
--peers` reads them.
"""
import argparse
import os
import resource
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "tests", "radiance"))


def parser(description, side=None, views=""):
    """The common arguments; `side` is the default number of views per axis (None: they are no grid), `views` their description."""
    arguments = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("scene")
    arguments.add_argument("--out", required=True, help="a folder for the images")
    if side is not None:
        arguments.add_argument("--side", type=int, default=side, help=f"views per axis, {views}; odd")
    arguments.add_argument("--samples", type=lambda text: [int(n) for n in text.split(",")], default=[1, 4, 16])
    return arguments


def print_measurement(samples, seconds, images):
    """Prints one line."""
    print(samples, ",".join(f"{s:.6f}" for s in seconds), peak_bytes(), ",".join(images), sep="\t", flush=True)


def peak_bytes():
    """Peak memory of this program. The value of `getrusage` is at least the peak of its parent process: a fallback."""
    try:
        with open("/proc/self/status") as status:
            return next(int(line.split()[1]) for line in status if line.startswith("VmHWM:")) * 1024
    except (OSError, StopIteration):
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
