"""Machines with points that stay on planes: a tripod, and a bed on three balls."""

from __future__ import annotations

from dataclasses import replace

from gspcli.catalogue.kinds import DPH
from gspcli.geometry.instance import Instance
from gspcli.geometry.primitives import Crank, Point, Slide
from gspcli.spec import loads


def tripod() -> Instance:
    """Three cranks; points of the platform stay in planes through the middle of the base."""
    lines = ["gsp: 1", "units: {length: in, angle: deg}", "platform:"]
    base, rows = ["base:"], ["constraints:"]
    for k, a in enumerate((-90, 30, 150), 1):
        lines.append(f"  P{k}: {{point: [3.125*cosd({a}), 3.125*sind({a}), 0]}}")
        far, up = "(2+1.75*cosd(20.634494627))", "1.75*sind(20.634494627)"
        base.append(
            f"  B{k}: {{point: [{far}*cosd({a}), {far}*sind({a}), {up}], crank: {{centre: "
            f"[2*cosd({a}), 2*sind({a}), 0], axis: [sind({a}), -cosd({a}), 0], range: [-60, 60]}}}}"
        )
        base.append(f"  H{k}: {{plane: {{point: [0, 0, 0], normal: [-sind({a}), cosd({a}), 0]}}}}")
        rows.append(f"  - {{distance: [P{k}, B{k}], value: 3.669291339}}")
        rows.append(f"  - {{distance: [P{k}, H{k}], value: 0}}")
    home = "home: {position: [0, 0, 4.25]}"
    return loads("\n".join([*lines, *base, *rows, home]) + "\n")


def cranked_bed(*, exchanged: bool = False) -> Instance:
    """Return a bed whose balls are moved by cranks, or its balls ride on the bed."""
    rows = []
    for row in print_bed().constraints:
        at = row.base.point
        ball = Point(at, crank=Crank(at - [10, 40, 5], [1.0, -0.2, 0.1]))
        names = {"platform_name": row.base_name, "base_name": row.platform_name}
        if exchanged:
            own = Point(at, slide=Slide([0.1, 0, 1]))
            rows.append(replace(row, kind=DPH, platform=own, base=row.platform, **names))
        else:
            rows.append(replace(row, base=ball))
    return replace(print_bed(), constraints=tuple(rows))


def print_bed() -> Instance:
    """Return a bed with three vee grooves on three balls, each of which a slide moves."""
    lines = ["gsp: 1", "units: {length: mm, angle: deg}", "platform:"]
    base, rows = ["base:"], ["constraints:"]
    balls = (95, 180, "180.000000"), (380, 335, "58.495733"), (380, 25, "-58.495733")
    for k, (x, y, angle) in enumerate(balls, 1):
        for side, sign in (("a", -1), ("b", 1)):
            normal = f"[{sign}*sind({angle}), {-sign}*cosd({angle}), -1]"
            lines.append(
                f"  V{k}{side}: {{plane: {{point: [{x}, {y}, 5*sqrt(2)], normal: {normal}}}}}"
            )
            rows.append(f"  - {{distance: [V{k}{side}, B{k}], value: 5, side: positive}}")
        slide = "slide: {direction: [0, 0, 1], range: [-10, 300]}"
        base.append(f"  B{k}: {{point: [{x}, {y}, 0], {slide}}}")
    return loads("\n".join([*lines, *base, *rows, "home: {position: [0, 0, 0]}"]) + "\n")
