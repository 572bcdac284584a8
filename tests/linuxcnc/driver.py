#!/usr/bin/python3
"""Stands in for LinuxCNC's screen: switches the machine on, runs the programs, reports, ends.

Runs inside LinuxCNC with the system's Python, so it must not need anything from this project.  Reads
``jobs.json`` beside itself and writes ``report.json`` last, whole or not at all.
"""

import json
import subprocess
import sys
import time
from pathlib import Path

POLL_S = 0.004


class Screen:
    """The three channels a LinuxCNC screen has, and what they said."""

    def __init__(self, linuxcnc):
        self.api = linuxcnc
        self.command, self.status = linuxcnc.command(), linuxcnc.stat()
        self.channel = linuxcnc.error_channel()
        self.errors, self.messages = [], []

    def listen(self):
        while said := self.channel.poll():
            bad = said[0] in (self.api.OPERATOR_ERROR, self.api.NML_ERROR)
            (self.errors if bad else self.messages).append(said[1])

    def until(self, condition, limit_s, what):
        end = time.monotonic() + limit_s
        while time.monotonic() < end:
            self.status.poll()
            self.listen()
            if condition(self.status):
                return True
            time.sleep(POLL_S)
        self.errors.append("gave up waiting for " + what)
        return False

    def idle(self, status):
        return status.interp_state == self.api.INTERP_IDLE and status.queue == 0 and status.inpos

    def tell(self, function, *arguments):
        function(*arguments)
        self.command.wait_complete()

    def switch_on(self, axes):
        api, command = self.api, self.command
        if not self.until(lambda status: status.joints == axes, 20, "LinuxCNC"):
            raise RuntimeError("LinuxCNC did not come up")
        self.tell(command.state, api.STATE_ESTOP_RESET)
        self.tell(command.state, api.STATE_ON)
        self.until(lambda status: status.task_state == api.STATE_ON, 10, "machine on")
        self.tell(command.mode, api.MODE_MANUAL)
        self.tell(command.home, -1)
        if not self.until(lambda status: all(status.homed[:axes]), 20, "homing"):
            raise RuntimeError("the machine does not home")

    def to_zero(self, axes):
        self.tell(self.command.mode, self.api.MODE_MDI)
        words = "X0 Z0" if axes == 2 else "X0 Y0 Z0"
        self.tell(self.command.mdi, "G21 G90 G49 G92.1 G53 G0 " + words)
        self.until(self.idle, 60, "machine zero")

    def run(self, job, limit_s):
        self.errors, self.messages = [], []
        api, command = self.api, self.command
        self.tell(command.mode, api.MODE_AUTO)
        self.tell(command.program_open, job["program"])
        with (
            Path(job["samples"]).open("w") as out,
            subprocess.Popen(["halsampler", "-t"], stdout=out) as sampler,
        ):
            set_pin("sampler.0.enable", 1)
            # From here on halsampler reads: it has filled a buffer.
            wait_for(lambda: Path(job["samples"]).stat().st_size > 0)
            command.auto(api.AUTO_RUN, 0)
            # A short program can be over before the first look at it: do not wait for its start for ever.
            seen = time.monotonic() + 0.5
            while time.monotonic() < seen and not self.errors:
                self.status.poll()
                self.listen()
                if self.status.interp_state != api.INTERP_IDLE:
                    break
                time.sleep(POLL_S / 4)
            if not self.until(self.idle, limit_s, "the end of the program"):
                self.tell(command.abort)
            time.sleep(0.02)
            set_pin("sampler.0.enable", 0)
            wait_for(lambda: get_pin("sampler.0.curr-depth") == "0")
            time.sleep(0.05)
            sampler.terminate()
        self.listen()
        return {"errors": self.errors, "messages": self.messages}


def set_pin(name, value):
    subprocess.run(["halcmd", "setp", name, str(value)], check=True)


def get_pin(name):
    return subprocess.run(["halcmd", "getp", name], check=True, capture_output=True, text=True).stdout.strip()


def wait_for(condition, limit_s=10.0):
    end = time.monotonic() + limit_s
    while not condition() and time.monotonic() < end:
        time.sleep(POLL_S)


def main():
    import linuxcnc

    here = Path(sys.argv[0]).resolve().parent
    work = json.loads((here / "jobs.json").read_text())
    report = {"runs": [], "failure": ""}
    try:
        screen = Screen(linuxcnc)
        screen.switch_on(work["axes"])
        for job in work["jobs"]:
            screen.to_zero(work["axes"])
            report["runs"].append(screen.run(job, work["timeout_s"]))
    except Exception as problem:
        report["failure"] = repr(problem)
    part = here / "report.part"
    part.write_text(json.dumps(report))
    part.replace(here / "report.json")


if __name__ == "__main__":
    main()
