"""`gsp export --to urdf`: two files, and what is refused."""

from __future__ import annotations

import gspcli


def test_writes_the_loops_beside_the_robot(gsp, tmp_path) -> None:
    target = tmp_path / "nano.urdf"
    outcome = gsp("export", "@nano-hexapod", "--to", "urdf", "-o", str(target))
    assert (outcome.code, outcome.out) == (0, "")
    found = gspcli.exported(gspcli.example("nano-hexapod"), "urdf").files
    assert target.read_text() == found[".urdf"]
    assert target.with_suffix(".yaml").read_text() == found[".yaml"]
    # The loops are not written over by what is made of them.
    again = gsp("import", str(target), "-o", str(target.with_suffix(".yaml")))
    assert again.code == 2
    assert "it is no instance file" in again.err
    assert target.with_suffix(".yaml").read_text() == found[".yaml"]
    assert gsp("import", str(target), "-o", str(target)).code == 2


def test_needs_a_name_for_both(gsp, tmp_path) -> None:
    outcome = gsp("export", "@nano-hexapod", "--to", "urdf", "-o", str(tmp_path / "nano.xml"))
    assert outcome.code == 2
    assert "expected -o NAME.urdf, NAME.yaml is then beside it" in outcome.err
    assert not list(tmp_path.iterdir())
    assert gsp("export", "@nano-hexapod", "--to", "urdf").code == 2
