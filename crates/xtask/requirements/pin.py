"""Writes the SHA-256 of every wheel below its `name==version` line in the requirement files of this folder.

    python3 crates/xtask/requirements/pin.py

To change a version, change its line and run this script. The hashes come from PyPI's index, and are those of the wheels
for CPython 3.10 to 3.14 on Linux with glibc (x86-64, AArch64), macOS and Windows. Comments and markers stay.
"""
import pathlib
import re
import urllib.request

PYTHONS = ("310", "311", "312", "313", "314")


def is_wanted(wheel):
    """Whether a wheel can be installed on one of the platforms above."""
    tags, abi, platforms = wheel.removesuffix(".whl").split("-")[-3:]
    python = any(tag in tags.split(".") for tag in ("py3", *("cp" + version for version in PYTHONS))) or abi == "abi3"
    platform = platforms == "any" or re.search(r"manylinux\w*_(x86_64|aarch64)|macosx|win_amd64|win_arm64", platforms)
    # The ABIs that end with a t are those of builds without the global lock.
    return python and platform and not abi.endswith("t")


def hashes(name, version):
    """The hashes of all wanted wheels of one version, sorted."""
    with urllib.request.urlopen(f"https://pypi.org/simple/{name.lower()}/", timeout=60) as page:
        links = re.findall(r'href="[^"]*/([^"/#]+\.whl)#sha256=([0-9a-f]{64})"', page.read().decode())
    found = {digest for wheel, digest in links if wheel.split("-")[1] == version and is_wanted(wheel)}
    if not found:
        raise SystemExit(f"{name} {version}: no wheel in PyPI's index")
    return sorted(found)


for file in sorted(pathlib.Path(__file__).parent.glob("*.txt")):
    lines = []
    for line in file.read_text().splitlines():
        line = line.removesuffix("\\").rstrip()
        if line.lstrip().startswith("--hash="):
            continue
        lines.append(line)
        if match := re.match(r"([\w.-]+)==([\w.]+)", line):
            lines[-1] += " \\"
            lines += [f"    --hash=sha256:{digest} \\" for digest in hashes(*match.groups())]
            lines[-1] = lines[-1].removesuffix(" \\")
    file.write_text("\n".join(lines) + "\n")
    print(file.name)
