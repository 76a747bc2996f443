"""`python -m gd_analyze`, the command line."""

from gd_analyze.cli import main

if __name__ == "__main__":
    main()
