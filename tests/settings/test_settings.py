"""Profiles: layers, types, places of mistakes, and where each value says it came from."""

from __future__ import annotations

from pathlib import Path

import pytest

import chipbreak
from chipbreak.settings import Settings, SettingsError, load, profile_names
from chipbreak.text.frozen_table import FrozenTable


def refused(profile: Path | str, *options: str) -> tuple[str, int, str]:
    """Code, line and help of a profile that must not be taken."""
    with pytest.raises(SettingsError) as caught:
        load(str(profile), options)
    found = caught.value.diagnostic
    assert found.help
    assert found.message
    return found.code, found.place.line if found.place else 0, found.help


def written(folder: Path, text: str, name: str = "my.toml") -> Path:
    file = folder / name
    file.parent.mkdir(exist_ok=True)
    file.write_text(text)
    return file


def test_every_shipped_profile_loads() -> None:
    for name in profile_names():
        assert load(name).name == name


def test_defaults_are_those_of_the_manual() -> None:
    settings = load("generic-lathe")
    assert settings.command.base_period_ms == 4.0
    assert settings.command.min_multiple == 4
    assert settings.vibration.margin == 1.2
    assert settings.vibration.alpha == 0.5
    assert settings.vibration.phase == "auto"
    assert settings.vibration.rounding == "nearest-half"
    assert (settings.vibration.pn, settings.vibration.mn, settings.vibration.n) == (None, None, None)
    assert settings.spindle.resolution_rpm == 1.0
    assert settings.output.feed_mode == "rev"


# --- layers -----------------------------------------------------------------------------------------------


def test_options_win_over_the_file_and_the_file_over_its_base(tmp_path: Path) -> None:
    base = written(
        tmp_path, 'base = "generic-lathe"\n[vibration]\nq = 1.1\nn = 0.5\nalpha = 0.6\n', "base.toml"
    )
    file = written(tmp_path, 'base = "base.toml"\n[vibration]\nn = 2.5\nalpha = 0.7\n')
    settings = load(str(file), ["vibration.alpha=0.8"])
    vibration = settings.vibration
    assert (vibration.q, vibration.n, vibration.alpha) == (1.1, 2.5, 0.8)
    assert settings.origin("vibration.q") == f"profile {base}, line 3"
    assert settings.origin("vibration.n") == f"profile {file}, line 3"
    assert settings.origin("vibration.alpha") == "--set"
    assert settings.origin("vibration.margin") == "default"
    assert settings.dialect.name == "generic-lathe"


def test_a_base_counts_from_the_file_that_names_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written(tmp_path, 'base = "generic-lathe"\n[vibration]\nn = 0.5\n', "machine.toml")
    written(tmp_path, 'base = "../machine.toml"\n', "jobs/chipbreak.toml")
    monkeypatch.chdir("/")
    assert load(str(tmp_path / "jobs" / "chipbreak.toml")).vibration.n == 0.5


@pytest.mark.parametrize("base", ["my.toml", "./my.toml", "sub/../my.toml", "sub/other.toml"])
def test_profiles_in_a_circle(base: str, tmp_path: Path) -> None:
    written(tmp_path, 'base = "../my.toml"\n', "sub/other.toml")
    file = written(tmp_path, f'base = "{base}"\n')
    assert refused(file)[0] == "SET003"


# --- values -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("option", "section", "key", "value"),
    [
        ("vibration.n=1.5", "vibration", "n", 1.5),
        ("vibration.n = 2", "vibration", "n", 2.0),
        ("vibration.phase=0.4", "vibration", "phase", 0.4),
        ("vibration.phase=auto", "vibration", "phase", "auto"),
        ('vibration.waveform="sine"', "vibration", "waveform", "sine"),
        ("command.multiples=[5, 4]", "command", "multiples", (5, 4)),
        ("command.multiples=4", "command", "multiples", (4,)),
        ("command.periods_ms=[16, 20.5]", "command", "periods_ms", (16.0, 20.5)),
        ("control.x_diameter=false", "control", "x_diameter", False),
        ("checks.w_mm.4=0.1", "checks", "w_mm", FrozenTable({"4": 0.1})),
        ("checks.sister.4=14", "checks", "sister", FrozenTable({"4": 14})),
        ("checks.every=3", "checks", "every", 3),
        ("checks.retries=0", "checks", "retries", 0),
        ("macros.beam_y_mm=-35.2", "macros", "beam_y_mm", -35.2),
        ("macros.turn_sign=-1", "macros", "turn_sign", -1),
        ("macros.laser_on=M70", "macros", "laser_on", "M70"),
    ],
)
def test_options(option: str, section: str, key: str, value: object) -> None:
    settings: Settings = load("generic-lathe", [option])
    assert getattr(getattr(settings, section), key) == value
    assert type(getattr(getattr(settings, section), key)) is type(value)


