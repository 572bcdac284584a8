"""An editor that speaks the Language Server Protocol with a server of its own: JSON-RPC over pipes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from queue import Queue
from typing import Any

_WAIT_S = 60.0
Message = dict[str, Any]


class Client:
    def __init__(self, folder: Path, *arguments: str) -> None:
        env = {k: v for k, v in os.environ.items() if not k.startswith("CHIPBREAK")}
        self.process = subprocess.Popen(
            [sys.executable, "-m", "chipbreak", "language-server", *arguments],
            cwd=folder,
            env=env,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        self.came: Queue[Message] = Queue()
        threading.Thread(target=self._read, daemon=True).start()
        self.count = 0
        self.version = 0
        self.server = self.ask("initialize", processId=None, rootUri=folder.as_uri(), capabilities={})
        self.tell("initialized")

    def _read(self) -> None:
        stream = self.process.stdout
        assert stream is not None
        while line := stream.readline():
            size = int(line.split(b":")[1])
            assert stream.readline() == b"\r\n" or stream.readline() == b"\r\n"
            self.came.put(json.loads(stream.read(size)))

    def _send(self, message: Message) -> None:
        data = json.dumps({"jsonrpc": "2.0", **message}).encode()
        assert self.process.stdin is not None
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n%s" % (len(data), data))
        self.process.stdin.flush()

    def _wait(self, wanted: Callable[[Message], bool]) -> Message:
        while True:
            message = self.came.get(timeout=_WAIT_S)
            if wanted(message):
                return message

    def tell(self, method: str, **params: Any) -> None:
        self._send({"method": method, "params": params})

    def ask(self, method: str, **params: Any) -> Any:
        self.count += 1
        number = self.count
        self._send({"id": number, "method": method, "params": params})
        answer = self._wait(lambda one: one.get("id") == number and "method" not in one)
        assert "error" not in answer, answer
        return answer["result"]

    def shown(self, uri: str) -> list[Message]:
        """The next diagnostics that the server shows of a program."""
        method = "textDocument/publishDiagnostics"
        said = self._wait(lambda one: one.get("method") == method and one["params"]["uri"] == uri)
        found: list[Message] = said["params"]["diagnostics"]
        return found

    def open(self, uri: str, text: str) -> list[Message]:
        self.version = 1
        document = {"uri": uri, "languageId": "gcode", "version": 1, "text": text}
        self.tell("textDocument/didOpen", textDocument=document)
        return self.shown(uri)

    def change(self, uri: str, text: str) -> None:
        self.version += 1
        changes = [{"text": text}]
        self.tell(
            "textDocument/didChange",
            textDocument={"uri": uri, "version": self.version},
            contentChanges=changes,
        )

    def hover(self, uri: str, line: int) -> str:
        answer = self.ask(
            "textDocument/hover", textDocument={"uri": uri}, position={"line": line, "character": 0}
        )
        return answer["contents"]["value"] if answer else ""

    def actions(self, uri: str, line: int) -> list[Message]:
        end = {"line": line, "character": 0}
        answer = self.ask(
            "textDocument/codeAction",
            textDocument={"uri": uri},
            range={"start": end, "end": end},
            context={"diagnostics": []},
        )
        return answer or []

    def close(self) -> int:
        self.ask("shutdown")
        self.tell("exit")
        with self.process:
            return self.process.wait(_WAIT_S)
