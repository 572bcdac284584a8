"""The command by which editors check programs as one types them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from chipbreak.options import PROFILE, SET, STRICT, TOOLS, UNBROKEN, UNROLL, Asked, asking, settings_for
from chipbreak.outcome import Outcome, internal_fault, outcome_of
from chipbreak.program_files import read_beside
from chipbreak.text.diagnostics import Diagnostic, Severity

if TYPE_CHECKING:
    from chipbreak.editor.server import Machine
    from chipbreak.settings import Settings

NO_MACHINE = "EDT001"


@click.command("language-server")
@click.option("--stdio", is_flag=True, help="Spoken on standard input and output anyway; editors say it.")
@asking(PROFILE, SET, TOOLS, STRICT, UNBROKEN, UNROLL)
def language_server(asked: Asked, stdio: bool) -> None:
    """Check programs in an editor as one types them: the server side of the Language Server Protocol.

    The machine is that of -p, CHIPBREAK_PROFILE, or the chipbreak.toml that is found for the program.  Needs
    the extra "editor": pip install 'chipbreak[editor]'.
    """
    try:
        from chipbreak.editor.server import Server
    except ImportError:
        raise click.UsageError("the language server needs: pip install 'chipbreak[editor]'") from None
    from importlib.metadata import version

    Server(version("chipbreak"), lambda name: _machine_for(asked, name)).run()


def _machine_for(asked: Asked, name: str) -> Machine | Diagnostic:
    """How the program of a file is judged, or why it cannot be."""
    from chipbreak.editor.server import Machine
    from chipbreak.settings import SettingsError

    try:
        settings = settings_for(asked, name)
    except SettingsError as error:
        return error.diagnostic._replace(message=f"the profile cannot be used: {error.diagnostic.message}")
    except click.UsageError as error:
        return Diagnostic(NO_MACHINE, Severity.WARNING, error.message)
    return Machine(settings, lambda text: _outcome(text, settings, name, asked))


def _outcome(text: str, settings: Settings, name: str, asked: Asked) -> Outcome:
    """What a run of the text in the editor comes to; an editor goes on whatever happens."""
    from chipbreak.pipeline import rewrite

    try:
        data = text.encode("utf-8", "replace")
        beside = read_beside(name)
        return outcome_of(
            lambda: rewrite(data, settings, name, beside=beside, allow_unbroken=asked.allow_unbroken)
        )
    except Exception as error:
        return internal_fault(error)
