"""The pages as a site: no link of it is broken, to a page, a place in one, a figure or a file."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from importlib.util import find_spec
from pathlib import Path
from urllib.parse import unquote, urldefrag, urlsplit

import pytest

CHECKOUT = Path(__file__).parents[1]
sys.path.insert(0, str(CHECKOUT / "benchmarks"))

import site_hook  # noqa: E402

needs_mkdocs = pytest.mark.skipif(
    find_spec("mkdocs") is None or find_spec("material") is None, reason="mkdocs-material is not installed"
)


class Page(HTMLParser):
    """The links of a page, and the names to which others can lead."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.names: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in ("href", "src") and value is not None:
                self.links.append(value)
            elif name in ("id", "name") and value is not None:
                self.names.add(value)


def build(config: Path, site: Path) -> subprocess.CompletedProcess[str]:
    # --quiet would keep --strict from counting.
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "-f", config, "-d", site]
    quiet = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    return subprocess.run(command, capture_output=True, text=True, check=False, env=quiet)


def broken_links(site: Path) -> Iterator[str]:
    """Links of a site that lead nowhere, as ``page: link``.  Those to other sites are not looked at."""
    pages = {file: Page(file.read_text("utf-8")) for file in site.rglob("*.html")}
    for file, page in pages.items():
        inside = [link for link in page.links if not urlsplit(link).scheme and not link.startswith("//")]
        for link in inside:
            if not leads_somewhere(link, file, site, pages):
                yield f"{file.relative_to(site)}: {link}"


def leads_somewhere(link: str, file: Path, site: Path, pages: dict[Path, Page]) -> bool:
    """True for a file of the site, and where the link says a name in it, for one that is there."""
    path, name = urldefrag(link)
    # 404.html is shown anywhere, so its links begin at the root.
    start = site if path.startswith("/") else file.parent
    target = (start / unquote(urlsplit(path).path).lstrip("/")).resolve() if path else file
    target = target / "index.html" if target.is_dir() else target
    if not target.is_relative_to(site) or not target.is_file():
        return False
    return not name or target not in pages or unquote(name) in pages[target].names


@needs_mkdocs
def test_no_link_of_the_site_is_broken(tmp_path: Path) -> None:
    built = build(CHECKOUT / "mkdocs.yml", tmp_path / "site")
    assert built.returncode == 0, built.stderr
    assert not list(broken_links(tmp_path / "site"))
    assert (tmp_path / "site" / "repository" / "samples" / "index.html").is_file()


@needs_mkdocs
@pytest.mark.parametrize(
    ("link", "is_broken"),
    [
        ("two.md#two", False),
        ("no-such-page.md", True),
        ("two.md#no-such-heading", True),
        ("../no-such-file.md", True),
        ("../src", True),
    ],
)
def test_a_broken_link_is_the_end_of_the_build(tmp_path: Path, link: str, is_broken: bool) -> None:
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "index.md").write_text(f"# One\n\n[a link]({link})\n")
    (tmp_path / "docs" / "two.md").write_text("# Two\n")
    settings = (CHECKOUT / "mkdocs.yml").read_text("utf-8").partition("\nnav:")[0]
    # The hook stays away: it would bring in what the pages of this repository link to.
    kept = [line for line in settings.splitlines() if not line.startswith("hooks:")]
    (tmp_path / "mkdocs.yml").write_text("\n".join(kept))
    built = build(tmp_path / "mkdocs.yml", tmp_path / "site")
    assert (built.returncode != 0) == is_broken, built.stderr
    assert (f"'{link}'" in built.stderr) == is_broken


def test_a_broken_link_of_a_site_is_found(tmp_path: Path) -> None:
    (tmp_path / "two").mkdir()
    (tmp_path / "index.html").write_text(
        '<a href="two/#here"></a><a href="two/#there"></a><img src="no.svg">'
    )
    (tmp_path / "two" / "index.html").write_text('<h2 id="here"></h2><a href="../index.html"></a>')
    assert sorted(broken_links(tmp_path)) == ["index.html: no.svg", "index.html: two/#there"]


def test_links_to_outside_are_written_for_their_place_in_the_site() -> None:
    docs = CHECKOUT / "docs"
    text = "[a](../samples/README.md#x) [b](checks.md) `[c](../README.md)` [d](../tests/plugin_package)"
    moved = (
        "[a](repository/samples/README.md#x) [b](checks.md) `[c](../README.md)`"
        " [d](repository/tests/plugin_package/README.md)"
    )
    assert site_hook.rewritten(text, docs / "index.md") == moved
    assert site_hook.rewritten("[a](docs/checks.md)", CHECKOUT / "README.md") == "[a](../checks.md)"
    linked = "[`x`](../grammar/README.md), [no](../no-such-file)"
    moved = "[`x`](repository/grammar/README.md), [no](../no-such-file)"
    assert site_hook.rewritten(linked, docs / "index.md") == moved


def test_what_is_linked_to_comes_with_what_it_links_to() -> None:
    names = {path.relative_to(CHECKOUT).as_posix() for path in site_hook.outside()}
    assert {"README.md", "samples/README.md", "samples/cookbook-lathe.toml", "grammar/iso.lark"} <= names
    assert not any(name.startswith("docs/") for name in names)
