"""The file beside a program whose version git has: git hands over the program alone.

A file beside knows its program by its hash, so any version of it that is about a program is the right one.
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

from chipbreak.editing.beside import SUFFIX, fits
from chipbreak.text.bounds import read_bounded
from chipbreak.text.existence import is_file
from chipbreak.text.named_tuple import NamedTuple

_MOST_VERSIONS = 100
_MOST_BYTES = 1 << 28
# Older versions of git put this before the name of a file that they hand to a converter.
_MARK = re.compile(r"^[A-Za-z0-9]{6}_")


class Beside(NamedTuple):
    """The file beside a program; ``content`` is None where no version of ``name`` is about it.

    ``name`` is empty where there is no such file, nor was one.
    """

    content: bytes | None = None
    name: str = ""


def beside_of_path(path: str, data: bytes) -> Beside:
    """The file beside for ``data``, a version of the file at ``path`` from the root of the work tree."""
    name = path + SUFFIX
    is_known = is_file(name) or _git("ls-files", "--", name) or _git("ls-tree", "HEAD", "--", name)
    if not is_known:
        return Beside()
    return next(_fitting(path, data), Beside(None, name))


def beside_of_copy(file: str, data: bytes) -> Beside:
    """The same where only the last name of the path is known: git hands a copy to a converter."""
    base = Path(file).name
    names = {base, _MARK.sub("", base)}
    listed = _git("ls-files", "-z", "--", *(f":(glob)**/{_literal(name + SUFFIX)}" for name in sorted(names)))
    paths = [one.removesuffix(SUFFIX) for one in listed.decode("utf-8", "surrogateescape").split("\0") if one]
    own = _in_the_work_tree(file + SUFFIX)
    if own and fits(data, file, own):
        return Beside(own, base + SUFFIX)
    found = (beside for path in paths for beside in _fitting(path, data))
    return next(found, Beside())


def _literal(name: str) -> str:
    return re.sub(r"([\\*?\[\]])", r"\\\1", name)


def _fitting(path: str, data: bytes) -> Iterator[Beside]:
    """Versions that are about a program."""
    name = path + SUFFIX
    for content in _versions(name):
        if content and fits(data, path, content):
            yield Beside(content, name)


def _versions(name: str) -> Iterator[bytes]:
    """A file as it is in the work tree, as it is staged, and as it was, the newest first."""
    yield _in_the_work_tree(name)
    yield _git("cat-file", "blob", f":{name}")
    # A commit of any branch may be compared.
    log = _git("log", "--all", "--full-history", "--format=%H", f"-n{_MOST_VERSIONS}", "--", name)
    for commit in log.decode("ascii").split():
        yield _git("cat-file", "blob", f"{commit}:{name}")


def _in_the_work_tree(name: str) -> bytes:
    """The bytes of a file; none where it cannot be read."""
    try:
        return read_bounded(Path(name), _MOST_BYTES)
    except (OSError, ValueError):
        return b""


def _git(*arguments: str) -> bytes:
    """What git prints; nothing where it fails, is not there, or this is no repository."""
    literal = () if any(one.startswith(":(") for one in arguments) else ("--literal-pathspecs",)
    try:
        command = ["git", "--no-pager", *literal, *arguments]
        return subprocess.run(command, capture_output=True, check=True).stdout
    except (OSError, ValueError, subprocess.CalledProcessError):
        return b""
