"""What the scripts of other renderers share: where the scenes' readers are, the common arguments, the line that tells what was measured.

A line has fields separated by tabs: samples a pixel; seconds, with commas between; peak memory of the process in bytes; pictures of the
central view (PFM, linear RGB, one a seed) with commas between. `cargo xtask report --peers` reads them.
"""
import argparse
import os
import resource
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "tests", "radiance"))


def parser(words, side, views):
    """Arguments that all have; `side` is the usual number of views an axis, `views` says what they are for."""
    arguments = argparse.ArgumentParser(description=words, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("scene")
    arguments.add_argument("--out", required=True, help="a folder for the pictures")
    arguments.add_argument("--side", type=int, default=side, help=f"views an axis, {views}; odd")
    arguments.add_argument("--samples", type=lambda text: [int(n) for n in text.split(",")], default=[1, 4, 16])
    return arguments


def tell(samples, seconds, pictures):
    """Prints the line."""
    print(samples, ",".join(f"{s:.6f}" for s in seconds), peak_bytes(), ",".join(pictures), sep="\t", flush=True)


def peak_bytes():
    """From the kernel's books of this program; what `getrusage` says begins with the peak of the process that started it."""
    try:
        with open("/proc/self/status") as status:
            return next(int(line.split()[1]) for line in status if line.startswith("VmHWM:")) * 1024
    except (OSError, StopIteration):
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