@pytest.mark.parametrize(
    ("option", "code", "hint"),
    [
        ("vibration.margn=1.3", "SET001", "margin"),
        ("vibrations.margin=1.3", "SET001", "vibration"),
        ("vibration.=1", "SET001", ""),
        ("margin=1.3", "SET001", "--set"),
        ("vibration.margin", "SET001", "--set"),
        ("vibration.margin=much", "SET002", "a number"),
        ("vibration.margin=true", "SET002", "a number"),
        ("command.min_multiple=4.5", "SET002", "a whole number"),
        ("control.x_diameter=1", "SET002", "true or false"),
        ("vibration=1", "SET001", ""),
        ("vibration.margin=0.9", "SET003", "at least 1"),
        ("vibration.margin=nan", "SET003", "at least 1"),
        ("vibration.n=inf", "SET003", "above 0"),
        ("vibration.n=0", "SET003", "above 0"),
        ("axes.X.steps_per_mm=0.1", "SET003", "at least 10"),
        ("axes.X.increment_mm=3", "SET003", "up to 0.1"),
        ("vibration.alpha=1.0", "SET003", "below 1"),
        ("vibration.phase=half", "SET003", "auto"),
        ("vibration.waveform=square", "SET003", "triangle, sine"),
        ("command.multiples=[4, 1]", "SET003", "at least 2"),
        ("command.periods_ms=[16, 0]", "SET003", "above 0"),
        ("output.decimals=10", "SET003", "below 10"),
        ("output.decimals=-1", "SET003", "at least 0"),
        ("control.dialect=okuma", "SET003", "fanuc-lathe"),
        ("control.lathe_system=D", "SET003", "A, B, C"),
        ("vibration.n=" + "[" * 5000, "SET004", ""),
        ("checks.w_mm.rough=0.1", "SET003", "one line a tool"),
        ("checks.w_mm.4=0", "SET003", "above 0"),
        ("checks.sister=14", "SET002", "a line for each"),
        ("checks.sister.4=4.5", "SET002", "a whole number"),
        ("checks.sister.4=4", "SET003", "another tool"),
        ("checks.every=0", "SET003", "at least 1"),
        ("checks.retries=-1", "SET003", "at least 0"),
        ("checks.alarm_base=9900", "SET003", "below 9900"),
        ("checks.trace_step_mm=0", "SET003", "above 0"),
        ("macros.beam_x=1", "SET001", "beam_x_mm"),
        ("macros.slow_feed=0", "SET003", "above 0"),
        ("macros.turn_sign=2", "SET003", "one of 1, -1"),
        ("macros.orient=M19", "SET003", "M19 R{angle}"),
        ("macros.orient=M19 R{angle} P{axis}", "SET003", "M19 R{angle}"),
        ("macros.laser_on=M70 (\u00c4)", "SET003", "plain letters"),
        ("planner.path_mode=G62", "SET003", "it has G61, G64; for example"),
        ("planner.smoothing_off=G5.1 Q0", "SET003", "it has none: leave smoothing_off out"),
        ("macros.store_last=500", "SET003", "at least 40"),
        ("command.multiples=[]", "SET003", "name one or more"),
        ("command.periods_ms=[]", "SET003", "name one or more"),
        ("command.max_multiple=3", "SET003", "4 or more"),
    ],
)
def test_options_that_cannot_be(option: str, code: str, hint: str) -> None:
    found, _, help_text = refused("generic-lathe", option)
    assert found == code
    assert hint in help_text


def test_a_spindle_between_no_speeds_cannot_be() -> None:
    found, _, help_text = refused("generic-lathe", "spindle.min_rpm=2000", "spindle.max_rpm=1000")
    assert (found, help_text) == ("SET003", "2000 or more, or another spindle.min_rpm")


