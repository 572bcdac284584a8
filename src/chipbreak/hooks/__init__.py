"""Files by which other programs call this one: CAM systems, LinuxCNC, git, editors."""
