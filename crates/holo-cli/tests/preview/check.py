"""Uses the page of `holo preview` in headless Chromium as a person would: drag, focus by a click, sliders, gallery, a dropped
scene, a render, a connection that is lost.

    python3 check.py ADDRESS SCENE.glb [--shots FOLDER]

Prints what it measured as JSON. Exit code 0 if everything holds, 77 if there is no Chromium, else 1.
"""

import argparse
import base64
import json
import os
import shutil
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "viewer"))
from browser import Browser  # noqa: E402

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
PATIENCE_S = 60
WINDOW = (1280, 800)


class Check:
    def __init__(self, browser, shots):
        self.browser, self.shots, self.number = browser, shots, 0

    def run(self, expression):
        return self.browser.run(expression)

    def wait(self, expression, what):
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            if self.run(expression):
                return
            time.sleep(0.01)
        status = self.run("[holoPreview.counters, document.getElementById('status').textContent]")
        raise AssertionError(f"{what}: not within {PATIENCE_S} s: {status}")

    def settle(self, what):
        """Waits until the newest look stands still."""
        self.wait("holoPreview.look.settled === holoPreview.look.number && !holoPreview.look.moving", what)

    def shot(self, name):
        if self.shots:
            self.number += 1
            self.browser.screenshot(os.path.join(self.shots, f"{self.number:02}_{name}.png"))

    def setting(self, key):
        return self.run(f"holoPreview.state.settings[{json.dumps(key)}] ?? null")

    def center(self):
        return self.run(
            "(() => { const b = document.getElementById('image').getBoundingClientRect();"
            " return [b.x + b.width / 2, b.y + b.height / 2]; })()"
        )

    def error(self):
        return self.run("document.getElementById('message').hidden ? '' : document.getElementById('message').textContent")


def first_image(check, address):
    start = time.monotonic()
    check.browser.send("Page.navigate", url=address)
    check.wait("typeof holoPreview === 'object' && holoPreview.counters.views > 0", "a first image")
    first = time.monotonic() - start
    check.settle("the first view")
    assert check.run("holoPreview.seen.details !== null && holoPreview.seen.strip !== null")
    assert check.error() == "", check.error()
    # A small image first, then one that stands still: nothing that arrives moves the image and makes it anew.
    looks = check.run("holoPreview.look.number")
    assert looks == 2, looks
    check.shot("start")
    return {"first_image_s": first, "settled_s": time.monotonic() - start}


def drag(check):
    """Images a second while the camera is dragged."""
    before = check.run("holoPreview.seen.view.eye")
    x, y = check.center()
    mouse = check.browser.mouse
    mouse("mouseMoved", x, y)
    mouse("mousePressed", x, y, button="left", buttons=1, clickCount=1)
    count = check.run("holoPreview.counters.views")
    start, seconds, step = time.monotonic(), 3.0, 0
    while time.monotonic() < start + seconds:
        step += 1
        mouse("mouseMoved", x + 60 * ((step % 40) / 20 - 1), y + step % 7, button="left", buttons=1)
        time.sleep(0.015)
    images = (check.run("holoPreview.counters.views") - count) / (time.monotonic() - start)
    check.shot("drag")
    mouse("mouseReleased", x, y, button="left", buttons=0, clickCount=1)
    still = time.monotonic()
    check.settle("the dragged view")
    settled = time.monotonic() - still
    after = check.run("holoPreview.seen.view.eye")
    assert max(abs(a - b) for a, b in zip(before, after)) > 1e-3, "the camera did not move"
    assert check.setting("eye") and check.setting("target")
    command = check.run("document.getElementById('command').textContent")
    assert "--eye" in command and "--target" in command, command
    check.shot("turned")
    check.run("document.getElementById('home').click()")
    check.settle("the scene's own view")
    back = check.run("holoPreview.seen.view.eye")
    assert max(abs(a - b) for a, b in zip(before, back)) < 1e-9, "the camera did not come back"
    return {"images_per_s": images, "settled_after_drag_s": settled}


def focus(check):
    depth = check.run("(() => { const m = holoPreview.seen.details.map;"
                      " return holoPreview.seen.depth[Math.floor(m[1] / 2) * m[0] + Math.floor(m[0] / 2)]; })()")
    check.browser.click(*check.center())
    check.settle("the focus")
    focus_m = float(check.setting("focus-m"))
    assert abs(focus_m - depth) < 1e-3 * depth + 1e-3, (focus_m, depth)
    assert abs(1 / check.run("holoPreview.seen.details.inverse_focus_per_m") - focus_m) < 1e-6 * focus_m
    check.shot("focus")


