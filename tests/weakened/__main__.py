"""Weaken one inequality of a proof after the other: a test of the suite must notice each.

    python -m tests.weakened [NAME ...] [--jobs 2] [--sample N]

``tests/weakened/*.toml`` lists the mutants: a file, a text that occurs once in it, what
replaces it, what the inequality proves, and the tests that fail then. All files of the project
are copied; each mutant is written there alone, a mutant in C++ is compiled, and its tests are run.
It is killed if they fail. Without NAME all mutants are tried. Only the object files that depend on
the changed file are compiled again, and of the instruction sets only the one that this processor
uses.

What is found is kept in ``build/mutants``, by the contents of the changed file and of the tests: an
interrupted run continues where it stopped.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from pathlib import Path

from gspcli import _kernel
from tools.recording import ROOT, add_sample, report, sampled, sha256

LIST = Path(__file__).parent
WORK = ROOT / "build" / "mutants"
#: Where the kernel is compiled, in a copy of the project.
_KERNEL = Path("build", "mutants", "kernel")
_NATIVE = (".c", ".cpp", ".hpp")
#: What pytest returns when tests have failed; it returns more when it could not run them.
_PASSED, _FAILED = 0, 1
_NOT_TRIED = "not tried"
#: The installed package is found by an import hook: without it the copy is.
_SITE = """\
import sys

for one in [one for one in sys.meta_path if type(one).__name__ == "ScikitBuildRedirectingFinder"]:
    sys.meta_path.remove(one)
