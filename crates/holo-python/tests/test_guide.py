"""The guide: every command and every Python block runs, chapter by chapter; links and included lines exist.

Blocks of `cargo` and `pip` are what a reader runs once, and what runs these tests.
"""

import os
import pathlib
import re
import stat
import subprocess
import sys

import holo
import pytest

GUIDE = pathlib.Path(__file__).parents[3] / "guide" / "src"
CHAPTERS = sorted(path for path in GUIDE.glob("*.md") if path.name != "SUMMARY.md")
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.DOTALL | re.MULTILINE)


@pytest.fixture(scope="session")
def program(tmp_path_factory):
    """A folder with the command `holo` of the package that is tested."""
    folder = tmp_path_factory.mktemp("bin")
    script = folder / "holo"
    script.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m holo "$@"\n')
    script.chmod(script.stat().st_mode | stat.S_IXUSR)
    return folder


@pytest.mark.skipif(os.name == "nt", reason="the commands are those of a Unix shell")
@pytest.mark.parametrize("chapter", CHAPTERS, ids=lambda path: path.stem)
def test_blocks_run(chapter, program, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    holo.Scene.gallery("garden").save("garden.glb")
    environment = {**os.environ, "PATH": f"{program}{os.pathsep}{os.environ['PATH']}"}
    for language, text in BLOCK.findall(chapter.read_text(encoding="utf-8")):
        if language == "python":
            exec(compile(text, str(chapter), "exec"), {})
        elif language == "sh" and not text.startswith(("cargo ", "pip ")):
            done = subprocess.run(["sh", "-ec", text], env=environment, capture_output=True, text=True)
            assert done.returncode == 0, f"{text}\n{done.stderr}"
        else:
            assert language in ("sh", "text", "rust"), f"{chapter.name}: nothing runs a block of {language}"


def test_chapters_links_and_included_lines_exist():
    summary = (GUIDE / "SUMMARY.md").read_text(encoding="utf-8")
    assert sorted(re.findall(r"\]\((\S+?)\)", summary)) == [path.name for path in CHAPTERS]
    for chapter in CHAPTERS:
        text = chapter.read_text(encoding="utf-8")
        for link in re.findall(r"\]\(([^)#\s]+)", text):
            assert link.startswith("https://") or (GUIDE / link).is_file(), f"{chapter.name}: {link}"
        for path, first, last in re.findall(r"{{#include (\S+?):(\d+):(\d+)}}", text):
            lines = (GUIDE / path).read_text(encoding="utf-8").splitlines()
            assert lines[int(first) - 1].startswith("fn main") and lines[int(last) - 1] == "}", path
