"""The kernel of live pages, built again."""

from __future__ import annotations

import gzip
import shutil

import pytest

from viewer import kernel as live_module


@pytest.mark.skipif(shutil.which(live_module.COMPILER) is None, reason="no emscripten here")
def test_the_module_is_built_again():
    version = live_module.compiler()
    kept = live_module.kept()
    if version != kept["manifest"]["compiler"]:
        pytest.skip(f"{version} makes another module than {kept['manifest']['compiler']}")
    assert live_module.module(2) == gzip.decompress(live_module.KEPT.read_bytes())