@pytest.mark.parametrize(
    ("text", "code", "line"),
    [
        ("[vibration]\nn = 1.5\n", "SET003", 1),
        ('[control]\ndialect = "generic-lathe"\n\n[vibration]\n# a note\nmargn = 1.3\n', "SET001", 6),
        ('[control]\ndialect = "generic-lathe"\n[vibration]\nmargin = "x"\n', "SET002", 4),
        ('[control]\ndialect = "generic-lathe"\nx_diameter = 5\n', "SET002", 3),
        ('vibration = 5\n[control]\ndialect = "generic-lathe"\n', "SET002", 1),
        ("[control\n", "SET004", 1),
        ('[control]\ndialect = "generic-lathe"\n[control]\n', "SET004", 3),
        ("x = " + "[" * 5000, "SET004", 0),
    ],
)
def test_mistakes_in_a_file_are_shown_where_they_stand(
    text: str, code: str, line: int, tmp_path: Path
) -> None:
    file = written(tmp_path, text)
    assert refused(file)[:2] == (code, line)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    assert refused(tmp_path / "nowhere.toml")[0] == "SET004"
    assert refused(tmp_path / "nowhere")[0] == "SET005"
    assert refused("")[0] == "SET005"
    (tmp_path / "latin.toml").write_bytes(b'# \xe9\n[control]\ndialect = "generic-lathe"\n')
    assert refused(tmp_path / "latin.toml")[0] == "SET004"
    (tmp_path / "folder.toml").mkdir()
    assert refused(tmp_path / "folder.toml")[0] == "SET004"


def test_a_feed_mode_the_control_has_not_is_said_at_once() -> None:
    code, _, help_text = refused("fanuc-lathe", "output.feed_mode=inverse")
    assert code == "SET003"
    assert help_text == "one of rev, minute"


@pytest.mark.parametrize(
    ("text", "line", "column"),
    [
        ("[checks]\nenabled = true\n\n[checks.w_mm]\n4 = 0.02\n5 = -1\n", 6, 1),
        ("[checks]\nenabled = true\nw_mm = { 4 = 0.02, 5 = -1 }\n", 3, 20),
        ('# all\nchecks = { w_mm = { "5" = -1 } }\n', 2, 21),
        ("[checks]\nw_mm.5 = -1\n", 2, 1),
        ('[axes]\nX = { letter = "X" }\nZ = { sign = 3 }\n', 3, 7),
        ("[axes.Z]\n'sign' = 3\n", 2, 1),
        ('[vibration]\nmargin = 1.3 # alpha = 3\nalpha = 3 # "\n', 3, 1),
        ("[checks]\nonly = [\n 1,\n 2,\n]\nevery = 0\n", 6, 1),
        ("[vibration]\nmargin = 1.3\n[vibrations]\nn = 1.5\n", 3, 2),
    ],
)
def test_a_mistake_in_any_table_names_its_line(tmp_path: Path, text: str, line: int, column: int) -> None:
    base = 'base = "fanuc-lathe"\n'
    with pytest.raises(SettingsError) as caught:
        load(written(tmp_path, base + text))
    place = caught.value.diagnostic.place
    assert place is not None
    assert (place.line - 1, place.column) == (line, column)


def test_a_profile_with_a_byte_order_mark_is_read(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_bytes(b'\xef\xbb\xbfbase = "fanuc-lathe"\r\n[vibration]\r\nmargin = 1.3\r\n')
    assert load(file).vibration.margin == 1.3
    assert load(file).origin("vibration.margin").endswith("line 3")


@pytest.mark.parametrize("path", [r"C:\work\tools.csv", r"C:\Usb\tools.csv"])
def test_a_path_of_windows_says_how_it_is_written(tmp_path: Path, path: str) -> None:
    base = 'base = "fanuc-lathe"\n[tools]\n'
    code, line, help_text = refused(written(tmp_path, f'{base}files = ["{path}"]\n'))
    assert (code, line) == ("SET004", 3)
    assert "'C:\\tools.csv' in single quotes" in help_text
    for way_out in (f"'{path}'", '"' + path.replace("\\", "/") + '"'):
        assert load(written(tmp_path, f"{base}files = [{way_out}]\n")).tools.files


def test_a_path_of_windows_with_a_tab_in_it() -> None:
    with pytest.raises(chipbreak.ToolFileError) as caught:
        chipbreak.read_tools("C:\tools.csv")
    assert "single quotes" in caught.value.diagnostics[0].help


@pytest.mark.parametrize("number", ["2" * 400, "-" + "2" * 400])
def test_a_number_that_no_float_holds_is_not_possible(number: str) -> None:
    with pytest.raises(SettingsError) as caught:
        load("generic-lathe", [f"spindle.settle_s={number}"])
    assert caught.value.diagnostic.code == "SET003"
