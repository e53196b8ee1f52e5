"""Drives a page of `holo view` in headless Chromium and holds what it shows to the files that it was made of.

    python3 check.py PAGE.html RAW_el.png [--truth DISPARITY.pfm] [--estimate ESTIMATE.pfm] [--no-rig]
                     [--address-part '#canvas'] [--shots FOLDER]

The views and lenses are what the page says; that they are right is for the caller to compare (it prints them). Exit code 0
if everything holds, 77 if there is no Chromium, else 1.
"""

import argparse
import math
import os
import shutil
import struct
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from browser import Browser  # noqa: E402
from png import Image  # noqa: E402

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


def read_pfm(path):
    with open(path, "rb") as file:
        assert file.readline().strip() == b"Pf"
        width, height = map(int, file.readline().split())
        assert file.readline().strip() == b"-1"
        values = struct.unpack(f"<{width * height}f", file.read())
    return [values[(height - 1 - row) * width : (height - row) * width] for row in range(height)]


class Check:
    def __init__(self, browser, image, truth, estimate):
        self.browser, self.image, self.truth, self.estimate = browser, image, truth, estimate
        state = self.state()
        self.views, self.lenses, self.central = state["views"], state["lenses"], state["centralView"]
        self.done = 0

    def state(self):
        return self.browser.run("holo.state()")

    def settle(self):
        self.browser.run("holo.settled()")

    def equal(self, found, expected, what):
        self.done += 1
        if found != expected:
            raise AssertionError(f"{what}: {found} instead of {expected}")

    def raw(self, lens, view):
        """The pixel of the file that lens and view share."""
        return self.image.at(*(lens[axis] * self.views[axis] + view[axis] for axis in (0, 1)))

    def place(self, column, row):
        return self.browser.run(f"holo.placeOf({column}, {row})")

    def colour(self, column, row):
        x, y = self.place(column, row)
        return self.browser.run(f"holo.colorAt({x}, {y})")

    def some_lenses(self):
        columns = sorted({0, 1, self.lenses[0] // 3, self.lenses[0] // 2, self.lenses[0] - 1} & set(range(self.lenses[0])))
        rows = sorted({0, self.lenses[1] // 3, self.lenses[1] - 1})
        return [[column, row] for column in columns for row in rows]

    def shows_view(self, view):
        """Every looked-at pixel has exactly the colour of that view's pixel in the file."""
        self.settle()
        self.equal(self.state()["view"], list(view), "the view")
        for lens in self.some_lenses():
            x, y = self.place(*lens)
            if not self.on_stage(x, y):
                continue
            self.equal(self.colour(*lens), self.raw(lens, view), f"lens {lens} of view {view}")

    def on_stage(self, x, y):
        """Whether this is the picture: not beyond the window, nor below the bar or the grid of views."""
        return self.browser.run(f"document.elementFromPoint({x}, {y})?.id === 'image'")

    def middle(self):
        return self.browser.run("(() => { const b = document.getElementById('image').getBoundingClientRect();"
                                "return [b.left + b.width / 2, b.top + b.height / 2]; })()")

    # What follows is one promise of the page each.

    def pixels_fade_into_each_other_until_i_is_pressed(self):
        pressed = "document.getElementById('smooth').getAttribute('aria-pressed')"
        self.equal(self.browser.run(pressed), "true", "smooth at first")
        self.browser.press("i")
        self.equal(self.browser.run(pressed), "false", "smooth after I")

    def dragging_moves_the_view(self):
        self.browser.press("1")
        self.equal(self.state()["view"], self.central, "the first view")
        self.shows_view(self.central)
        step = self.state()["pixelsPerView"]
        for ways in ((1, 0), (0, 1), (-2, -1), (2, 2), (-1000, 0), (1000, 1000)):
            before = self.state()["view"]
            expected = [min(max(before[axis] + ways[axis], 0), self.views[axis] - 1) for axis in (0, 1)]
            # A little more than a whole number of steps: trunc(n + 0.3) views, and events have whole pixels.
            way = [math.copysign(abs(count) * step + 0.3 * step, count) if count else 0 for count in ways]
            self.browser.drag(self.middle(), [max(-600, min(600, part)) for part in way])
            self.shows_view(expected)

    def keys_move_the_view(self):
        self.browser.press("0")
        for key, way in (("ArrowRight", (1, 0)), ("ArrowUp", (0, -1)), ("ArrowLeft", (-1, 0)), ("ArrowDown", (0, 1))):
            before = self.state()["view"]
            expected = [min(max(before[axis] + way[axis], 0), self.views[axis] - 1) for axis in (0, 1)]
            self.browser.press(key)
            self.shows_view(expected)
        self.browser.press("ArrowRight")
        self.browser.press("0")
        self.shows_view(self.central)

    def the_inset_goes_to_a_view(self):
        if self.views == [1, 1]:
            self.equal(self.browser.run("document.getElementById('inset').hidden"), True, "an inset of one view")
            return
        left, top, width, height = self.browser.run(
            "(() => { const b = document.getElementById('inset').getBoundingClientRect();"
            "return [b.left, b.top, b.width, b.height]; })()")
        # The last view; the frame is 8 px wide.
        self.browser.click(left + width - 9.5, top + height - 9.5)
        self.shows_view([count - 1 for count in self.views])
        self.browser.press("0")

    def grids_are_the_file(self):
        self.browser.press("2")
        self.equal(self.state()["mode"], "raw", "key 2")
        for lens in self.some_lenses():
            for view in ([0, 0], [count - 1 for count in self.views]):
                at = [lens[axis] * self.views[axis] + view[axis] for axis in (0, 1)]
                self.browser.run(f"holo.zoomTo({at[0]}, {at[1]}, 6, 6)")
                self.settle()
                self.equal(self.colour(*at), self.image.at(*at), f"raw pixel {at}")
                self.browser.mouse("mouseMoved", *self.place(*at))
                found = self.browser.run("holo.readout()")
                self.equal([found["lens"], found["view"]], [lens, view], f"what is told of raw pixel {at}")
        self.browser.press("3")
        self.equal(self.state()["mode"], "views", "key 3")
        for view in ([0, 0], self.central, [count - 1 for count in self.views]):
            lens = [self.lenses[0] // 2, self.lenses[1] - 1]
            at = [view[axis] * self.lenses[axis] + lens[axis] for axis in (0, 1)]
            self.browser.run(f"holo.zoomTo({at[0]}, {at[1]}, 6, 6)")
            self.settle()
            self.equal(self.colour(*at), self.raw(lens, view), f"pixel {at} of the grid of views")
            self.browser.mouse("mouseMoved", *self.place(*at))
            found = self.browser.run("holo.readout()")
            self.equal([found["lens"], found["view"]], [lens, view], f"what is told of pixel {at}")
        self.browser.press("0")
        self.browser.press("1")

    def the_wheel_zooms_where_the_pointer_is(self):
        self.browser.press("2")
        x, y = self.middle()
        x, y = x + 37, y - 21
        self.browser.mouse("mouseMoved", x, y)
        before = self.browser.run("holo.readout()")
        for _ in range(8):
            self.browser.mouse("mouseWheel", x, y, deltaX=0, deltaY=-100)
        self.settle()
        self.browser.mouse("mouseMoved", x, y)
        after = self.browser.run("holo.readout()")
        self.equal([after and after["lens"], after and after["view"]], [before and before["lens"], before and before["view"]],
                   "the pixel under the pointer after zooming")
        # The right button pans: what was under it goes along, to less than a pixel of rounding.
        place = self.place(0, 0)
        self.browser.drag((x, y), (40, 24), button="right")
        moved = self.place(0, 0)
        self.equal([round(moved[axis] - place[axis]) for axis in (0, 1)], [40, 24], "panned by")
        self.browser.press("0")
        self.browser.press("1")

    def double_click_goes_to_the_lens_and_back(self):
        lens = [self.lenses[0] // 2, self.lenses[1] // 2]
        self.browser.click(*self.place(*lens), count=2)
        self.settle()
        self.equal(self.state()["mode"], "raw", "after a double click")
        view = [count - 1 for count in self.views]
        at = [lens[axis] * self.views[axis] + view[axis] for axis in (0, 1)]
        self.equal(self.on_stage(*self.place(*at)), True, "the lens is on the screen")
        self.browser.click(*self.place(*at), count=2)
        self.equal(self.state()["mode"], "view", "after another double click")
        self.shows_view(view)
        self.browser.press("0")

    def refocusing_averages_the_views(self):
        if self.views == [1, 1]:
            self.equal(self.browser.run("document.getElementById('refocus').disabled"), True, "refocusing one view")
            return
        limits = self.state()["range"]
        box = self.browser.run("(() => { const b = document.getElementById('disparity').getBoundingClientRect();"
                               "return [b.left, b.top, b.width, b.height]; })()")
        self.browser.click(box[0] + 0.8 * box[2], box[1] + box[3] / 2)
        state = self.state()
        # The middle of the knob, 16 px wide, runs from 8 px to 8 px before the end.
        part = (0.8 * box[2] - 8) / (box[2] - 16)
        expected = limits["low"] + part * (limits["high"] - limits["low"])
        # A click has whole pixels, and the knob rests on whole steps.
        near = abs(state["disparity"] - expected) <= 1.5 * (limits["high"] - limits["low"]) / (box[2] - 16) + limits["step"]
        self.equal((state["refocus"], near), (True, True), f"the slider at {state['disparity']}, about {expected}")
        self.shows_average(state["disparity"])
        self.browser.run("document.activeElement.blur()")
        self.browser.press("-")
        after = self.state()["disparity"]
        self.equal(round((state["disparity"] - after) / limits["step"]), 5, "steps of the key -")
        for disparity in (0, limits["low"], after):
            self.browser.run(f"holo.setDisparity({disparity})")
            self.shows_average(self.state()["disparity"])
        # Drawing again while views are still being added does not add them twice.
        self.browser.run(f"holo.setDisparity({after / 2})")
        for _ in range(4):
            self.browser.run("new Promise((done) => setTimeout(done, 125)).then(() => { holo.settled(); })")
        self.shows_average(self.state()["disparity"])
        # From another view the same, about that one.
        self.browser.press("ArrowLeft")
        self.shows_average(self.state()["disparity"])
        self.browser.press("f")
        self.shows_view(self.state()["view"])
        self.browser.press("0")

    def shows_average(self, disparity):
        self.settle()
        centre = self.state()["view"]
        vertical = disparity * self.vertical
        for lens in self.some_lenses()[:: 1 if self.views[0] * self.views[1] < 100 else 5]:
            if not self.on_stage(*self.place(*lens)):
                continue
            expected = self.average(lens, centre, disparity, vertical)
            found = self.colour(*lens)
            # 0.44 of a code from the polynomial, 0.5 from rounding to eight bits, some float rounding.
            worst = max(abs(a - b) for a, b in zip(found, expected))
            self.done += 1
            if worst > 1.0:
                raise AssertionError(f"lens {lens} refocused at {disparity} from {centre}: {found} instead of {expected}")

    def average(self, lens, centre, disparity, vertical):
        sums, count = [0.0] * 3, 0
        for t in range(self.views[1]):
            for s in range(self.views[0]):
                x = lens[0] - disparity * (s - centre[0])
                y = lens[1] - vertical * (t - centre[1])
                if not (-0.5 <= x <= self.lenses[0] - 0.5 and -0.5 <= y <= self.lenses[1] - 0.5):
                    continue
                count += 1
                for down, weight_y in ((0, 1 - (y - math.floor(y))), (1, y - math.floor(y))):
                    for along, weight_x in ((0, 1 - (x - math.floor(x))), (1, x - math.floor(x))):
                        u = min(max(math.floor(x) + along, 0), self.lenses[0] - 1)
                        v = min(max(math.floor(y) + down, 0), self.lenses[1] - 1)
                        colour = self.raw([u, v], [s, t])
                        sums = [total + weight_x * weight_y * decoded(code) for total, code in zip(sums, colour)]
        return [encoded(total / count) for total in sums]

    def maps_are_told_and_drawn(self):
        modes = self.state()["modes"]
        self.equal("depth" in modes, bool(self.truth or self.estimate), "whether there is a depth picture")
        self.equal("error" in modes, bool(self.truth and self.estimate), "whether there is an error picture")
        for key, mode in (("4", "depth"), ("5", "error")):
            self.browser.press(key)
            if mode not in modes:
                self.equal(self.state()["mode"] != mode, True, f"key {key} without a map")
                continue
            self.equal(self.state()["mode"], mode, f"key {key}")
            self.settle()
            self.equal(self.browser.run("!document.getElementById('legend').hidden"), True, "the legend")
            for lens in self.some_lenses():
                if not self.on_stage(*self.place(*lens)):
                    continue
                self.browser.mouse("mouseMoved", *self.place(*lens))
                found = self.browser.run("(() => { const r = holo.readout(); return [r.lens, String(r.disparity), String(r.error)]; })()")
                self.equal(found[0], lens, "the lens of a map's pixel")
                if self.truth:
                    self.equal(number(found[1]), self.truth[lens[1]][lens[0]], f"disparity of lens {lens}")
                if mode == "error":
                    # The page subtracts in f64 and keeps f32.
                    error = self.estimate[lens[1]][lens[0]] - self.truth[lens[1]][lens[0]]
                    self.equal(number(found[2]), struct.unpack("<f", struct.pack("<f", error))[0], f"error of lens {lens}")
        self.browser.press("1")

    def a_finger_and_two(self):
        """A finger moves the view as the mouse does; two zoom."""
        self.browser.press("0")
        before = self.state()
        x, y = self.middle()
        way = before["pixelsPerView"] * 1.3

        def touch(kind, *points):
            self.browser.send("Input.dispatchTouchEvent", type=kind,
                              touchPoints=[{"x": a, "y": b, "id": number} for number, (a, b) in enumerate(points)])

        touch("touchStart", (x, y))
        touch("touchMove", (x + way / 2, y))
        touch("touchMove", (x + way, y))
        touch("touchEnd")
        self.shows_view([min(before["view"][0] + 1, self.views[0] - 1), before["view"][1]])
        width = [self.place(1, 0)[0] - self.place(0, 0)[0]]
        touch("touchStart", (x - 50, y), (x + 50, y))
        touch("touchMove", (x - 75, y), (x + 75, y))
        touch("touchMove", (x - 100, y), (x + 100, y))
        touch("touchEnd")
        width.append(self.place(1, 0)[0] - self.place(0, 0)[0])
        self.equal(round(width[1] / width[0], 2), 2.0, "a pinch to twice the distance")
        self.browser.press("0")


def decoded(code):
    value = code / 255
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def encoded(value):
    return 255 * (12.92 * value if value <= 0.0031308 else 1.055 * value ** (1 / 2.4) - 0.055)


def number(text):
    return math.inf if text == "Infinity" else -math.inf if text == "-Infinity" else float(text)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("page")
    parser.add_argument("raw")
    parser.add_argument("--truth")
    parser.add_argument("--estimate")
    parser.add_argument("--vertical", type=float, default=1, help="vertical disparity per horizontal one")
    parser.add_argument("--address-part", default="")
    parser.add_argument("--renderer", default="webgl2")
    parser.add_argument("--shots")
    options = parser.parse_args()
    program = os.environ.get("HOLO_CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)
    if not program:
        return 77
    address = "file://" + os.path.abspath(options.page)
    # Large enough for all controls, and small for a browser without a graphics card.
    with Browser(program, size=(800, 300), webgl=options.renderer == "webgl2") as browser:
        browser.send("Emulation.setTouchEmulationEnabled", enabled=False)
        seconds = browser.open(address + options.address_part)
        maps = [path and read_pfm(path) for path in (options.truth, options.estimate)]
        check = Check(browser, Image(options.raw), *maps)
        check.vertical = options.vertical
        check.equal(check.state()["renderer"], options.renderer, "what draws")
        for part in (
            check.pixels_fade_into_each_other_until_i_is_pressed,
            check.dragging_moves_the_view, check.keys_move_the_view, check.the_inset_goes_to_a_view,
            check.grids_are_the_file, check.the_wheel_zooms_where_the_pointer_is,
            check.double_click_goes_to_the_lens_and_back, check.refocusing_averages_the_views,
            check.maps_are_told_and_drawn, check.a_finger_and_two,
        ):
            part()
            if options.shots:
                browser.screenshot(os.path.join(options.shots, f"{part.__name__}.png"))
        check.equal([url for url in browser.requests() if url.split("#")[0] != address], [], "requests")
        check.equal(browser.complaints(), [], "complaints of the page")
        memory = browser.memory_bytes() / 1e6
    views, lenses = check.views, check.lenses
    print(f"{check.done} comparisons hold: {views[0]} x {views[1]} views of {lenses[0]} x {lenses[1]} px, "
          f"ready after {seconds:.2f} s, {memory:.0f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