def sliders(check):
    check.run(
        "(() => { const s = document.querySelector('[data-key=views] input'); s.value = '9';"
        " s.dispatchEvent(new Event('change')); })()"
    )
    check.run(
        "(() => { const s = document.querySelector('[data-key=spacing] select'); s.value = 'disparity';"
        " s.dispatchEvent(new Event('change')); })()"
    )
    check.settle("nine views")
    assert check.run("holoPreview.seen.details.views") == [9, 9]
    text = check.run("document.getElementById('range').textContent")
    assert text.startswith("-1.000 to 1.000 px"), text
    check.run(
        "(() => { const s = document.querySelector('[data-key=ground] input'); s.click(); })()"
    )
    check.settle("a ground")
    assert check.setting("ground") == "true"
    check.run("document.querySelector('[data-key=ground] input').click()")
    check.settle("no ground")
    # A color of CSS is one in linear light for the camera.
    check.run(
        "(() => { const p = document.querySelector('[data-key=backdrop] input[type=color]');"
        " p.value = '#ff00bc'; p.dispatchEvent(new Event('input')); })()"
    )
    check.settle("a backdrop")
    assert check.setting("backdrop") == "1,0,0.503", check.setting("backdrop")
    check.run(
        "(() => { const t = document.querySelector('[data-setting=backdrop]');"
        " t.value = ''; t.dispatchEvent(new Event('change')); })()"
    )
    check.settle("no backdrop")
    check.shot("disparity")


def cameras(check):
    check.run(
        "(() => { const s = document.querySelector('[data-key=camera] select'); s.value = 'lytro-illum';"
        " s.dispatchEvent(new Event('change')); })()"
    )
    check.settle("a plenoptic camera")
    check.wait("!document.getElementById('white-figure').hidden", "a white image")
    assert "--camera-file lytro-illum" in check.run("document.getElementById('command').textContent")
    check.shot("plenoptic")
    check.run(
        "(() => { const s = document.querySelector('[data-key=camera] select'); s.value = '';"
        " s.dispatchEvent(new Event('change')); })()"
    )
    check.settle("the rig again")


def poses(check):
    """The camera stands where a pose of the program does, until it is moved."""
    choose = "(() => {{ const s = document.querySelector('[data-key=pose] select'); s.value = '{}'; s.dispatchEvent(new Event('change')); }})()"
    assert check.run("document.querySelectorAll('[data-key=pose] option').length") == 3
    first = check.run("holoPreview.seen.view.eye")
    check.run(choose.format(1))
    check.settle("the second pose")
    pose = check.run("holoPreview.seen.hello.poses[1]")["settings"]
    numbers = {key: [float(x) for x in pose[key].split(",")] for key in ("eye", "target", "up")}
    back = [e - t for e, t in zip(numbers["eye"], numbers["target"])]
    view = check.run("holoPreview.seen.view")
    for made, expected in ((view["eye"], numbers["eye"]), (view["back"], back), (view["up"], numbers["up"])):
        assert all(abs(a - b) < 1e-6 for a, b in zip(made, expected)), (made, expected)
    assert abs(view["fov_deg"] - 40) < 1e-6 and view["eye"] != first, view
    assert "--eye" in check.run("document.getElementById('command').textContent")
    check.shot("pose")
    check.run("document.getElementById('image').focus()")
    check.browser.press("ArrowLeft")
    check.settle("moved away")
    assert check.run("document.querySelector('[data-key=pose] select').value") == "" and check.setting("up") is None
    check.run("document.getElementById('home').click()")
    check.settle("home")
    check.run(
        "(() => { const s = document.querySelector('[data-setting=fov-deg]'); s.value = ''; s.dispatchEvent(new Event('change')); })()"
    )
    check.settle("the angle of the scene")


def gallery(check):
    check.run("document.getElementById('gallery-button').click()")
    check.wait("document.querySelectorAll('#gallery img').length >= 15", "images of the gallery")
    check.shot("gallery")
    check.run("document.querySelector('[data-scene=chess]').click()")
    check.settle("chess")
    assert check.run("document.getElementById('title').textContent") == "chess"
    check.shot("chess")


def frames(check):
    """A scene that moves has a frame, and a range of them is rendered whole."""
    frame = "document.querySelector('[data-key=frame]')"
    assert check.run(f"{frame}.hidden"), "chess rests"
    check.run("document.querySelector('[data-scene=pendulum]').click()")
    check.settle("pendulum")
    assert not check.run(f"{frame}.hidden") and check.run("holoPreview.seen.scene.frames") > 1
    rest = check.run("Array.from(holoPreview.seen.depth).join()")
    check.run(f"(() => {{ const s = {frame}.querySelector('input[data-setting]'); s.value = '12-14';"
              " s.dispatchEvent(new Event('change')); })()")
    check.settle("frame 12")
    assert check.run("Array.from(holoPreview.seen.depth).join()") != rest, "nothing moved"
    assert "for each of 3 frames" in check.run("document.getElementById('estimate').textContent")
    assert "--frame" in check.run("document.getElementById('command').textContent")
    check.shot("frames")