"""


@dataclass(frozen=True)
class Mutant:
    """A weakened inequality.

    Attributes
    ----------
    name
        Its name.
    file
        The file, from the folder of the project.
    old, new
        A text that occurs once in the file, and what replaces it.
    proves
        What the inequality is good for.
    tests
        Tests of which one fails then, as pytest names them.
    """

    name: str
    file: str
    old: str
    new: str
    proves: str
    tests: tuple[str, ...]

    @property
    def is_native(self) -> bool:
        """Whether the kernel is to be compiled again."""
        return self.file.endswith(_NATIVE) and not self.file.startswith("viewer/")


def mutants() -> list[Mutant]:
    """Return the list, in the order of its files."""
    texts = (path.read_text(encoding="utf-8") for path in sorted(LIST.glob("*.toml")))
    entries = chain.from_iterable(tomllib.loads(text)["mutant"] for text in texts)
    return [Mutant(**{**entry, "tests": tuple(entry["tests"])}) for entry in entries]


def problems(listed: Sequence[Mutant], root: Path = ROOT) -> Iterator[str]:
    """Yield what is wrong with the list: texts that are not in their file, tests that are none."""
    names = [one.name for one in listed]
    yield from (
        f"{name}: the name occurs twice"
        for name in sorted({n for n in names if names.count(n) > 1})
    )
    for one in listed:
        path = root / one.file
        count = path.read_text(encoding="utf-8").count(one.old) if path.is_file() else 0
        if count != 1:
            yield f"{one.name}: the text occurs {count} times in {one.file}, expected once"
        if one.old == one.new or not one.proves or not one.tests:
            yield f"{one.name}: found no change, no reason or no test"
        yield from (
            f"{one.name}: no such test: {test}" for test in one.tests if not _is_test(test, root)
        )


def _is_test(test: str, root: Path) -> bool:
    file, _, function = test.partition("::")
    path = root / file
    name = re.escape(function.partition("[")[0])
    return path.is_file() and bool(
        re.search(rf"^def {name}\(", path.read_text(encoding="utf-8"), re.MULTILINE)
    )


class Copy:
    """A copy of the project, in which one file at a time is changed."""

    def __init__(self, folder: Path, number: int = 0) -> None:
        suffix = f"-{number}" if number else ""
        self.root, self._site = folder / f"project{suffix}", folder / f"site{suffix}"
        self._site.mkdir(parents=True, exist_ok=True)
        (self._site / "sitecustomize.py").write_text(_SITE, encoding="utf-8")
        listed = subprocess.run(
            ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
            cwd=ROOT,
            check=True,
            capture_output=True,
            text=True,
        )
        for name in filter(None, listed.stdout.split("\0")):
            source, target = ROOT / name, self.root / name
            if source.is_file() and not _is_same(source, target):
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(source, target)
        self._kernel = Path(_kernel.__file__)
        shutil.copy(self._kernel, self.root / "gspcli")

    @cached_property
    def objects(self) -> Objects:
        """The object files of the kernel."""
        return Objects(self.root)

    @contextmanager
    def changed(self, mutant: Mutant) -> Iterator[bool]:
        """Change a file, and the kernel with it; give whether that can be compiled."""
        path = self.root / mutant.file
        objects = self.objects if mutant.is_native else None
        before = path.read_text(encoding="utf-8")
        path.write_text(before.replace(mutant.old, mutant.new), encoding="utf-8")
        try:
            if objects is None:
                yield True
            else:
                with objects.compiled_again(path) as library:
                    if library:
                        shutil.copy(library, self.root / "gspcli" / self._kernel.name)
                    yield library is not None
        finally:
            path.write_text(before, encoding="utf-8")
            if objects is not None:
                shutil.copy(self._kernel, self.root / "gspcli")

    def test(self, tests: Sequence[str], *options: str) -> tuple[int, str]:
        """Return what pytest returns and prints."""
        paths = [self._site, self.root]
        environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join(map(str, paths)),
            "PYTHONDONTWRITEBYTECODE": "1",
            # Half of the time of a short test is that of plugins.
            "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
        }
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
        done = subprocess.run(
            [*command, *options, *tests],
            cwd=self.root,
            env=environment,
            check=False,
            capture_output=True,
            text=True,
        )
        return done.returncode, done.stdout


def _is_same(source: Path, target: Path) -> bool:
    return target.is_file() and source.read_bytes() == target.read_bytes()


class Objects:
    """The object files of the kernel of a copy of the project.

    Parameters
    ----------
    root
        The copy.
    """

    def __init__(self, root: Path) -> None:
        self._folder = root / _KERNEL
        # Without a build type nothing is optimized when it is linked, which takes as long again.
        options = ["-DCMAKE_BUILD_TYPE=None", "-DCMAKE_CXX_FLAGS=-O3 -DNDEBUG"]
        options += ["-DCMAKE_EXPORT_COMPILE_COMMANDS=ON"]
        options += [f"-DPython_EXECUTABLE={sys.executable}"]
        command = ["cmake", "-G", "Ninja", *options, "-S", str(root), "-B", str(self._folder)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        subprocess.run(["ninja"], cwd=self._folder, check=True, stdout=subprocess.DEVNULL)
        commands = json.loads((self._folder / "compile_commands.json").read_text(encoding="utf-8"))
        self._commands = {_output(one["command"]): one["command"] for one in commands}
        [self._library] = self._folder.glob(f"{_kernel.__name__.rpartition('.')[2]}*.so")
        link = ["ninja", "-t", "commands", "-s", self._library.name]
        self._link = self._printed(link).strip()

    def _printed(self, command: Sequence[str]) -> str:
        return subprocess.run(
            command, cwd=self._folder, check=True, capture_output=True, text=True
        ).stdout

    def _depending_on(self, path: Path) -> list[str]:
        """Return the object files that are made of a file, without those of other processors."""
        found, name = [], ""
        for line in self._printed(["ninja", "-t", "deps"]).splitlines():
            if line and not line[0].isspace():
                name = line.partition(":")[0]
            elif line.strip() and (self._folder / line.strip()).resolve() == path.resolve():
                found.append(name)
        others = {"portable", "avx2", "avx512"} - {_kernel.build()}
        return [name for name in found if not others & set(re.split(r"[_.]", name.split("/")[1]))]

    @contextmanager
    def compiled_again(self, path: Path) -> Iterator[Path | None]:
        """Compile what is made of a file; give the library, or None if that cannot be done."""
        chosen = self._depending_on(path)
        assert chosen, path
        kept = {name: (self._folder / name).read_bytes() for name in chosen}
        try:
            good = all(self._runs(self._commands[name]) for name in chosen) and self._runs(
                self._link
            )
            yield self._library if good else None
        finally:
            for name, content in kept.items():
                (self._folder / name).write_bytes(content)

    def _runs(self, command: str) -> bool:
        words = ["sh", "-c", command]
        return not subprocess.run(
            words, cwd=self._folder, check=False, capture_output=True
        ).returncode


def _output(command: str) -> str:
    words = shlex.split(command)
    return words[words.index("-o") + 1]


def tried(copy: Copy, mutant: Mutant) -> str:
    """Return the result of a mutant: ``killed``, ``survives`` or why it could not be tried."""
    with copy.changed(mutant) as compiled:
        if not compiled:
            return "not compiled"
        code, printed = copy.test(mutant.tests, "-x")
    if code not in (_PASSED, _FAILED):
        print(printed, file=sys.stderr)
        return "not tested"
    return "survives" if code == _PASSED else "killed"


class Results:
    """The results of mutants, kept in a file.

    Parameters
    ----------
    path
        The file: a line of JSON for each.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        lines = path.read_text(encoding="utf-8").splitlines() if path.is_file() else []
        self._known = dict(json.loads(line) for line in lines)

    def of(self, mutant: Mutant) -> str | None:
        """Return the result of a mutant of these files; None if it was not tried."""
        return self._known.get(_key(mutant))

    def add(self, mutant: Mutant, result: str) -> None:
        """Keep the result of a mutant."""
        self._known[_key(mutant)] = result
        with self._path.open("a", encoding="utf-8") as file:
            file.write(json.dumps([_key(mutant), result]) + "\n")


