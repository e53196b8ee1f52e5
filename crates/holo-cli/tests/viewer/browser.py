"""Chromium over the DevTools protocol, through a pair of pipes and with the standard library alone."""

import base64
import json
import os
import select
import shutil
import signal
import subprocess
import tempfile
import time

FLAGS = [
    "--headless=new", "--no-sandbox", "--remote-debugging-pipe", "--no-first-run", "--hide-scrollbars",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-extensions",
    "--force-device-scale-factor=1",
    # A page may be larger than the small shared memory of a container.
    "--disable-dev-shm-usage",
]

# WebGL by the processor; the browser then draws the whole page with it, which takes longer.
WEBGL = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


class Browser:
    """One headless browser with one page."""

    def __init__(self, program, size=(1280, 800), patience_s=120, webgl=False):
        self.profile = tempfile.mkdtemp(prefix="holo-viewer-")
        self.patience_s = patience_s
        self.waiting = b""
        self.events = []
        self.number = 0
        # The browser reads commands from descriptor 3 and writes answers to 4. Ours are moved out of the way first, so
        # that putting theirs in place cannot overwrite them.
        theirs_in, self.commands = os.pipe()
        self.answers, theirs_out = os.pipe()
        high_in, high_out = (duplicate_above(fd) for fd in (theirs_in, theirs_out))

        def place():
            os.dup2(high_in, 3)
            os.dup2(high_out, 4)

        self.process = subprocess.Popen(
            [program, *FLAGS, *(WEBGL if webgl else []), f"--window-size={size[0]},{size[1]}", f"--user-data-dir={self.profile}", "about:blank"],
            preexec_fn=place, close_fds=False, start_new_session=True,
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )
        for descriptor in (high_in, high_out):
            os.close(descriptor)
        self.session = None
        targets = self.send("Target.getTargets")["targetInfos"]
        page = next(target for target in targets if target["type"] == "page")
        self.session = self.send("Target.attachToTarget", targetId=page["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.send(f"{domain}.enable")
        self.size(*size)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        # The whole group that was started here, and nothing else.
        try:
            os.killpg(self.process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        self.process.wait()
        os.close(self.commands)
        os.close(self.answers)
        shutil.rmtree(self.profile, ignore_errors=True)

    def send(self, method, **parameters):
        self.number += 1
        command = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            command["sessionId"] = self.session
        rest = json.dumps(command).encode() + b"\0"
        while rest:
            rest = rest[os.write(self.commands, rest):]
        end = time.monotonic() + self.patience_s
        while True:
            answer = self.receive(end - time.monotonic())
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            self.events.append(answer)

    def receive(self, seconds):
        end = time.monotonic() + seconds
        while b"\0" not in self.waiting:
            ready, _, _ = select.select([self.answers], [], [], max(end - time.monotonic(), 0))
            if not ready:
                raise TimeoutError(f"no answer within {self.patience_s} s")
            part = os.read(self.answers, 1 << 20)
            if not part:
                raise EOFError("the browser has ended")
            self.waiting += part
        answer, self.waiting = self.waiting.split(b"\0", 1)
        return json.loads(answer)

    def open(self, address):
        """Opens a page and waits for `window.holo.ready`; returns its seconds."""
        self.send("Page.navigate", url=address)
        # Until the new page has run its scripts there is no `holo`.
        end = time.monotonic() + self.patience_s
        while time.monotonic() < end:
            if self.run("location.href !== 'about:blank' && typeof window.holo === 'object'"):
                return self.run("holo.ready")
            time.sleep(0.02)
        raise TimeoutError("the page did not start")

    def run(self, expression):
        """The value of an expression, waiting for it if it is a promise."""
        result = self.send("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            details = result["exceptionDetails"]
            raise RuntimeError(f"{expression}: {details.get('exception', {}).get('description', details['text'])}")
        return result["result"].get("value")

    def size(self, width, height, ratio=1, touch=False):
        self.send("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=ratio, mobile=touch)

    def mouse(self, kind, x, y, **more):
        self.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def drag(self, start, way, button="left", modifiers=0):
        held = {"left": 1, "right": 2}[button]
        self.mouse("mouseMoved", *start)
        self.mouse("mousePressed", *start, button=button, buttons=held, clickCount=1, modifiers=modifiers)
        for part in (0.5, 1):
            at = [start[axis] + way[axis] * part for axis in (0, 1)]
            self.mouse("mouseMoved", *at, button=button, buttons=held, modifiers=modifiers)
        end = [start[axis] + way[axis] for axis in (0, 1)]
        self.mouse("mouseReleased", *end, button=button, buttons=0, clickCount=1, modifiers=modifiers)

    def click(self, x, y, count=1):
        self.mouse("mouseMoved", x, y)
        for number in range(1, count + 1):
            self.mouse("mousePressed", x, y, button="left", buttons=1, clickCount=number)
            self.mouse("mouseReleased", x, y, button="left", buttons=0, clickCount=number)

    def press(self, key):
        code = {"+": 187, "-": 189, "?": 191}.get(key, ord(key.upper()) if len(key) == 1 else 0)
        text = {"text": key} if len(key) == 1 else {}
        self.send("Input.dispatchKeyEvent", type="keyDown", key=key, windowsVirtualKeyCode=code, **text)
        self.send("Input.dispatchKeyEvent", type="keyUp", key=key, windowsVirtualKeyCode=code)

    def screenshot(self, path):
        with open(path, "wb") as file:
            file.write(base64.b64decode(self.send("Page.captureScreenshot", format="png")["data"]))

    def requests(self):
        """Addresses that were asked for and are not the page itself or part of it."""
        asked = [event["params"]["request"]["url"] for event in self.events if event["method"] == "Network.requestWillBeSent"]
        return [url for url in asked if not url.startswith(("data:", "blob:", "about:"))]

    def complaints(self):
        """Errors and warnings of the page, as text."""
        found = []
        for event in self.events:
            parameters = event["params"]
            if event["method"] == "Runtime.exceptionThrown":
                found.append(parameters["exceptionDetails"].get("exception", {}).get("description", "exception"))
            if event["method"] == "Runtime.consoleAPICalled" and parameters["type"] in ("error", "warning", "assert"):
                found.append(" ".join(str(argument.get("value")) for argument in parameters["args"]))
            if event["method"] == "Log.entryAdded" and parameters["entry"]["level"] == "error":
                found.append(parameters["entry"]["text"])
        return found

    def memory_bytes(self):
        """Proportional set size of all processes of the browser (Linux)."""
        total = 0
        for entry in os.listdir("/proc"):
            try:
                if entry.isdigit() and os.getsid(int(entry)) == self.process.pid:
                    with open(f"/proc/{entry}/smaps_rollup") as lines:
                        total += sum(int(line.split()[1]) * 1024 for line in lines if line.startswith("Pss:"))
            except OSError:
                pass
        return total


def duplicate_above(descriptor):
    """A copy of a descriptor with a number above those that the browser uses, and the original closed."""
    import fcntl

    copy = fcntl.fcntl(descriptor, fcntl.F_DUPFD, 10)
    os.close(descriptor)
    os.set_inheritable(copy, True)
    return copy
