"""The pages hold together: links lead somewhere, every page is reached, every command shown is one."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import click
import pytest

from chipbreak.cli import cli
from chipbreak.settings.schema import schema_of_profiles

CHECKOUT = Path(__file__).parents[1]
DOCS = CHECKOUT / "docs"
PAGES = sorted([*DOCS.glob("*.md"), *CHECKOUT.glob("*.md"), CHECKOUT / "samples" / "README.md"])
_LINK = re.compile(r"(?<!!)\[[^\]]+\]\(([^)\s]+)\)")
_FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
# Parts of the program and of its samples that are written like keys.
_NO_KEYS = {"passes.base", "planner.trace", "tools.magazine"}
_COMMAND = re.compile(r"^ {4}(?:\$ )?(chipbreak [^\n]*)$", re.MULTILINE)


def anchors(page: Path) -> set[str]:
    """The names of the headings of a page, as they are linked to."""
    text = _FENCE.sub("", page.read_text("utf-8"))
    titles = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_leads_somewhere(page: Path) -> None:
    for target in _LINK.findall(_FENCE.sub("", page.read_text("utf-8"))):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        assert file.exists(), f"{page.name}: {target}"
        assert not anchor or anchor in anchors(file), f"{page.name}: {target}"


def test_every_page_is_reached_from_the_index_and_the_site() -> None:
    linked = set(_LINK.findall((DOCS / "index.md").read_text("utf-8")))
    listed = re.findall(r"^ *- ([\w-]+\.md)$", (CHECKOUT / "mkdocs.yml").read_text("utf-8"), re.MULTILINE)
    names = {page.name for page in DOCS.glob("*.md")}
    assert set(listed) == names
    assert len(listed) == len(set(listed))
    assert names - {"index.md"} <= linked


def keys_of_profiles() -> set[str]:
    """Every key as it is written with its sections; an axis is X."""
    found = set()
    sections = schema_of_profiles()["properties"]
    for name, section in sections.items():
        for key, value in section.get("properties", {}).items():
            found |= {f"{name}.{key}", *(f"{name}.{key}.{inner}" for inner in value.get("properties", {}))}
    return found


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_key_of_a_profile_that_a_page_names_is_one(page: Path) -> None:
    known = keys_of_profiles()
    sections = sorted({key.partition(".")[0] for key in known})
    named = re.findall(
        rf"(?<![\w./-])((?:{'|'.join(sections)})\.(?!(?:md|c)\b)[\w.]*\w)", page.read_text("utf-8")
    )
    # An axis is any, and a tool of a table by tool numbers as well.
    plain = {key: re.sub(r"\.\d+$", "", re.sub(r"^axes\.[A-Z]\b", "axes.X", key)) for key in named}
    wrong = {key for key, one in plain.items() if one not in known | _NO_KEYS}
    assert not wrong


def commands() -> list[tuple[str, str]]:
    return [(page.name, line) for page in PAGES for line in _COMMAND.findall(page.read_text("utf-8"))]


def test_there_are_commands_in_the_pages() -> None:
    assert len(commands()) > 20


@pytest.mark.parametrize(("page", "line"), commands())
def test_a_command_of_a_page_is_one(page: str, line: str) -> None:
    """Its name and its options are known; what it names need not be there."""
    words = shlex.split(re.split(r"  #| \| | > |\\$", line)[0], comments=True)[1:]
    group: click.Command = cli
    context = click.Context(cli)
    while isinstance(group, click.Group) and words and not words[0].startswith("-"):
        name = words.pop(0)
        found = group.get_command(context, name)
        assert found is not None, f"{page}: {line}"
        group = found
    known = {flag for option in group.get_params(context) for flag in (*option.opts, *option.secondary_opts)}
    given = [word.partition("=")[0] for word in words if re.match(r"--?[a-z]", word)]
    assert set(given) <= known | {"--help", "-h", "--version"}, f"{page}: {line}"
