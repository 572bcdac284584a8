"""The page docs/diagnostics.md, from docs/diagnostics.toml and the programs of tests/bad.

``python benchmarks/diagnostics_page.py`` writes the page anew.  The file has one entry a code: what it means,
how much it weighs, and the way out.  Where a program of tests/bad is refused with the code, the shortest of
them is filtered, and program and message stand on the page as they are.
"""

from __future__ import annotations

import re
import shlex
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import chipbreak

CHECKOUT = Path(__file__).parents[1]
TEXTS = CHECKOUT / "docs" / "diagnostics.toml"
PAGE = CHECKOUT / "docs" / "diagnostics.md"
BAD = CHECKOUT / "tests" / "bad"
_EXPECT = re.compile(r"\(EXPECT ([A-Z]{3}[0-9]{3}) [0-9]+:[0-9]+ ?([^()]*)\)\s")
_HEAD = """\
# Diagnostics

<!-- made by make diagnostics from docs/diagnostics.toml and tests/bad -->

`file:line:column: error VIB003: message`, the line with a caret, and the way out. A code never changes its
meaning. An error means that nothing is written; a warning is passed on and the program is written; a note
says what is good to know. `--json` gives code, severity, span, message, help, and `instead`: texts that may
stand in the place of the span, where a way out is words to write.

Every code is in one of the tables, and has its own paragraph below: the way out, and where a program can show
it, one with what is said of it. The message at the machine names the numbers of its own program.
"""


class Text(NamedTuple):
    """What the file says of a code.

    ``way_out`` may be empty where a program of tests/bad has one; ``example`` is an :class:`Example` where
    none of them can show the code.
    """

    severity: str
    meaning: str
    way_out: str = ""
    example: dict[str, Any] | None = None


class Section(NamedTuple):
    """Codes that belong together, and what is true of all of them."""

    title: str
    about: str
    codes: dict[str, Text]


class Example(NamedTuple):
    """A program of which something is said, and the options it is read with."""

    name: str
    text: str
    profile: str
    sets: tuple[str, ...]

    @property
    def options(self) -> str:
        """The options as they are typed."""
        return " ".join((f"-p {self.profile}", *(f"--set {shlex.quote(one)}" for one in self.sets)))

    def said(self, code: str) -> str:
        """The message with this code.  ValueError where it is not said."""
        for found in _said_of(self):
            if found.code == code:
                return found.render()
        message = f"{code} is not said of {self.name}"
        raise ValueError(message)


@cache
def _said_of(example: Example) -> tuple[chipbreak.Diagnostic, ...]:
    at = CHECKOUT / example.profile
    settings = chipbreak.load(at if at.is_file() else example.profile, example.sets)
    return chipbreak.check(example.text.encode(), settings, example.name)


def sections() -> list[Section]:
    """The entries of the file, in its order."""
    read = tomllib.loads(TEXTS.read_text("utf-8"))
    return [
        Section(
            one["title"], one.get("about", ""), {code: Text(**said) for code, said in one["codes"].items()}
        )
        for one in read["section"]
    ]


def examples() -> dict[str, Example]:
    """For each code its own example, or the shortest of the refused programs that can be printed."""
    found = {
        code: Example("part.nc", one["program"], one["profile"], tuple(one.get("sets", ())))
        for section in sections()
        for code, text in section.codes.items()
        if (one := text.example) is not None
    }
    for file in sorted(BAD.glob("*.nc"), key=lambda file: (file.stat().st_size, file.name)):
        code, example = _example(file)
        if all(letter == "\n" or letter.isprintable() for letter in example.text) and example.text.isascii():
            found.setdefault(code, example)
    return found


def _example(file: Path) -> tuple[str, Example]:
    text = file.read_bytes().decode("latin-1").replace("\r\n", "\n")
    match = _EXPECT.match(text)
    if match is None:
        message = f"{file.name} does not say what is expected"
        raise ValueError(message)
    flags = match[2].split()
    profile = "generic-lathe"
    if flags[:1] == ["-p"]:
        profile = flags[1]
        flags = flags[2:]
    return match[1], Example(file.name, text[match.end() :], profile, tuple(flags))


def page() -> str:
    """The whole page."""
    shown = examples()
    return "\n".join([_HEAD, *(line for section in sections() for line in _section(section, shown))])


def _section(section: Section, shown: dict[str, Example]) -> Iterator[str]:
    yield f"## {section.title}\n"
    if section.about:
        yield f"{section.about}\n"
    yield "| code | | meaning |\n| --- | --- | --- |"
    for code, text in section.codes.items():
        yield f"| [{code}](#{code.lower()}) | {text.severity} | {text.meaning} |"
    yield ""
    for code, text in section.codes.items():
        yield from _paragraph(code, text, shown.get(code))


def _paragraph(code: str, text: Text, example: Example | None) -> Iterator[str]:
    yield f"### {code}\n"
    yield f"*{text.severity}*: {text.meaning}\n"
    if text.way_out:
        yield f"Way out: {text.way_out}.\n"
    if example is not None:
        yield f"```nc\n{example.text.rstrip()}\n```\n"
        yield f"with `{example.options}`:\n"
        yield f"```text\n{example.said(code)}\n```\n"


if __name__ == "__main__":
    PAGE.write_text(page(), "utf-8")
