"""Every table of poses or values that a command writes is read by all that read tables."""

import pytest

from gspcli.cli.main import run

MASSES = """
dynamics:
  platform: {mass: 1, centre: [0, 0, 0], inertia: [1, 1, 1, 0, 0, 0]}
"""


@pytest.mark.parametrize("name", ["delta", "tricept"])
def test_what_a_command_writes_every_command_reads(name, tmp_path, capsys):
    machine = tmp_path / "machine.yaml"
    assert run(["example", name, "-o", str(machine)]) == 0
    machine.write_text(machine.read_text(encoding="utf-8") + MASSES, encoding="utf-8")

    def written(file, *words):
        path = tmp_path / file
        assert run([*words, "--format", "csv", "-o", str(path)]) == 0, capsys.readouterr().err
        # Two rows say as much as all.
        lines = path.read_text(encoding="utf-8").splitlines()
        path.write_text("\n".join(lines[:3]) + "\n", encoding="utf-8")
        return str(path)

    spec = str(machine)
    along = written("path.csv", "path", spec, "--from", "home", "--to", "home")
    followed = written("track.csv", "track", spec, along, "--mode", "home")
    measured = written("measure.csv", "measure", spec, along)
    for table in (along, followed, measured):
        for command in ("analyze", "clearance", "dynamics", "track"):
            code = run([command, spec, table])
            said = capsys.readouterr().err
            # A path of five rows has no quintic spline: it is read all the same.
            assert code == 0 or "expected at least 6" in said, (command, table, said)
    for table in (along, followed):
        assert run(["measure", spec, table]) == 0, capsys.readouterr().err
