"""The wheel is the same to the byte whoever builds it, and the tools that build and test it are pinned."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
_BUILT_FROM = ("src", "grammar", "pyproject.toml", "README.md", "LICENSE")
_PINS = {
    "dev": "tests/requirements.txt",
    "mutants": "tests/mutants-requirements.txt",
    "bench": "benchmarks/requirements.txt",
}
_PINNED = re.compile(r"^([A-Za-z0-9._-]+)==", re.MULTILINE)


def _copy(folder: Path, mode: int, when: float) -> Path:
    """What the wheel is made of, with other rights and times than here, and without git."""
    folder.mkdir()
    for name in _BUILT_FROM:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, folder / name)
    for path in folder.rglob("*"):
        path.chmod(mode | 0o111 if path.is_dir() else mode)
        os.utime(path, (when, when))
    return folder


def _wheel(checkout: Path, to: Path) -> bytes:
    command = [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory", str(to)]
    subprocess.run(command, cwd=checkout, check=True, timeout=120, capture_output=True)
    (wheel,) = to.glob("chipbreak-*.whl")
    return wheel.read_bytes()


def test_two_builds_are_the_same_bytes(tmp_path: Path) -> None:
    first = _wheel(_copy(tmp_path / "first", 0o600, 1.0e9), tmp_path / "one")
    second = _wheel(_copy(tmp_path / "second place", 0o644, 1.7e9), tmp_path / "two")
    assert first == second


def test_every_tool_is_pinned_with_its_hash() -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
    for extra, file in _PINS.items():
        text = (ROOT / file).read_text("utf-8")
        pinned = {name.lower() for name in _PINNED.findall(text)}
        names = extras[extra]
        for own in (name for name in extras[extra] if name.startswith("chipbreak[")):
            names = [*names, *(one for group in own[10:-1].split(",") for one in extras[group])]
        wanted = {re.split(r"[\[<>=]", name)[0].lower() for name in names} - {"chipbreak"}
        assert wanted <= pinned
        assert "://" not in text
        for requirement in re.split(r"\n(?=\S)", text.strip()):
            assert "--hash=sha256:" in requirement, requirement
