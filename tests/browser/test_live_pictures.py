"""Live pages draw what ordinary pages draw, in several modes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tools.verify.live_pictures import FEW, compared, opened, other_pixels, pages, pictures

if TYPE_CHECKING:
    from tools.browser import Browser

MODES = 3


@pytest.mark.parametrize("name", ["figure-3", "surfaces-ppp", "hexaglide"])
def test_modes_are_drawn_alike_on_both_pages(browser: Browser, tmp_path: Path, name: str) -> None:
    found = compared(browser, name, tmp_path, MODES)
    assert found is not None
    # The first mode alone does not show what belongs to the numbers of the others.
    assert len(found) > 1
    assert all(count <= FEW for count in found.values()), found


def test_another_mode_is_another_picture(browser: Browser, tmp_path: Path) -> None:
    paths = pages("figure-3", tmp_path)
    assert paths is not None
    opened(browser, "live", paths["live"])
    one, two = pictures(browser, "live", [1, 2])
    assert other_pixels(one, two) > 10 * FEW
