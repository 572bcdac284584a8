"""Where a profile is: shipped, a file of the user's, or offered by another installed package.

A package offers its profiles by an entry point of the group ``chipbreak.profiles``.  Its value is the package
in which the TOML files lie; its name does not matter.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Final

from chipbreak.settings.checking import UNKNOWN_PROFILE, UNREADABLE, SettingsError
from chipbreak.text.bounds import MOST_LINE_CHARS, MOST_PROFILE_BYTES, long_line, read_bounded
from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.text.existence import is_file
from chipbreak.text.nearest import nearest

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

GROUP: Final = "chipbreak.profiles"
_PROFILES = Path(__file__).parents[1] / "profiles"


def profile_names() -> list[str]:
    """The shipped profiles."""
    return sorted(path.stem for path in _PROFILES.glob("*.toml"))


def profile_text(profile: str) -> tuple[str, str]:
    """Name and text of a profile: a shipped name, the path of a TOML file, or a name that a package offers.

    Raises SettingsError when there is none of these, or two packages offer the name.
    """
    if profile in profile_names():
        return profile, (_PROFILES / f"{profile}.toml").read_text("utf-8")
    path = Path(profile)
    is_path = path.suffix == ".toml" or is_file(path)
    file = path if is_path else _offered(profile)
    try:
        data = read_bounded(file, MOST_PROFILE_BYTES) if isinstance(file, Path) else file.read_bytes()
        return profile, _text(data.decode("utf-8-sig"))  # Windows editors put a mark in front
    except (OSError, ValueError) as error:
        message = f"profile {profile} cannot be read: {_os_reason(error)}"
        raise _error(UNREADABLE, message, "check the path; a profile is a TOML file in UTF-8") from None


def _text(text: str) -> str:
    """The text with its line ends as TOML has them.  Raises ValueError for a line that no profile has."""
    lines = text.replace("\r\n", "\n").replace("\r", "\n")
    number = long_line(lines.split("\n"))
    if number is not None:
        raise ValueError(f"line {number} has more than {MOST_LINE_CHARS} characters")
    return lines


def _offered(profile: str) -> Traversable:
    """The file of a profile that an installed package offers."""
    files = [file for file in _offered_files() if file.name == f"{profile}.toml"]
    if len(files) > 1:
        places = " and ".join(sorted(map(str, files)))
        message = f"the profile {profile!r} is offered twice: {places}"
        raise _error(
            UNKNOWN_PROFILE, message, "uninstall one of the two packages, or give the path of the file"
        )
    if not files:
        names = profile_names() + sorted(file.name.removesuffix(".toml") for file in _offered_files())
        near = nearest(profile, names)
        hint = f"did you mean {near}? " if near else ""
        known = f"{hint}shipped: {', '.join(profile_names())}; or give the path of a TOML file"
        raise _error(UNKNOWN_PROFILE, f"there is no profile {profile!r}", known)
    return files[0]


def _offered_files() -> Iterator[Traversable]:
    """The profiles of installed packages."""
    from importlib.metadata import entry_points  # noqa: PLC0415 (slow to import, and few profiles need them)
    from importlib.resources import files  # noqa: PLC0415

    for entry in entry_points(group=GROUP):
        try:
            found = [file for file in files(entry.module).iterdir() if file.name.endswith(".toml")]
        except Exception as error:
            message = f"the profiles of {entry.value} cannot be read: {type(error).__name__}: {error}"
            help_text = "update or remove the package that offers them"
            raise _error(UNREADABLE, message, help_text) from error
        yield from found


def _error(code: str, message: str, help_text: str) -> SettingsError:
    return SettingsError(Diagnostic(code, Severity.ERROR, message, help_text))


def _os_reason(error: Exception) -> str:
    if isinstance(error, OSError):
        return error.strerror or str(error)
    return "it is not UTF-8 text" if isinstance(error, UnicodeDecodeError) else str(error)
