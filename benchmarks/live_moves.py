"""Moves of live pages on a slow processor, and the memory that they keep.

    python -m benchmarks.live_moves [NAME ...] [--rate 4] [--moves 100]

Each NAME is a shipped platform, or a type of which a random platform is taken. Its live page
(`gsp view --live`) is opened in headless Chromium. One value moves by small steps, one a picture.
Measured are

- the processor time of the page's thread for a move, with all its drawing (DevTools'
  ``TaskDuration`` in the time domain ``threadTicks``). Other work on the machine does not change
  it. It is printed as measured, and times the rate for a slower processor;
- the time by the clock for which the thread is busy with the picture of a move (median), how many
  modes move at once, and the time at rest after which all modes are there. It is printed as
  measured, and with the thread slowed down by DevTools (``Emulation.setCPUThrottlingRate``; workers
  are not slowed down);
- memory: the heap of JavaScript and of what the page holds (``Runtime.getHeapUsage``, after
  collecting garbage twice) before and after each of four series of moves over the same values.
"""

from __future__ import annotations

import argparse
import itertools
import statistics
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from gspcli.catalogue.names import parse_type
from gspcli.geometry.instance import Instance
from gspcli.geometry.random_instances import random_instance
from gspcli.pictures.live_numbers import live_numbers, live_page
from gspcli.pictures.stage import first_mode, scene_of
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import load
from tests.support.browser import CHROMIUM, Browser

#: A hexapod of 28 poses, and a type of 1152.
DEFAULT = ("nano-hexapod", "DPL DPL DLP DLP DLL ALL")
#: The value that moves goes to and fro by this part of itself.
_PART = 1e-3
_SERIES = 4
#: How long a picture keeps the thread busy: until the next task, which comes after drawing.
_MEASURE = """
(() => {
  window.busyFor = [];
  const ask = window.requestAnimationFrame.bind(window);
  const { port1, port2 } = new MessageChannel();
  let began = null;
  port1.onmessage = () => { busyFor.push(performance.now() - began); began = null; };
  window.requestAnimationFrame = (draw) => ask((now) => {
    if (window.isMoving) {
      window.isMoving = false;
      began = performance.now();
      port2.postMessage(0);
    }
    draw(now);
  });
})()
"""
_READY = "document.documentElement.dataset.ready === 'true'"
_REST = "document.getElementById('busy').hidden"
#: The map beside the page is filled, or takes longer than a minute.
_FILLED = """
new Promise((done) => {
  const end = performance.now() + 60000;
  const look = () => document.getElementById('map').dataset.filled === 'true'
    || document.getElementById('map-part').hidden || performance.now() > end
    ? done() : setTimeout(look, 100);
  look();
})
"""
_LISTED = "document.querySelectorAll('#modes tbody tr:not(.gone)').length"


def platform(name: str) -> Instance:
    """Return a shipped platform, or a random one of a type."""
    if name in instance_files():
        return load(instance_files()[name])
    return random_instance(parse_type(name), np.random.default_rng(1))[0]


def move(browser: Browser, value: float, *, rest: bool = False) -> None:
    """Move the first value; the next picture is drawn when this returns."""
    browser.run(
        "(() => { window.isMoving = true; const one = document.getElementById('value-1');"
        f" one.value = {value!r};"
        " one.dispatchEvent(new Event('change')); })()"
    )
    browser.settle()
    if rest:
        browser.wait(_REST)


def values(instance: Instance, count: int) -> Iterator[float]:
    """Yield values that go to and fro about that of the first constraint."""
    middle = instance.constraints[0].value.value
    for k in range(count):
        yield middle * (1 + _PART * float(np.sin(2 * np.pi * k / count)))


def moved(browser: Browser, path: Path, instance: Instance, rate: float, count: int) -> str:
    """Return what moves take on a processor that is this many times slower."""
    browser.call("Emulation.setCPUThrottlingRate", rate=1)
    browser.open(path)
    browser.wait(_READY)
    browser.wait(_REST)
    browser.run(_FILLED)
    everything = browser.run(_LISTED)
    browser.call("Emulation.setCPUThrottlingRate", rate=rate)
    browser.run(_MEASURE)
    for value in values(instance, 8):
        move(browser, value, rest=True)
    browser.run("busyFor.length = 0")
    before = processor_time(browser)
    for value in values(instance, count):
        move(browser, value)
    spent = (processor_time(browser) - before) / count * 1e3
    at_once = browser.run(_LISTED)
    times = browser.run("busyFor")
    browser.run("window.began = performance.now()")
    browser.wait(_REST)
    later = browser.run("performance.now() - window.began")
    browser.call("Emulation.setCPUThrottlingRate", rate=1)
    all_of = f"all {everything}" if at_once == everything else f"{at_once} of {everything}"
    return (
        f"rate {rate:g}: {statistics.median(times):.1f} ms a move by the clock (median of "
        f"{len(times)}), {spent:.1f} ms of the processor; {all_of} real modes move, all are there "
        f"{later:.0f} ms after the last"
    )


def processor_time(browser: Browser) -> float:
    """Return the processor time of the page's thread so far, in seconds."""
    metrics = browser.call("Performance.getMetrics")["metrics"]
    return float(next(one["value"] for one in metrics if one["name"] == "TaskDuration"))


def kept(browser: Browser, path: Path, instance: Instance, count: int) -> str:
    """Return how many bytes a move keeps, by series of moves."""
    browser.open(path)
    browser.wait(_READY)
    browser.wait(_REST)
    browser.run(_FILLED)
    sizes = []
    for _ in range(_SERIES + 1):
        for value in values(instance, count):
            move(browser, value)
        browser.wait(_REST)
        for _ in range(2):
            browser.call("HeapProfiler.collectGarbage")
        usage = browser.call("Runtime.getHeapUsage")
        sizes.append(sum(usage.get(key, 0) for key in ("usedSize", "embedderHeapUsedSize")))
    grown = [f"{(b - a) / count:.0f}" for a, b in itertools.pairwise(sizes)]
    return f"memory: {', '.join(grown)} bytes a move kept in {_SERIES} series of {count} moves"


def main() -> int:
    """Measure moves; return the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", default=DEFAULT, metavar="NAME")
    parser.add_argument("--rate", type=float, default=4, help="how many times slower (default: 4)")
    parser.add_argument("--moves", type=int, default=100, help="moves of a series (default: 100)")
    arguments = parser.parse_args()
    if CHROMIUM is None:
        print("Chromium is not installed", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory() as folder:
        browser = Browser(Path(folder) / "profile")
        browser.size(1280, 800)
        browser.call("Performance.enable", timeDomain="threadTicks")
        for name in arguments.names:
            instance = platform(name)
            result = solve(instance)
            path = Path(folder) / "live.html"
            scene, start = scene_of(result), first_mode(result)
            path.write_text(live_page(scene, live_numbers(result), start), encoding="utf-8")
            print(f"{name}: {result.counts.found} poses, {result.counts.real} real")
            for rate in (1, arguments.rate):
                print(f"  {moved(browser, path, instance, rate, arguments.moves)}", flush=True)
            print(f"  {kept(browser, path, instance, arguments.moves)}", flush=True)
        browser.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
