"""Machine profile and options, frozen; every value knows where it came from."""

from chipbreak.settings.checking import SettingsError
from chipbreak.settings.load import load
from chipbreak.settings.profile_files import profile_names, profile_text
from chipbreak.settings.sections import Settings

__all__ = ["Settings", "SettingsError", "load", "profile_names", "profile_text"]