def _key(mutant: Mutant) -> str:
    files = sorted({mutant.file, *(test.partition("::")[0] for test in mutant.tests)})
    texts = [(ROOT / file).read_text(encoding="utf-8") for file in files]
    return sha256(json.dumps([mutant.old, mutant.new, *mutant.tests, *texts]))


def try_all(chosen: Sequence[Mutant], folder: Path, jobs: int) -> dict[str, str]:
    """Return the results of mutants, by their names; those of C++ are all tried in one copy."""
    results = Results(folder / "results.jsonl")
    left = [one for one in chosen if results.of(one) is None]
    copies = [Copy(folder, number) for number in range(jobs if left else 0)]
    queues: list[list[Mutant]] = [[one for one in left if one.is_native], *([] for _ in copies[1:])]
    for number, one in enumerate(one for one in left if not one.is_native):
        queues[number % len(copies[1:]) + 1 if copies[1:] else 0].append(one)

    def work(copy: Copy, queue: Sequence[Mutant]) -> None:
        # Without any change the tests pass.
        code, printed = copy.test(sorted({test for one in queue for test in one.tests}), "-x")
        if code != _PASSED and queue:
            print(printed, file=sys.stderr)
            return
        for one in queue:
            results.add(one, tried(copy, one))
            print(f"{results.of(one):10}  {one.name}", file=sys.stderr, flush=True)

    with ThreadPoolExecutor(max(len(copies), 1)) as threads:
        list(threads.map(work, copies, queues))
    return {one.name: results.of(one) or _NOT_TRIED for one in chosen}


def main() -> int:
    """Try the mutants; return the exit code."""
    arguments = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add_sample(arguments)
    arguments.add_argument("names", nargs="*", metavar="NAME", help="only these mutants")
    arguments.add_argument(
        "--jobs", type=int, default=1, metavar="N", help="copies at work at once"
    )
    options = arguments.parse_args()
    listed = mutants()
    unknown = sorted(set(options.names) - {one.name for one in listed})
    wrong = [*problems(listed), *(f"no such mutant: {name}" for name in unknown)]
    if wrong:
        return report(wrong, "")
    chosen = [one for one in listed if not options.names or one.name in options.names]
    if options.sample is not None:
        # Without a compiler.
        chosen = sampled([one for one in chosen if not one.is_native], options.sample)
    WORK.mkdir(parents=True, exist_ok=True)
    ends = try_all(chosen, WORK, options.jobs)
    left = [f"{name}: {end}" for name, end in ends.items() if end != "killed"]
    return report(left, f"{len(chosen)} mutants killed")


if __name__ == "__main__":
    sys.exit(main())
