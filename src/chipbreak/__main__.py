"""``python -m chipbreak``."""

from chipbreak.cli import main

if __name__ == "__main__":
    main()
