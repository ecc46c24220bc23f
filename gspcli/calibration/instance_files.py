"""The instance file of a calibrated platform: each number with its deviation beside it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from gspcli.calibration.results import Calibration
from gspcli.spec import dumps


def calibrated_text(result: Calibration, remarks_of_log: Sequence[str] = ()) -> str:
    """Return the file of what was found, with comments: ± the standard deviation of each number.

    Parameters
    ----------
    result
        What was found.
    remarks_of_log
        More comments for its head.
    """
    fits = f"chi-squared {result.chi_squared:.4g} of"
    if result.scatter != 1.0:
        fits = f"deviations of {result.noise.value * result.scatter:.2g} by the scatter,"
    head = [
        f"# calibrated by gsp calibrate from {len(result.seen)} rows: {fits} {result.freedom} "
        "degrees of freedom",
        "# after # are the standard deviations of the numbers in the line, in their order",
    ]
    if result.unknowns.missing:
        head.append(
            f"# {result.unknowns.missing} directions that the data do not determine are as stated:"
        )
        head += [f"#   {sentence}" for sentence in result.unknowns.sentences]
    head += [f"# {remark}" for remark in remarks_of_log]
    remarks = _remarks(result)
    lines, section = [], ""
    for line in dumps(result.instance).splitlines():
        if not line.startswith(" "):
            section = line.partition(":")[0]
            lines.append(line)
        else:
            remark = next(remarks) if section in ("platform", "base", "constraints") else ""
            lines.append(f"{line}  # {remark}" if remark else line)
    return "\n".join([*head, *lines]) + "\n"


def _remarks(result: Calibration) -> Iterator[str]:
    """Yield what stands beside each primitive and constraint, in the order of the file."""
    for body in ("platform", "base"):
        names = [
            getattr(row, f"{body}_name") or f"of {k}"
            for k, row in enumerate(result.stated.constraints, 1)
        ]
        for name in dict.fromkeys(names):
            begin = f"{body}.{name}."
            found = [s for one, s in result.deviations.items() if one.startswith(begin)]
            yield _deviations(found)
    for k in range(1, len(result.stated.constraints) + 1):
        parts = []
        for what in ("offset", "scale"):
            sigma = result.deviations.get(f"{what}.{k}")
            if sigma is not None:
                parts.append(f"{what} {_deviations([sigma])}")
        yield ", ".join(parts)


def _deviations(sigmas: list[float]) -> str:
    if not sigmas:
        return ""
    if not any(sigmas):
        return "as stated"
    return "± " + ", ".join(f"{sigma:.2g}" for sigma in sigmas)
