"""FreeCAD post-processor: another one writes the program, chipbreak filters it.

Put this file where FreeCAD looks for posts (the folder of its macros), and choose "chipbreak" as the processor
of a job.  Arguments of the job, in its Output tab:

    --base=linuxcnc       the post that writes the program
    --profile=FILE|NAME   the machine profile
    everything else goes to that post

A program that is rejected is left beside its place as NAME.rejected, with the reason, and the post fails.
"""

import importlib
import os
import shlex
import subprocess

TOOLTIP = "Another post writes the program, chipbreak breaks its chips and watches its tools."
TOOLTIP_ARGS = "--base=NAME --profile=FILE|NAME, and the arguments of the base post"
CHIPBREAK = "@CHIPBREAK@"
PROFILE = "@PROFILE@"
# The posts of FreeCAD have moved between its releases.
HOMES = ("Path.Post.scripts.{}_post", "PathScripts.post.{}_post", "{}_post")


def export(objectslist, filename, argstring):
    """What FreeCAD calls: write the program, filter it in place, and give it back."""
    base, profile, rest = _arguments(argstring)
    text = _post(base).export(objectslist, filename, rest)
    if filename in ("", "-"):
        return _filtered(text, profile)
    command = [CHIPBREAK, "filter", "-p", profile, "-i", "--reject-file", filename]
    done = subprocess.run(command, capture_output=True, text=True)
    print(done.stderr)
    if done.returncode:
        os.replace(filename, filename + ".unfiltered")
        raise RuntimeError("chipbreak rejected the program:\n" + done.stderr)
    with open(filename, encoding="utf-8", errors="replace") as file:
        return file.read()


def _arguments(argstring):
    base, profile, rest = "linuxcnc", PROFILE, []
    for word in shlex.split(argstring or ""):
        if word.startswith("--base="):
            base = word.partition("=")[2]
        elif word.startswith("--profile="):
            profile = word.partition("=")[2]
        else:
            rest.append(word)
    return base, profile, " ".join(shlex.quote(word) for word in rest)


def _post(name):
    for home in HOMES:
        try:
            return importlib.import_module(home.format(name))
        except ImportError:
            continue
    raise RuntimeError("there is no post called " + name)


def _filtered(text, profile):
    command = [CHIPBREAK, "filter", "-p", profile]
    done = subprocess.run(command, input=text.encode("utf-8"), capture_output=True)
    if done.returncode:
        raise RuntimeError("chipbreak rejected the program:\n" + done.stderr.decode("utf-8", "replace"))
    return done.stdout.decode("utf-8", "replace")