def drop(check, scene):
    with open(scene, "rb") as file:
        data = base64.b64encode(file.read()).decode()
    check.run(
        f"(async () => {{ const bytes = Uint8Array.from(atob({json.dumps(data)}), (c) => c.charCodeAt(0));"
        " await holoPreview.openFile(new File([bytes], 'dropped.glb')); })()"
    )
    check.settle("a dropped scene")
    assert check.run("document.getElementById('title').textContent") == "dropped"
    check.run("(async () => { await holoPreview.openFile(new File([new Uint8Array(8)], 'bad.glb')); })()")
    check.wait("holoPreview.counters.errors.length > 0", "an error of a scene that is none")
    assert "bad.glb" in check.error() or "bad" in check.error(), check.error()
    check.shot("bad_scene")


def render(check):
    check.run("document.querySelector('[data-scene=plaster]').click()")
    for key, value in (("views", "3"), ("lenses", "48x32")):
        if key == "lenses":
            check.run(
                "(() => { const s = document.querySelector('[data-key=sensor] select'); s.value = '';"
                " s.dispatchEvent(new Event('change')); })()"
            )
        check.run(
            f"(() => {{ const s = document.querySelector('input[data-setting={key}]'); s.value = '{value}';"
            " s.dispatchEvent(new Event('change')); })()"
        )
    check.settle("a small rig")
    check.run("window.open = (address) => { window.opened = address; }")
    check.run("document.getElementById('render').click()")
    check.wait("holoPreview.counters.rendered === 2", "a draft and the full render")
    assert "/view/1?token=" in check.run("window.opened"), check.run("window.opened")
    assert check.run("document.querySelectorAll('#finished a').length") == 2
    check.shot("rendered")
    return check.run("new URL(window.opened, location.href).href")


def reconnect(check):
    opened = check.run("holoPreview.counters.views")
    check.run("holoPreview.drop()")
    check.wait(f"holoPreview.counters.views > {opened}", "an image after the connection was lost")
    check.settle("the view after the connection was lost")


def keyboard(check):
    check.run("document.getElementById('image').focus()")
    before = check.run("holoPreview.seen.view.eye")
    check.browser.press("ArrowLeft")
    check.settle("a turn by key")
    assert check.run("holoPreview.seen.view.eye") != before
    check.browser.press("?")
    assert not check.run("document.getElementById('help').hidden")
    check.shot("help")
    check.browser.press("Escape")


def hostile(check, address):
    """Another page in the same browser gets nothing."""
    host = address.split("/?")[0]
    check.browser.send("Page.navigate", url="about:blank")
    time.sleep(0.3)
    for path in ("/", "/socket", "/preview.js"):
        read = f"fetch('{host}{path}').then((a) => a.text(), () => 'refused')"
        assert check.run(read) == "refused", path
    with_token = address.replace("http://", "ws://").replace("/?", "/socket?")
    opened = (
        f"new Promise((done) => {{ const s = new WebSocket('{with_token}');"
        " s.onopen = () => done('open'); s.onerror = () => done('refused'); })"
    )
    assert check.run(opened) == "refused", "a page of another origin opened the socket"


def phone(check, address):
    check.browser.size(390, 844, ratio=2, touch=True)
    check.browser.send("Page.navigate", url=address)
    check.wait("typeof holoPreview === 'object' && holoPreview.counters.views > 0", "an image on a phone")
    check.settle("the view on a phone")
    assert check.run("document.documentElement.scrollWidth") <= 390
    check.shot("phone")


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("address")
    arguments.add_argument("scene")
    arguments.add_argument("--shots")
    options = arguments.parse_args()
    named = os.environ.get("HOLO_CHROMIUM")
    program = next((found for found in map(shutil.which, [named] if named else NAMES) if found), None)
    if program is None:
        print("no Chromium")
        return 77
    if options.shots:
        os.makedirs(options.shots, exist_ok=True)
    # A small window is drawn sooner, by a program that is not optimized.
    with Browser(program, size=WINDOW if options.shots else (880, 420)) as browser:
        check = Check(browser, options.shots)
        found = first_image(check, options.address)
        found.update(drag(check))
        focus(check)
        sliders(check)
        cameras(check)
        poses(check)
        keyboard(check)
        reconnect(check)
        gallery(check)
        frames(check)
        drop(check, options.scene)
        view = render(check)
        phone(check, options.address)
        browser.size(*WINDOW)
        browser.open(view)
        check.shot("viewer")
        hostile(check, options.address)
        print(json.dumps({name: round(value, 3) for name, value in found.items()}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
