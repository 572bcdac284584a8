"""A contour that moves more than X and Z stays: its passes would be without the rest."""

from __future__ import annotations

import pytest

import chipbreak

PASSES = (
    "G71 U1. R0.5\nG71 P10 Q20 U0.2 W0.1 F0.2\nN10 G0 X20.\nG1 Z-5.{word}\nN20 X32.",
    "G72 W1. R0.5\nG72 P10 Q20 U0.2 W0.1 F0.2\nN10 G0 Z-5.\nG1 X20.{word}\nN20 Z2.",
    "G73 U1. R2\nG73 P10 Q20 U0.2 W0.1 F0.2\nN10 G0 X20.\nG1 Z-5.{word}\nN20 X32.",
    "G70 P10 Q20 F0.1\nN10 G0 X20.\nG1 Z-5.{word}\nN20 X32.",
)


def filtered(passes: str, word: str, profile: str) -> tuple[bytes, chipbreak.Result]:
    cycle = passes.format(word=word)
    program = f"G21 G99\nG97 S800 M3\nG0 X30. Z1.\n{cycle}\nG0 X80.\nM30\n".encode()
    return program, chipbreak.rewrite(program, chipbreak.load(profile, ("cycles.unroll=always",)))


@pytest.mark.parametrize("word", [" Y1.", " V1.", " B5.", " H5.", " D5."])
@pytest.mark.parametrize("passes", PASSES, ids=lambda one: one[:3])
@pytest.mark.parametrize("profile", ["fanuc-lathe", "haas-lathe", "mitsubishi-lathe"])
def test_it_stays(profile: str, passes: str, word: str) -> None:
    program, result = filtered(passes, word, profile)
    assert result.data == program
    said = [one.message for one in result.diagnostics if one.code == "CYC002"]
    assert "another axis" in said[0] or "not read here" in said[0]


@pytest.mark.parametrize("passes", PASSES[:3], ids=lambda one: one[:3])
def test_without_it_it_is_written_out(passes: str) -> None:
    program, result = filtered(passes, "", "fanuc-lathe")
    assert result.data != program


@pytest.mark.parametrize("code", ["G41", "G42", "G20", "G98"])
@pytest.mark.parametrize("place", ["G90 X18. Z-5. F0.2\nX16.{word}", "G90 X18. Z-5. F0.2\n{word}\nX16."])
def test_a_mode_that_a_pass_changes_lets_it_stay(place: str, code: str) -> None:
    """It would be that of the passes before it too."""
    program, result = filtered(place, f" {code}", "fanuc-lathe")
    assert result.data == program
    assert "CYC007" in [one.code for one in result.diagnostics]
