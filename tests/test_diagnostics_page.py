"""The page of diagnostics is made from one file, with a way out for every code."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[1]
sys.path.insert(0, str(CHECKOUT / "benchmarks"))

import diagnostics_page  # noqa: E402

TEXTS = {code: text for section in diagnostics_page.sections() for code, text in section.codes.items()}
EXAMPLES = diagnostics_page.examples()


def test_the_page_is_what_the_command_writes() -> None:
    assert diagnostics_page.PAGE.read_text("utf-8") == diagnostics_page.page(), "make diagnostics"


def test_a_code_is_listed_once() -> None:
    listed = [code for section in diagnostics_page.sections() for code in section.codes]
    assert len(listed) == len(set(listed))


@pytest.mark.parametrize("code", TEXTS)
def test_every_code_has_a_way_out(code: str) -> None:
    """A text of its own, or that of the message that its example shows."""
    text = TEXTS[code]
    assert text.meaning
    assert text.severity in ("error", "warning", "note")
    if code in EXAMPLES:
        example = EXAMPLES[code]
        said = example.said(code)
        assert "\n  help: " in said or text.way_out
        if "checks.strict=true" not in example.sets:
            assert f" {text.severity} {code}: " in said
    else:
        assert text.way_out


def test_an_example_must_show_its_code() -> None:
    with pytest.raises(ValueError, match="VIB001 is not said of"):
        EXAMPLES["VIB005"].said("VIB001")
