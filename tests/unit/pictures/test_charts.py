"""Charts: every datum is in them, and the bytes are the same every time."""

from __future__ import annotations

from gspcli.pictures.charts import bar_chart
from tools.charts import Bubble, bubble_chart, scatter_chart

LABELS = {"x_label": "x", "y_label": "y"}


def bars(heights: dict[int, int]) -> bytes:
    return bar_chart(heights, "svg", title="a title", **LABELS)


def test_a_bar_for_each_number_also_where_there_is_none() -> None:
    # Between 2 and 8 there are four even numbers, and seven with an odd one among them.
    assert bars({2: 5, 8: 3}) == bars({2: 5, 4: 0, 6: 0, 8: 3}) == bars({8: 3, 2: 5})
    filled = b"fill: #1f66b0"
    assert bars({2: 5, 8: 3}).count(filled) == 4
    assert bars({2: 5, 5: 1, 8: 3}).count(filled) == 7
    assert b"<svg" in bars({})


def test_a_point_for_each_pair() -> None:
    points = [(4.0, 1.0), (64.0, 100.0), (16.0, 10.0)]
    one, more = (scatter_chart({"a": points[:n], "b": points[:2]}, "svg", **LABELS) for n in (2, 3))
    assert more.count(b"<use") == one.count(b"<use") + 1
    assert one == scatter_chart({"a": points[:2], "b": points[:2]}, "svg", **LABELS)


def test_a_bubble_for_each_and_a_colour_for_each_group() -> None:
    bubbles = [Bubble(8, 8, 100, "one"), Bubble(64, 16, 3, "two"), Bubble(16, 8, 3, "one")]

    def chart(count: int) -> bytes:
        panels = {"left": bubbles[:count], "right": bubbles[:2]}
        return bubble_chart(panels, "svg", note="a note", **LABELS)

    # Of the same colour and transparency nothing else is drawn.
    assert chart(3).count(b"fill: #0072b2; fill-opacity: 0.6") == (
        chart(2).count(b"fill: #0072b2; fill-opacity: 0.6") + 1
    )
    assert all(colour in chart(2) for colour in (b"#0072b2", b"#e69f00"))
