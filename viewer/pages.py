"""Rebuild the pages of `gsp view` in data/view/ from viewer/.

    python -m viewer.pages [--check]

The npm client installs exactly the packages of viewer/package-lock.json. esbuild, in its build for
all systems, bundles three.js and the sources into one script; scripts and style sheets are put into
the pages. What remains to be filled in, marked ``@@name@@``, is up to `gspcli.pictures.page` and
`gspcli.pictures.live_numbers`.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from tools.recording import ROOT, UNABLE, parser, save, sha256

HERE = ROOT / "viewer"
SOURCES = HERE / "src"
TARGET = ROOT / "data" / "view"
LIBRARY = HERE / "node_modules" / "three"
COMMAND = "python -m viewer.pages"
BUNDLE = ["--bundle", "--minify", "--target=es2022", "--legal-comments=none"]


class Part(NamedTuple):
    """A script of a page: where it begins, and how it is wrapped."""

    entry: str
    form: str = "iife"


class Page(NamedTuple):
    """What a page is made of, by the marks in its template."""

    template: str
    styles: tuple[str, ...]
    scripts: dict[str, Part]


PAGES = {
    "page.html": Page("page.html", ("style.css",), {"script": Part("main.js")}),
    "live.html": Page(
        "live.html",
        ("style.css", "live.css"),
        {"script": Part("live/main.js", "esm"), "worker": Part("live/worker.js")},
    ),
}


def install() -> None:
    """Install what the lock file names."""
    subprocess.run(["npm", "ci", "--ignore-scripts", "--silent"], cwd=HERE, check=True)


def bundle(part: Part) -> str:
    """Return a script with all that it imports in it."""
    esbuild = str(HERE / "node_modules" / "esbuild-wasm" / "bin" / "esbuild")
    source, form = str(SOURCES / part.entry), f"--format={part.form}"
    run = subprocess.run(
        ["node", esbuild, source, *BUNDLE, form, "--log-level=warning"],
        check=True,
        capture_output=True,
        text=True,
    )
    return run.stdout.strip()


def page(made: Page, licence: str) -> str:
    """Return a page with scripts, style sheets and licence in it."""
    parts = {name: bundle(part) for name, part in made.scripts.items()}
    # The licence of three.js asks to be in every copy.
    parts["script"] = f"/*!\nthree.js\n\n{licence.strip()}\n*/\n{parts['script']}"
    parts["style"] = "\n".join(
        (SOURCES / name).read_text(encoding="utf-8").strip() for name in made.styles
    )
    text = (SOURCES / made.template).read_text(encoding="utf-8")
    for name, part in parts.items():
        assert "@@" not in part, f"the {name} contains @@"
        assert "</script" not in part, f"the {name} would end itself"
        text = text.replace(f"@@{name}@@", part)
    return text


def manifest(pages: Mapping[str, str]) -> str:
    """Return what the pages were made of."""
    lock = json.loads((HERE / "package-lock.json").read_text(encoding="utf-8"))
    names = ("three", "esbuild-wasm")
    packages = {name: lock["packages"][f"node_modules/{name}"]["version"] for name in names}
    record = {
        "manifest": {"command": COMMAND, "packages": packages},
        "pages": {
            name: {"bytes": len(text.encode()), "sha256": sha256(text)}
            for name, text in pages.items()
        },
    }
    return json.dumps(record, indent=1) + "\n"


def main() -> int:
    """Write or compare the pages; return the exit code."""
    arguments = parser(__doc__).parse_args()
    if shutil.which("npm") is None:
        print("the pages of gsp view cannot be built without npm")
        return UNABLE
    try:
        install()
        licence = (LIBRARY / "LICENSE").read_text(encoding="utf-8")
        pages = {name: page(made, licence) for name, made in PAGES.items()}
    except subprocess.CalledProcessError as error:
        print(f"the pages of gsp view cannot be built: {error}\n{error.stderr or ''}")
        return UNABLE
    files: dict[Path, str | bytes] = {
        **{TARGET / name: text for name, text in pages.items()},
        TARGET / "LICENSE.three.txt": licence,
        TARGET / "manifest.json": manifest(pages),
    }
    return save(files, check=arguments.check, confirmed="the pages of gsp view")


if __name__ == "__main__":
    sys.exit(main())
