"""Every table of poses or values that a command writes is read by all that read tables."""

import pytest

from gspcli.cli.main import run

MASSES = """
dynamics:
  platform: {mass: 1, centre: [0, 0, 0], inertia: [1, 1, 1, 0, 0, 0]}
"""


@pytest.mark.parametrize("name", ["delta", "tricept", "t-top-head", "workspace-study"])
def test_what_a_command_writes_every_command_reads(name, tmp_path, capsys):
    machine = tmp_path / "machine.yaml"
    assert run(["example", name, "-o", str(machine)]) == 0
    machine.write_text(machine.read_text(encoding="utf-8") + MASSES, encoding="utf-8")
    spec, tables = str(machine), {}

    def write(file, *words):
        path = tmp_path / f"{file}.csv"
        assert run([*words, "--format", "csv", "-o", str(path)]) == 0, capsys.readouterr().err
        # Two rows say as much as all.
        lines = path.read_text(encoding="utf-8").splitlines()
        path.write_text("\n".join(lines[:3]) + "\n", encoding="utf-8")
        tables[file] = str(path)
        return str(path)

    write("solve", "solve", spec)
    along = write("path", "path", spec, "--from", "home", "--to", "home")
    write("track", "track", spec, along, "--mode", "home")
    write("measure", "measure", spec, along)
    write("drives", "measure", spec, along, "--drives")
    write("nearest", "measure", spec, along, "--nearest")
    for file, table in tables.items():
        # Tables of values alone have no poses to measure; other modes are not on one track.
        poses = ["measure"] if file not in ("measure", "drives") else []
        followed = ["track"] if file != "solve" else []
        for command in ("analyze", "clearance", "dynamics", "sensors", *poses, *followed):
            code = run([command, spec, table])
            said = capsys.readouterr().err
            # A path of five rows has no quintic spline: it is read all the same.
            assert code == 0 or "expected at least 6" in said, (command, table, said)
