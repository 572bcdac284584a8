"""LinuxCNC as a judge: its interpreter and its simulated machine, without a screen.

Is this program valid, and what would the machine be told?

    from linuxcnc import rs274
    verdict = rs274.judge(b"G18 G7 G1 X20. Z-5. F100\\nM2\\n", lathe=True)   # more: subroutines=folder
    assert verdict.accepted, verdict.message
    verdict.canon       # the canonical calls as text;  rs274.calls(verdict.canon) splits them
    verdict.motion      # [Motion(kind, x_mm (radius), y_mm, z_mm, feed, per_rev, speed, …, time_s)]

What does the machine do with it, servo period by servo period?

    from linuxcnc import machine
    a, b = machine.run([path, b"G61 G1 Z-5 F600\\nM2\\n"], acceleration_mm_s2=5000)
    a.samples           # (n, 4): time [s], x, y, z [mm], a row per servo period;  a.moving(): no rests
    a.errors            # operator errors;  a.messages;  a.lines (n,);  a.line_times() {line: s}

``machine.run_steadily`` is for tests that compare samples: it repeats a run in which the machine had to wait.
A start costs about a second, so give ``run`` many programs at once.  Each starts from machine zero.  The
commanded position is what LinuxCNC sends to the drives, with the (1, 4, 1)/6 average of its joint
interpolator: it lags the planner by two periods and cuts the tip of a reversal by a third of the planner's
last step.

Mark tests that need the interpreter ``@pytest.mark.linuxcnc``, and those that need the machine
``@pytest.mark.linuxcnc("machine")``; ``plugin.py`` skips them where LinuxCNC is missing and says so.
"""


def available() -> bool:
    """True where both the interpreter and the simulated machine can be used."""
    from . import machine, rs274

    return rs274.available() and machine.available()
