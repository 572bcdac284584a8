"""What the README and the pages show is what comes out."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import chipbreak
from chipbreak.options import Asked, settings_of
from chipbreak.settings.sections import SECTIONS

README = Path(__file__).parents[1] / "README.md"
DOCS = sorted((README.parent / "docs").glob("*.md"))
PROFILES = [
    pytest.param(block, id=f"{page.stem}-{number}")
    for page in DOCS
    for number, block in enumerate(re.findall(r"^```toml\n(.*?)^```", page.read_text("utf-8"), re.M | re.S))
]


def shown(*, behind: str) -> list[str]:
    """The lines of the first indented block behind a sentence, without their indent."""
    text = README.read_text("utf-8").partition(behind)[2]
    block = re.search(r"(?:^(?: {4}.*|)\n)+", text.lstrip("\n"), re.MULTILINE)
    assert block is not None
    return [line[4:] for line in block[0].strip("\n").split("\n")]


def test_the_example() -> None:
    lines = shown(behind="## One block, from byte to byte")
    commands = [i for i, line in enumerate(lines) if line.startswith("$ ")]
    assert [lines[i] for i in commands] == ["$ cat part.nc", "$ chipbreak filter -p generic-lathe part.nc"]
    program, wanted = lines[commands[0] + 1 : commands[1]], lines[commands[1] + 1 :]
    data = "".join(f"{line}\n" for line in program).encode()
    out = chipbreak.rewrite(data, chipbreak.load("generic-lathe")).data.decode().rstrip("\n").split("\n")
    gap = wanted.index("...")
    assert out[:gap] == wanted[:gap]
    assert out[gap - len(wanted) + 1 :] == wanted[gap + 1 :]


def test_the_explanation() -> None:
    wanted = [line.strip() for line in shown(behind="`chipbreak explain` shows all of it:")]
    program = b"G97 S3000 M3\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5\nM30\n"
    settings = chipbreak.load("generic-lathe")
    result = chipbreak.rewrite(program, settings, "part.nc")
    said = [line.strip() for line in chipbreak.explain(result, settings).lines()]
    assert said[said.index(wanted[0]) :][: len(wanted)] == wanted


@pytest.mark.parametrize("block", PROFILES)
def test_a_profile_shown_in_the_docs_is_one(block: str, tmp_path: Path) -> None:
    base = "fanuc-lathe" if "[axes." in block else "fanuc-mill"
    file = tmp_path / "shown.toml"
    file.write_text(block if block.startswith("base") else f'base = "{base}"\n{block}', "utf-8")
    settings_of(Asked(profile=str(file)), "-")


@pytest.mark.parametrize("section", SECTIONS)
def test_every_key_of_a_profile_stands_in_the_docs(section: str) -> None:
    pages = "".join(page.read_text("utf-8") for page in DOCS if page.stem in _WITH_KEYS)
    keys = SECTIONS[section].__dataclass_fields__
    assert [key for key in keys if not re.search(rf"`(?:\[checks\.)?{key}(?:\]?`| = )", pages)] == []


_WITH_KEYS = ("profiles", "checks", "macros")


PAGES = [README, README.with_name("CONTRIBUTING.md"), README.with_name("CHANGELOG.md"), *DOCS]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_a_page_leads_to_what_is_there(page: Path) -> None:
    links = re.findall(r"\]\(([^)\s]+)\)", page.read_text("utf-8"))
    own = [link.partition("#")[0] for link in links if not link.startswith("http")]
    assert [link for link in own if link and not (page.parent / link).exists()] == []


def test_every_page_is_in_the_index() -> None:
    index = README.parent / "docs" / "index.md"
    said = index.read_text("utf-8")
    assert [page.name for page in DOCS if page != index and f"({page.name})" not in said] == []


def test_what_contributing_names_is_there() -> None:
    said = README.with_name("CONTRIBUTING.md").read_text("utf-8")
    named = re.findall(r"`((?:src|tests|docs|grammar)/[\w/.-]*)`", said)
    assert named
    assert [name for name in named if not (README.parent / name).exists()] == []
    targets = set(re.findall(r"make ([a-z][a-z-]*)`", said))
    makefile = README.with_name("Makefile").read_text("utf-8")
    assert [name for name in targets if not re.search(rf"^{name}:", makefile, re.MULTILINE)] == []


def test_the_listing_of_the_house_is_in_the_order_of_the_rooms() -> None:
    page = (README.parent / "docs" / "architecture.md").read_text("utf-8")
    rooms = re.findall(r"^\| `(\w+)` \|", page, re.MULTILINE)
    listed = [word for line in shown(behind="and a test enforces it.") for word in line[:36].split()]
    assert listed
    assert listed == [room for room in rooms if room in listed]
