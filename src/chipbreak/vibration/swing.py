"""Waves that go forward and back: the feed of every block follows from its time."""

from __future__ import annotations

from chipbreak.kinematics.sourced_value import SourcedValue
from chipbreak.kinematics.waveform import WaveformParameters, least_stroke_mm
from chipbreak.syntax.numbers import print_number
from chipbreak.text.diagnostics import RefusalError
from chipbreak.vibration.expander import Expander, Form, StrokeAsked


class Swing(Expander):
    """Forward and back by a stroke that grows and shrinks at the ends."""

    keeps_feed = False
    larger = "give a larger Q or A"

    def form(self, segments: str) -> Form:
        """A block per stroke, unless the profile says otherwise."""
        return "tick" if segments == "tick" else "stroke"

    def stroke_mm(self, asked: StrokeAsked) -> float:
        """A, or Q times the feed, or the least stroke that breaks with the margin."""
        if "A" in asked.values:
            return asked.values["A"].value
        if "Q" in asked.values:
            return asked.values["Q"].value * asked.feed_mm_rev
        return least_stroke_mm(
            self.wave.name,
            asked.per_rev,
            asked.feed_mm_rev,
            alpha_share=asked.alpha_share,
            edges=asked.edges,
            margin=asked.margin,
            ticks=asked.ticks,
        )

    def ramp_s(self, ramp_s: float) -> float:
        """See :meth:`Expander.ramp_s`."""
        return ramp_s

    def title(self, wave: WaveformParameters) -> str:
        """See :meth:`Expander.title`."""
        return f"STROKE {print_number(wave.stroke_mm, 4)}"

    def told(self, wave: WaveformParameters, dwell_s: float) -> tuple[str, str]:
        """See :meth:`Expander.told`."""
        size = f"{wave.stroke_mm:.4g} mm = {wave.stroke_mm / wave.feed_mm_rev:.3g} x feed"
        shape = f"{wave.feed_mm_rev:.4g} mm/rev, {wave.waveform}, forward share {wave.alpha_share:.3g}"
        return "stroke", f"{size} {shape}"

    def told_need(self, acceleration_mm_s2: float) -> str:
        """See :meth:`Expander.told_need`."""
        return f"needs {acceleration_mm_s2:z.0f} mm/s2"

    def told_without_count(self) -> str:
        """See :meth:`Expander.told_without_count`."""
        return "no N that could be told: at full stroke the tool turns back once or never"


class EvenSwing(Swing):
    """A swing that goes forward and back in equal times, and is many blocks a stroke."""

    def refuse_share(self, alpha: SourcedValue) -> None:
        """See :meth:`Expander.refuse_share`."""
        if alpha.value != 0.5:
            message = f"a {self.wave.name} goes forward and back in equal times; ALPHA {alpha.value:g}"
            raise RefusalError(
                "VIB055", f"{message} ({alpha.origin})", "take WAVE TRIANGLE, or leave ALPHA at 0.5"
            )

    def form(self, segments: str) -> Form:
        """A block per base period; the wave refuses any other."""
        return "stroke" if segments == "stroke" else "tick"

    def way_out_of_too_many_blocks(self, form: Form) -> str:
        """It has a block per base period at any frequency."""
        return "take WAVE TRIANGLE, which is one block per stroke"
