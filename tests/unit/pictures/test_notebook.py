"""Results in notebooks."""

from __future__ import annotations

from html import unescape

import gspcli
from gspcli.resources import instance_files


def test_a_result_shows_itself_in_a_frame() -> None:
    result = gspcli.solve(gspcli.load(instance_files()["octahedral-3-3"]))
    text = result._repr_html_()
    assert text.startswith('<iframe srcdoc="')
    assert text.count("<iframe") == 1
    document = unescape(text.partition('srcdoc="')[2].partition('"')[0])
    assert document.startswith("<!doctype html>")
    assert document.rstrip().endswith("</html>")
    assert "Octahedral 3-3 platform" in document
