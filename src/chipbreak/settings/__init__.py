"""Machine profile and options, frozen; every value knows where it came from."""

from chipbreak.settings.checking import SettingsError
from chipbreak.settings.load import load, profile_names, profile_text
from chipbreak.settings.sections import Settings

__all__ = ["Settings", "SettingsError", "load", "profile_names", "profile_text"]
