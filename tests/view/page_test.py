#!/usr/bin/env python3
"""page_test.py FEEDER [PICTURE_DIR]: the live page in a headless browser, fed by a made-up fleet.

With PICTURE_DIR it also writes pictures of the page. Exit 77: skipped, there is no browser.
"""

import subprocess
import sys
from pathlib import Path

import browser


class Feeder:
    def __init__(self, program, *options):
        self.process = subprocess.Popen([program, "--port", "0", "--wait", *options],
                                        stdout=subprocess.PIPE, text=True)
        self.url = self.process.stdout.readline().strip()

    def close(self):
        self.process.terminate()
        self.process.wait(10)


def text(page, selector):
    return page.evaluate(f"document.querySelector('{selector}')?.innerText ?? ''")


def expect(condition, what):
    if not condition:
        raise AssertionError(what)


def shows_a_fleet_that_drives(page, feeder, pictures):
    page.open(feeder.url)
    page.wait("document.getElementById('chip')?.textContent === 'live'")
    page.wait("window.rali?.history.last_s >= 120", 120)
    expect("points" in page.evaluate("document.getElementById('view').dataset.state"), "no points")
    expect(page.evaluate("window.rali.store.count") > 20000, "the map has not grown")
    for name in ("v1", "v2", "v3"):
        expect(name in text(page, "#vehicles"), f"{name} is missing")
    expect("stands, v3 and v1 explore" in text(page, "#mission"), text(page, "#mission"))
    expect("anchor" in text(page, "#vehicles"), "nobody is the anchor")
    expect("%" in text(page, "#links"), "links without loss")
    expect("400" in text(page, "#machine") or "Hz" in text(page, "#machine"), "no sensors")
    expect("moved the map by up to 0.67 m" in text(page, "#events"), "the move was not announced")


def goes_back_in_time_and_returns(page, feeder, pictures):
    points = "window.rali.store.points.material.uniforms.now_s.value"
    now_s = page.evaluate(points)
    page.evaluate("const s = document.getElementById('time'); s.value = 40 - window.rali.history.first_s; s.dispatchEvent(new Event('input'))")
    expect(text(page, "#chip") == "past", text(page, "#chip"))
    expect("Round 1: v1 stands" in text(page, "#mission"), text(page, "#mission"))
    expect(page.evaluate(points) < now_s - 20, "the map did not go back")
    if pictures:
        page.picture(pictures / "past.png")
    page.evaluate("document.getElementById('live').click()")
    expect(text(page, "#chip") == "live", text(page, "#chip"))


def names_a_lost_anchor_and_the_order(page, feeder, pictures):
    page.wait("window.rali.history.last_s >= 240", 120)
    panel = text(page, "#lost")
    for part in ("Anchor v3 is lost", "Last seen", "x 44.0 m", "rali operator assume-lost v3"):
        expect(part in panel, f"'{part}' is missing in: {panel}")
    expect("anchor lost" in page.evaluate("document.title"), "the title hides it")


def shows_no_connection_when_the_server_ends(page, feeder, pictures):
    before = list(page.complaints)
    expect(not before, f"the page complains: {before}")
    feeder.close()
    page.wait("document.getElementById('chip').textContent === 'no connection'", 20)


CASES = (shows_a_fleet_that_drives, goes_back_in_time_and_returns, names_a_lost_anchor_and_the_order,
         shows_no_connection_when_the_server_ends)


def main(program, pictures=None):
    if not browser.find_browser():
        print("SKIPPED: there is no browser (chromium)")
        return 77
    folder = Path(pictures) if pictures else None
    feeder = Feeder(program, "--speed", "20", "--until", "245")
    page = browser.Page(1400, 900)
    try:
        for case in CASES:
            case(page, feeder, folder)
            print("ok:", case.__name__, flush=True)
            if folder and case is not CASES[-1]:
                page.picture(folder / f"{case.__name__}.png")
                page.resize(390, 844, True)
                page.evaluate("new Promise((done) => setTimeout(done, 400))")
                page.picture(folder / f"{case.__name__}_phone.png")
                page.resize(1400, 900)
                page.evaluate("new Promise((done) => setTimeout(done, 400))")
    finally:
        page.close()
        feeder.close()
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
