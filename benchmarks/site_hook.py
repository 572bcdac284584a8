"""A hook of mkdocs: what the pages link to outside docs/ becomes part of the site, below ``repository/``.

In the repository a link such as ``../samples/README.md`` leads to the file itself.  The site has only docs/,
so that file is added to it, with all that it links to in turn, and the links are written for the place where
it then is.  A folder is its README.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from posixpath import relpath
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files
    from mkdocs.structure.pages import Page

CHECKOUT = Path(__file__).resolve().parents[1]
DOCS = CHECKOUT / "docs"
_FOLDER = "repository"
_README = "README.md"
_CODE = re.compile(r"^```.*?^```|^ {4}[^\n]*$|`[^`\n]*`(?!\])", re.MULTILINE | re.DOTALL)
_LINK = re.compile(r"\]\(([^)\s#]+)(#[^)\s]*)?\)")


def linked(page: Path) -> Iterator[Path]:
    """The files of the repository that a page links to, as paths that are there."""
    for match in _LINK.finditer(_CODE.sub("", page.read_text("utf-8"))):
        found = _target(page, match[1])
        if found is not None:
            yield found


def _target(page: Path, link: str) -> Path | None:
    """What a link leads to; None where it is no file of the repository."""
    if re.match(r"[a-z]+:", link):
        return None
    found = Path(os.path.normpath(page.parent / link))
    if found.is_dir():
        found /= _README
    return found if found.is_relative_to(CHECKOUT) and found.is_file() else None


def uri(path: Path) -> str:
    """Where a file of the repository is in the site, as the source of its page."""
    if path.is_relative_to(DOCS):
        return path.relative_to(DOCS).as_posix()
    return f"{_FOLDER}/{path.relative_to(CHECKOUT).as_posix()}"


def outside() -> list[Path]:
    """What the pages of docs/ lead to outside of it, and what that leads to in turn."""
    found: dict[Path, None] = {}
    waiting = sorted(DOCS.glob("*.md"))
    while waiting:
        for target in linked(waiting.pop(0)):
            if not target.is_relative_to(DOCS) and target not in found:
                found[target] = None
                waiting += [target] if target.suffix == ".md" else []
    return list(found)


def rewritten(text: str, page: Path) -> str:
    """A page with its links as they are in the site; code in it stays as it is."""
    at = 0
    parts = []
    for code in _CODE.finditer(text):
        parts += [_LINK.sub(_moved(page), text[at : code.start()]), code[0]]
        at = code.end()
    return "".join([*parts, _LINK.sub(_moved(page), text[at:])])


def _moved(page: Path) -> Callable[[re.Match[str]], str]:
    here = uri(page).rpartition("/")[0]

    def move(match: re.Match[str]) -> str:
        target = _target(page, match[1])
        if target is None:
            return match[0]
        return f"]({relpath(uri(target), here or '.')}{match[2] or ''})"

    return move


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """mkdocs asks which files there are: those outside docs/ come in."""
    from mkdocs.structure.files import File  # noqa: PLC0415 (the tests of this file need no mkdocs)

    for path in outside():
        files.append(File.generated(config, uri(path), abs_src_path=str(path)))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """mkdocs has read a page: its links are written for the site."""
    source = page.file.src_uri
    inside = source.removeprefix(f"{_FOLDER}/")
    path = (CHECKOUT if inside != source else DOCS) / inside
    return rewritten(markdown, path) if path.is_file() else markdown
