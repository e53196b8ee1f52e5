# SPDX-License-Identifier: GPL-3.0-or-later
"""The program `holo` as a process: its arguments, its progress, its end."""

import json
import re
import subprocess
import threading

_TENTH = re.compile(r"(\d+) %")


class Run:
    """A running process. Its lines are read by threads of their own, so that it never waits for a reader."""

    def __init__(self, words):
        self.words = words
        self.process = subprocess.Popen(
            words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8"
        )
        self.lines, self.out, self.share = [], [], 0.0
        self._readers = [
            threading.Thread(target=self._read, args=(self.process.stderr, self._line), daemon=True),
            threading.Thread(target=self._read, args=(self.process.stdout, self.out.append), daemon=True),
        ]
        for reader in self._readers:
            reader.start()

    @staticmethod
    def _read(stream, hand_on):
        for line in stream:
            hand_on(line.rstrip("\n"))

    def _line(self, line):
        found = _TENTH.search(line)
        if line.startswith("rendering:") and found:
            self.share = int(found.group(1)) / 100.0
        elif line:
            self.lines.append(line)

    def is_running(self):
        return self.process.poll() is None

    def stop(self):
        """Ends the process, which removes what it has not finished."""
        if self.is_running():
            self.process.terminate()
            try:
                self.process.wait(timeout=10)
            except subprocess.TimeoutExpired:
                self.process.kill()

    def finish(self):
        """Waits for the end and returns the report of `holo --json`; RuntimeError with its message if it failed."""
        code = self.process.wait()
        for reader in self._readers:
            reader.join()
        if code != 0:
            raise RuntimeError("\n".join(self.lines) or f"holo ended with the code {code}")
        return json.loads(self.out[-1]) if self.out else {}


def words(program, exported, out, options):
    """The command line of a render; `options` are long options of `holo` and their values, None for what is left out."""
    line = [program, "render", str(exported.glb), "--out", str(out), "--camera", exported.camera, "--sky", exported.sky]
    for name, value in options.items():
        if value is True:
            line.append(f"--{name}")
        elif value is not None and value is not False:
            line.append(f"--{name}={value}")
    return [*line, "--overwrite", "--json"]
