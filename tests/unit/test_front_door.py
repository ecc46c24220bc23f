"""Files for services and archives: they agree with the package and with each other."""

from __future__ import annotations

from pathlib import Path

import pytest

import gspcli

ROOT = Path(gspcli.__file__).resolve().parents[1]


def test_check_prints_the_schema(capsys: pytest.CaptureFixture[str]) -> None:
    from gspcli.cli.main import run

    assert run(["check", "--schema"]) == 0
    recorded = (ROOT / "data" / "instance.schema.json").read_text(encoding="utf-8")
    assert capsys.readouterr().out.rstrip() == recorded.rstrip()
    assert run(["check"]) == 2
    assert run(["check", "--schema", "@dietmaier"]) == 2
