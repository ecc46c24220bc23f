"""The documentation holds together: links lead somewhere, nothing is orphaned."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable
from pathlib import Path

import jsonschema
import pytest

from gspcli.resources import instance_files

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "docs" / "_ext"))
import made_pages  # noqa: E402 - beside the pages

#: The pages that programs write when the site is built.
MADE = {ROOT / "docs" / name: text for name, text in made_pages.pages().items()}
#: The first page of the site is the README itself.
INDEX = ROOT / "docs" / "index.md"
PAGES = [ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")]
PAGES += [page for page in sorted((ROOT / "docs").glob("*.md")) if page not in {INDEX, *MADE}]
LINK = re.compile(r"\]\(([^)#\s]+)(#[^)]*)?\)")


def _text(page: Path) -> str:
    return MADE.get(page) or page.read_text(encoding="utf-8")


def _targets(page: Path) -> list[str]:
    found = (match[1] for match in LINK.finditer(_text(page)))
    # The badge of continuous integration is beside the files of a repository at its service.
    return [target for target in found if not target.startswith(("http", "../../actions/"))]


@pytest.mark.parametrize(
    "page", [*PAGES, *(p for p in MADE if p.suffix == ".md")], ids=lambda page: page.name
)
def test_links_lead_to_files(page: Path) -> None:
    missing = [t for t in _targets(page) if not _exists(page.parent / t)]
    assert not missing


def _exists(file: Path) -> bool:
    return file.resolve() in MADE or file.exists()


def _anchors(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as GitHub and the site make them."""
    text = re.sub(r"^```.*?^```$", "", _text(page), flags=re.M | re.S)
    titles = (title.lower() for title in re.findall(r"^#+ (.+)$", text, re.MULTILINE))
    return {re.sub(r"[^\w\- ]", "", title).strip().replace(" ", "-") for title in titles}


@pytest.mark.parametrize(
    "page", [*PAGES, *(p for p in MADE if p.suffix == ".md")], ids=lambda page: page.name
)
def test_links_lead_to_headings(page: Path) -> None:
    found = LINK.finditer(_text(page))
    inside = [(m[1], m[2][1:]) for m in found if m[2] and m[1].endswith(".md") and ":" not in m[1]]
    assert not [(to, at) for to, at in inside if at not in _anchors((page.parent / to).resolve())]


def test_every_page_is_reached_from_the_readme() -> None:
    seen: set[Path] = set()
    waiting = [ROOT / "README.md"]
    while waiting:
        page = waiting.pop()
        if page not in seen and page.suffix == ".md":
            seen.add(page)
            waiting += [(page.parent / target).resolve() for target in _targets(page)]
    assert {page for page in PAGES if page.parent.name == "docs"} <= seen


def test_make_targets_named_in_the_readme_exist() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in re.findall(r"make ([a-z-]+)", (ROOT / "README.md").read_text(encoding="utf-8")):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target


def test_every_page_is_in_the_contents_of_the_site() -> None:
    listed = re.findall(r"^([a-z-]+)$", INDEX.read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(listed) == sorted(
        page.stem for page in (*PAGES, *MADE) if page.parent.name == "docs"
    )


def test_the_gallery_has_every_instance_file(load_tool: Callable) -> None:
    gallery = load_tool("build.site_gallery")
    shown = re.findall(r'<a href="views/(.+)\.html"><img src="views/\1\.svg"', gallery.grid())
    assert sorted(shown) == sorted(instance_files())


def test_the_made_pages_have_every_command_option_and_key() -> None:
    pages = made_pages.pages()
    for name, command in made_pages.leaves():
        assert f"## gsp {name}\n" in pages["commands.md"]
        assert all(
            option.opts[-1] in pages["options.md"]
            for option in command.params[1:]
            if option.opts[0][0] == "-"
        )
    assert "| `poses[].t` | " in pages["output.md"]
    for name, text in pages.items():
        if name.endswith(".json"):
            jsonschema.Draft202012Validator.check_schema(json.loads(text))


@pytest.mark.parametrize(
    "words",
    [
        "bound 6PP",
        "check @dietmaier",
        "solve @six-planes --all",
        "measure @rubin-m2 --pose 0,0,0,1,0,0,0",
    ],
)
def test_output_has_the_form_that_the_schema_says(words: str, gsp: Callable) -> None:
    document = json.loads(gsp(*words.split(), "--format", "json").out)
    form = document["schema"].removeprefix("gsp.").partition("/")[0]
    jsonschema.validate(document, json.loads(made_pages.pages()[f"static/made/{form}.schema.json"]))
