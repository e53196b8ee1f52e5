"""The types of the package, as a type checker sees them."""

import pathlib
import subprocess
import sys

PROGRAM = pathlib.Path(__file__).with_name("typed.py")


def checked(program, tmp_path):
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path / "cache", program]
    return subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)


def test_a_program_has_the_types_that_it_goes_on_with(tmp_path):
    outcome = checked(PROGRAM, tmp_path)
    assert outcome.returncode == 0, outcome.stdout
    # Settings are checked, too.
    wrong = tmp_path / "wrong.py"
    wrong.write_text(PROGRAM.read_text().replace("spp=1, layers", "sppp=1, layers"))
    outcome = checked(wrong, tmp_path)
    assert outcome.returncode == 1 and "sppp" in outcome.stdout, outcome.stdout
