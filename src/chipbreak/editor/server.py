"""The language server: what :mod:`chipbreak.editor.document` finds, in the protocol that editors speak."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from functools import partial
from pathlib import Path

from lsprotocol import types
from pygls.lsp.server import LanguageServer
from pygls.uris import to_fs_path

from chipbreak.editor.document import Checked, Judge, Repair, Stretch, checked, not_checked, repairs, told_of
from chipbreak.settings import Settings
from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.text.named_tuple import NamedTuple

_PAUSE_S = 0.3  # somebody who types is waited for
_SEVERITIES = {
    Severity.ERROR: types.DiagnosticSeverity.Error,
    Severity.WARNING: types.DiagnosticSeverity.Warning,
    Severity.NOTE: types.DiagnosticSeverity.Information,
}


def _in_one_line(record: logging.LogRecord) -> bool:
    """What the protocol has to say, without where in its code that was."""
    record.exc_info = None
    return True


class Machine(NamedTuple):
    """How the program of a file is judged: its settings, and a run of it."""

    settings: Settings
    judge: Judge


MachineFor = Callable[[str], Machine | Diagnostic]
"""From the name of a file to how it is judged, or to why that cannot be."""


class Server:
    """The programs that are open, with what was found of each."""

    def __init__(self, version: str, machine_for: MachineFor) -> None:
        self.machine_for = machine_for
        self.found: dict[str, Checked] = {}
        self.protocol = LanguageServer("chipbreak", version)
        for method, answer in (
            (types.TEXT_DOCUMENT_DID_OPEN, self.opened),
            (types.TEXT_DOCUMENT_DID_CHANGE, self.changed),
            (types.TEXT_DOCUMENT_DID_CLOSE, self.closed),
            (types.TEXT_DOCUMENT_HOVER, self.hover),
        ):
            self.protocol.feature(method)(partial(answer))
        kinds = types.CodeActionOptions(code_action_kinds=[types.CodeActionKind.QuickFix])
        self.protocol.feature(types.TEXT_DOCUMENT_CODE_ACTION, kinds)(partial(self.actions))

    def run(self) -> None:
        """Speak on standard input and output until the editor ends it."""
        handler = logging.StreamHandler()
        handler.setFormatter(logging.Formatter("chipbreak language-server: %(message)s"))
        handler.addFilter(_in_one_line)
        logging.getLogger("pygls").addHandler(handler)
        self.protocol.start_io()

    async def opened(self, asked: types.DidOpenTextDocumentParams) -> None:
        """Judge a program at once."""
        await self._judge(asked.text_document.uri)

    async def changed(self, asked: types.DidChangeTextDocumentParams) -> None:
        """Judge it when nobody has typed for a while."""
        uri = asked.text_document.uri
        version = asked.text_document.version
        await asyncio.sleep(_PAUSE_S)
        if self.protocol.workspace.get_text_document(uri).version == version:
            await self._judge(uri)

    def closed(self, asked: types.DidCloseTextDocumentParams) -> None:
        """Forget it."""
        uri = asked.text_document.uri
        self.found.pop(uri, None)
        self._show(uri, [])

    async def hover(self, asked: types.HoverParams) -> types.Hover | None:
        """What 'explain' says of the line."""
        found = await self._up_to_date(asked.text_document.uri)
        told = told_of(found, asked.position.line)
        if not told:
            return None
        return types.Hover(types.MarkupContent(types.MarkupKind.PlainText, told))

    async def actions(self, asked: types.CodeActionParams) -> list[types.CodeAction]:
        """The ways out of what is wrong there that have been tried."""
        uri = asked.text_document.uri
        found = await self._up_to_date(uri)
        machine = self.machine_for(_name(uri))
        if isinstance(machine, Diagnostic):
            return []
        first, last = asked.range.start.line, asked.range.end.line
        tried = await asyncio.to_thread(lambda: list(repairs(found, first, last, machine.judge)))
        return [_action(uri, one) for one in tried]

    async def _up_to_date(self, uri: str) -> Checked:
        found = self.found.get(uri)
        if found is None or found.text != self._text(uri):
            await self._judge(uri)
        return self.found[uri]

    async def _judge(self, uri: str) -> None:
        text = self._text(uri)
        machine = self.machine_for(_name(uri))
        if isinstance(machine, Diagnostic):
            found = not_checked(text, machine)
        else:
            found = await asyncio.to_thread(checked, text, machine.judge, machine.settings)
        self.found[uri] = found
        if text == self._text(uri):  # else it will be judged again
            self._show(uri, [_shown(one.said, one.at) for one in found.findings])

    def _text(self, uri: str) -> str:
        text: str = self.protocol.workspace.get_text_document(uri).source
        return text

    def _show(self, uri: str, diagnostics: list[types.Diagnostic]) -> None:
        self.protocol.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, diagnostics))


def _name(uri: str) -> str:
    """The name of a file; one that has never been saved counts as one of this folder."""
    return to_fs_path(uri) or Path("unsaved.nc").name


def _range(at: Stretch) -> types.Range:
    return types.Range(types.Position(at.line, at.first), types.Position(at.line, at.last))


def _shown(said: Diagnostic, at: Stretch) -> types.Diagnostic:
    message = f"{said.message}\nhelp: {said.help}" if said.help else said.message
    return types.Diagnostic(
        _range(at), message, _SEVERITIES[said.severity], code=said.code, source="chipbreak"
    )


def _action(uri: str, repair: Repair) -> types.CodeAction:
    finding, text = repair
    edit = types.TextEdit(_range(finding.at), text)
    return types.CodeAction(
        f"write {text}",
        kind=types.CodeActionKind.QuickFix,
        diagnostics=[_shown(finding.said, finding.at)],
        edit=types.WorkspaceEdit(changes={uri: [edit]}),
    )
