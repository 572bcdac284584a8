"""The command that sets up completion in a shell."""

from __future__ import annotations

import click

_SHELLS = ("bash", "zsh", "fish")


@click.command()
@click.argument("shell", type=click.Choice(_SHELLS))
@click.pass_context
def completion(context: click.Context, shell: str) -> None:
    """Print the script by which a shell completes commands, options, files and profiles.

    For bash, into ~/.bashrc: eval "$(chipbreak completion bash)".  For zsh the same with zsh in ~/.zshrc.
    For fish: chipbreak completion fish > ~/.config/fish/completions/chipbreak.fish.
    """
    from click.shell_completion import get_completion_class

    kind = get_completion_class(shell)
    assert kind is not None
    group = context.find_root().command
    click.echo(kind(group, {}, "chipbreak", "_CHIPBREAK_COMPLETE").source())
