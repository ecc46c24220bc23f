"""A plate on a table between three round posts: lines that are parallel at every pose."""

from __future__ import annotations

PLATE_ON_POSTS = """
gsp: 1
units: {length: unit, angle: deg}
platform:
  F1: {point: [3, 0, 0]}
  F2: {point: [-1, 2, 0]}
  F3: {point: [-2, -1, 0]}
  face: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}
  H1: {line: {point: [1, 0, 0], direction: [0, 0, 1]}}
  H2: {line: {point: [-1, 1, 0], direction: [0, 0, 1]}}
  H3: {line: {point: [0, -2, 0], direction: [0, 0, 1]}}
base:
  table: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}
  P1: {line: {point: [2, 1, 0], direction: [0, 0, 1]}}
  P2: {line: {point: [-2, 2, 0], direction: [0, 0, 1]}}
  P3: {line: {point: [1, -3, 0], direction: [0, 0, 1]}}
constraints:
  - {distance: [F1, table], value: 0}
  - {distance: [F2, table], value: 0}
  - {distance: [F3, table], value: 0}
  - {distance: [H1, P1], value: 3/2}
  - {distance: [H2, P2], value: 2}
  - {distance: [H3, P3], value: 1}
"""
