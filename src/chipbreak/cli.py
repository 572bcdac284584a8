"""The command line.

A command is imported when it is called, and everything heavy inside it, so that help and completion answer at
once.
"""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import TYPE_CHECKING, Any

import click

from chipbreak.text.encoding import escaped

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

# Where each command is, and the first sentence of its help.
_HOMES = {
    "advise": (
        "advise_command.advise",
        "Say which N, f, S and stroke break the chips of a cut on this machine, the best first.",
    ),
    "batch": ("batch_command.batch", "Filter many programs and folders of programs into a folder."),
    "check": (
        "program_commands.check",
        "Say everything that is wrong with programs, and with those in folders; write none.",
    ),
    "completion": (
        "completion_command.completion",
        "Print the script by which a shell completes commands, options, files and profiles.",
    ),
    "diff": ("program_commands.diff", "Compare two programs by what their blocks say."),
    "explain": ("program_commands.explain", "Show each vibrated cut, operation and check, with its reasons."),
    "filter": (
        "program_commands.filter_command",
        "Filter programs: from stdin or INPUT to stdout, OUT or INPUT itself.",
    ),
    "git-diff": ("git_commands.git_diff", "Compare two versions of a program as git's external diff driver."),
    "hooks": (
        "hook_commands.hooks",
        "Files by which LinuxCNC, CAM systems, git and editors call this program.",
    ),
    "inspect": ("tool_commands.inspect", "Compare traced edges BEFORE and AFTER cutting, tooth by tooth."),
    "language-server": (
        "language_server_command.language_server",
        "Check programs in an editor as one types them: the server side of the Language Server Protocol.",
    ),
    "machine-test": (
        "machine_test_command.machine_test",
        "Measure a machine: a short air cut, and what its times or a trace of it say.",
    ),
    "macros": ("program_commands.macros", "Write the macro programs that the tool checks call."),
    "plot": ("figure_commands.plot", "Draw a vibrated cut as the filtered program runs it."),
    "profile": ("profile_commands.profile", "Machine profiles."),
    "report": (
        "figure_commands.report",
        "Write all that is said of a program as one HTML page with figures.",
    ),
    "restore": ("program_commands.restore", "Give the original bytes back from a filtered program."),
    "resume": (
        "resume_command.resume",
        "Write the program that goes on from a line of PROGRAM, filtered or not.",
    ),
    "textconv": (
        "git_commands.textconv",
        "Print a program for git to compare: a part that chipbreak wrote is one line.",
    ),
    "tools": (
        "tool_commands.tools",
        "Show what is known about the tools of a program, who said it, and what a check lacks.",
    ),
    "verify": (
        "program_commands.verify",
        "Judge a filtered program as it stands: end points, times, states and chips.",
    ),
}


class _Commands(click.Group):
    """Commands that are listed from :data:`_HOMES`, and imported when one is called or asked for its help.

    Their complaints show what was typed, and give none of it to a terminal as an order.
    """

    def make_context(self, *args: Any, **extra: Any) -> click.Context:
        """Read the options of the group."""
        with _shown_errors():
            return super().make_context(*args, **extra)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command that is named."""
        try:
            with _shown_errors():
                return super().invoke(ctx)
        except KeyboardInterrupt:
            from chipbreak.streams import INTERRUPTED, say_interrupted

            say_interrupted()
            sys.exit(INTERRUPTED)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command, imported; None where there is none of this name."""
        if cmd_name not in self.commands:
            return None
        module, _, function = _HOMES[cmd_name][0].partition(".")
        command: click.Command = getattr(import_module(f"chipbreak.{module}"), function)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands into the help."""
        click.Group(commands=self.commands).format_commands(ctx, formatter)

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """What a shell offers for a word that begins so."""
        from click.shell_completion import CompletionItem

        begun = [one for name, one in sorted(self.commands.items()) if name.startswith(incomplete)]
        offered = [CompletionItem(one.name, help=one.get_short_help_str()) for one in begun]
        return [*offered, *click.Command.shell_complete(self, ctx, incomplete)]


@contextmanager
def _shown_errors() -> Iterator[None]:
    try:
        yield
    except click.ClickException as error:
        vars(error).update(message="\n".join(map(escaped, error.message.split("\n"))))
        raise


@click.group(
    cls=_Commands,
    commands={name: click.Command(name, help=summary) for name, (_, summary) in _HOMES.items()},
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.version_option(package_name="chipbreak")
def cli() -> None:
    """Break chips and watch tools on a control that cannot.

    chipbreak reads an NC program and writes a corrected one: cuts that ask for vibration are expanded into
    timed moves, and tool checks are inserted between operations.  Everything else stays as it is, byte for
    byte, and a program with an error in it gives no output at all.
    """


def main() -> None:
    """The ``chipbreak`` command; whatever happens, no traceback."""
    if sys.stderr is None:  # closed by who called: what is said is lost, what is done is not
        sys.stderr = os.fdopen(os.open(os.devnull, os.O_WRONLY), "w")
    gc.disable()  # loading modules leaves no garbage in circles: looking for it costs a tenth of a short run
    try:
        cli()
    except Exception as error:
        if os.environ.get("CHIPBREAK_TRACEBACK"):
            raise
        from chipbreak.options import USAGE, fail
        from chipbreak.streams import complain

        if isinstance(error, OSError) and error.filename is None:  # of a stream: nothing of ours has failed
            complain(f"Error: cannot read or write: {error.strerror}")
            sys.exit(USAGE)
        fail(f"error SLF002: internal fault, {type(error).__name__}: {error}")
