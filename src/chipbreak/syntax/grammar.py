"""Finds and loads the grammar of a dialect: the only module that imports lark.

A grammar is a file of ``grammar/``, or one that another package brings (then the dialect holds its path).
lark is imported on first use, because most programs have only plain blocks and never need it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from chipbreak.dialects import Dialect
from chipbreak.text.diagnostics import Diagnostic, ProgramRejectedError, Severity

if TYPE_CHECKING:
    from lark import Lark

UNUSABLE_GRAMMAR = "SYN002"
_TERMINAL = re.compile(r"^(?:%override +)?([A-Z_]+)(?:\.\d+)?\s*:\s*/(.*)/(i?)\s*$", re.MULTILINE)
_IMPORT = re.compile(r"^%import +\.(\w+)", re.MULTILINE)
_NAME = re.compile(r"[A-Z_]+")
_REMARK = re.compile(r"//.*")
_OPTIONAL = ("COMMENT", "DELETE", "SEPARATOR")
_NEEDED = ("LETTER", "NUMBER", "BLANK")
_BYTES = [chr(byte) for byte in range(256)]


def grammar_dir() -> Path:
    """Where the grammar is: inside an installed package, or at the top of a checkout."""
    installed = Path(__file__).parents[1] / "grammar"
    return installed if installed.is_dir() else Path(__file__).parents[3] / "grammar"


class Grammar:
    """The grammar of one family of controls, and what the fast roads take from it.

    ``file`` is the grammar file.  Files that it imports are looked for beside it, then in ``grammar/``.
    """

    def __init__(self, file: Path, folders: tuple[Path, ...]) -> None:
        self.file, self.folders = file, folders

    @cached_property
    def terminals(self) -> Mapping[str, str]:
        """Terminals of the file and of all it imports, as regular expressions; its own come first.

        Raises ProgramRejectedError (SYN002) when the file cannot be read, or lacks LETTER, NUMBER or BLANK.
        """
        try:
            own = self.file.read_text("ascii")
            found = _terminals(self._texts(own, set()))
            for name in found.keys() & {*_NEEDED, *_OPTIONAL}:  # the others are for lark to try
                re.compile(found[name])
        except (OSError, ValueError, re.error) as error:
            raise self._unusable(str(error)) from None
        # An imported file may have these for others; a block has them where its own grammar says so.
        said = set(_NAME.findall(_REMARK.sub("", own)))
        found = {name: pattern for name, pattern in found.items() if name in said or name not in _OPTIONAL}
        missing = [name for name in _NEEDED if name not in found]
        if missing:
            raise self._unusable(f"it has no terminal {', '.join(missing)} on a line of its own")
        return found

    @cached_property
    def parser(self) -> Lark:
        """The grammar of one block, as an LALR parser that keeps positions.

        Raises ProgramRejectedError (SYN002) for a grammar that cannot be used.
        """
        from lark import Lark  # noqa: PLC0415
        from lark.exceptions import LarkError  # noqa: PLC0415

        try:
            return Lark(
                self.file.read_text("ascii"),
                start="block",
                parser="lalr",
                lexer="contextual",
                propagate_positions=True,
                import_paths=[self._imported],
            )
        except (LarkError, OSError) as error:
            raise self._unusable(str(error).split("\n", 1)[0]) from None

    @cached_property
    def item(self) -> re.Pattern[str]:
        """One item of a plain block: a word with its number, blanks, or a comment."""
        names = self.terminals
        blank = f"(?:{names['BLANK']})?"
        # A letter and a separator are taken as they are found, as the grammar takes them.
        separator = f"(?>(?:{names['SEPARATOR']})?){blank}" if "SEPARATOR" in names else ""
        word = f"(?P<word>(?P<letter>(?>{names['LETTER']})){blank}{separator}(?P<number>{names['NUMBER']}))"
        comment = f"|(?P<comment>{names['COMMENT']})" if "COMMENT" in names else ""
        return re.compile(f"{word}|(?P<blank>{names['BLANK']}){comment}")

    @cached_property
    def call(self) -> re.Pattern[str]:
        """A call of a named subprogram with numbers, ``o<name> call [1.]``; else nothing."""
        names = self.terminals
        if "O_KEYWORD" not in names:
            return re.compile("(?!)")
        blank = f"(?:{names['BLANK']})?"
        numbers = rf"(?:{blank}\[{blank}{names['NUMBER']}{blank}\])*"
        return re.compile(
            rf"[oO][ \t]*(?P<label><[^>]*>)[ \t]*[cC][aA][lL][lL](?![A-Za-z])(?P<numbers>{numbers})"
        )

    @cached_property
    def argument(self) -> re.Pattern[str]:
        """A number of such a call."""
        return re.compile(self.terminals["NUMBER"])

    @cached_property
    def head(self) -> re.Pattern[str]:
        """The block-delete mark at the front; without one a pattern that matches nothing."""
        names = self.terminals
        delete = names.get("DELETE", "(?!)")
        return re.compile(f"(?:{names['BLANK']})?(?P<delete>{delete})")

    @cached_property
    def separators(self) -> str:
        """The single characters that may stand between a letter and its number; mostly none."""
        pattern = re.compile(self.terminals.get("SEPARATOR", "(?!)"))
        return "".join(character for character in _BYTES if pattern.fullmatch(character))

    def reads_letter(self, letter: str) -> bool:
        """True when a letter with a digit straight behind it is an address and its value."""
        match = re.match(self.terminals["LETTER"], f"{letter}1")
        return match is not None and match.end() == 1

    def _texts(self, text: str, seen: set[str]) -> Iterator[str]:
        yield text
        for name in _IMPORT.findall(text):
            if name not in seen:
                seen.add(name)
                yield from self._texts(self._imported(None, f"{name}.lark")[1], seen)

    def _imported(self, base: object, path: str) -> tuple[str, str]:
        """Name and text of an imported file, as lark asks for it.  Raises OSError when there is none."""
        for folder in self.folders:
            file = folder / path
            if file.is_file():
                return str(file), file.read_text("ascii")
        raise FileNotFoundError(f"there is no grammar file {path}")

    def _unusable(self, why: str) -> ProgramRejectedError:
        message = f"the grammar {self.file.name} of this control cannot be used: {why}"
        help_text = "this is a fault of the package that brings the control, not of the program"
        return ProgramRejectedError([Diagnostic(UNUSABLE_GRAMMAR, Severity.ERROR, message, help_text)])


def _terminals(texts: Iterable[str]) -> dict[str, str]:
    """The terminals of some files by name, the first of each."""
    found: dict[str, str] = {}
    for text in texts:
        for match in _TERMINAL.finditer(text):
            found.setdefault(match[1], match[2].replace("\\/", "/"))
    return found


def grammar_of(dialect: Dialect) -> Grammar:
    """The grammar of a dialect; each file is loaded once."""
    return _grammar(dialect.grammar)


@lru_cache
def _grammar(name: str | Path) -> Grammar:
    own = grammar_dir()
    file = own / f"{name}.lark" if isinstance(name, str) else name
    return Grammar(file, (file.parent, own))
