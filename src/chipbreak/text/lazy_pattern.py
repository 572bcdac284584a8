"""Regular expressions that cost nothing until they are used."""

from __future__ import annotations

import re
from functools import cached_property
from typing import Any


class LazyPattern:
    """A regular expression compiled when it is first used: most programs need few of them."""

    def __init__(self, pattern: str, flags: int = 0) -> None:
        self.source = pattern
        self.flags = flags

    @cached_property
    def compiled(self) -> re.Pattern[str]:
        """The compiled expression."""
        return re.compile(self.source, self.flags)

    def search(self, *args: Any) -> re.Match[str] | None:
        """As of a compiled expression."""
        return self.compiled.search(*args)

    def match(self, *args: Any) -> re.Match[str] | None:
        """As of a compiled expression."""
        return self.compiled.match(*args)

    def fullmatch(self, *args: Any) -> re.Match[str] | None:
        """As of a compiled expression."""
        return self.compiled.fullmatch(*args)

    def sub(self, *args: Any) -> str:
        """As of a compiled expression."""
        return self.compiled.sub(*args)

    def finditer(self, *args: Any) -> Any:
        """As of a compiled expression."""
        return self.compiled.finditer(*args)

    def findall(self, *args: Any) -> list[Any]:
        """As of a compiled expression."""
        return self.compiled.findall(*args)
