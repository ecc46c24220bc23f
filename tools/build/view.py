"""Rebuild the page of `gsp view` in data/view/ from tools/view/.

    python -m tools.build.view [--check]

The npm client installs exactly the packages of tools/view/package-lock.json, esbuild bundles
three.js and the sources into one script, and script and style sheet are put into the page. What
remains to be filled in, marked ``@@name@@``, is up to `gspcli.pictures.page`.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

from tools.recording import ROOT, UNABLE, parser, save, sha256

HERE = ROOT / "tools" / "view"
SOURCES = HERE / "src"
TARGET = ROOT / "data" / "view"
LIBRARY = HERE / "node_modules" / "three"
COMMAND = "python -m tools.build.view"
BUNDLE = ["--bundle", "--minify", "--format=iife", "--target=es2022", "--legal-comments=none"]


def bundle() -> str:
    """Return the script, three.js in it."""
    subprocess.run(["npm", "ci", "--ignore-scripts", "--silent"], cwd=HERE, check=True)
    esbuild = HERE / "node_modules" / ".bin" / "esbuild"
    run = subprocess.run(
        [esbuild, SOURCES / "main.js", *BUNDLE, "--log-level=warning"],
        check=True,
        capture_output=True,
        text=True,
    )
    return run.stdout.strip()


def page(script: str, licence: str) -> str:
    """Return the page with script, style sheet and licence in it."""
    # The licence of three.js asks to be in every copy.
    parts = {
        "script": f"/*!\nthree.js\n\n{licence.strip()}\n*/\n{script}",
        "style": (SOURCES / "style.css").read_text(encoding="utf-8").strip(),
    }
    text = (SOURCES / "page.html").read_text(encoding="utf-8")
    for name, part in parts.items():
        assert "@@" not in part, f"the {name} contains @@"
        assert "</script" not in part, f"the {name} would end itself"
        text = text.replace(f"@@{name}@@", part)
    return text


def manifest(text: str) -> str:
    """Return what the page was made of."""
    lock = json.loads((HERE / "package-lock.json").read_text(encoding="utf-8"))
    packages = {
        name: lock["packages"][f"node_modules/{name}"]["version"] for name in ("three", "esbuild")
    }
    record = {
        "manifest": {"command": COMMAND, "packages": packages},
        "page": {"bytes": len(text.encode()), "sha256": sha256(text)},
    }
    return json.dumps(record, indent=1) + "\n"


def main() -> int:
    """Write or compare the page; return the exit code."""
    arguments = parser(__doc__).parse_args()
    if shutil.which("npm") is None:
        print("the page of gsp view cannot be built without npm")
        return UNABLE
    licence = Path(LIBRARY / "LICENSE")
    try:
        script = bundle()
    except subprocess.CalledProcessError as error:
        print(f"the page of gsp view cannot be built: {error}")
        return UNABLE
    text = page(script, licence.read_text(encoding="utf-8"))
    files: dict[Path, str | bytes] = {
        TARGET / "page.html": text,
        TARGET / "LICENSE.three.txt": licence.read_text(encoding="utf-8"),
        TARGET / "manifest.json": manifest(text),
    }
    return save(files, check=arguments.check, confirmed="the page of gsp view")


if __name__ == "__main__":
    sys.exit(main())
