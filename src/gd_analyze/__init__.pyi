# What type checkers see; names are listed in public.py alone.
from gd_analyze.public import *

__version__: str
__all__: list[str]
