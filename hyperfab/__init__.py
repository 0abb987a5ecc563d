"""Stretch fabrics as they are tested, stretched, heated and pressed into shape.

The package behind the command ``hf``. Each chapter of the production line is one subcommand
(``hyperfab.chapters``); the physics lives in packages of its own, takes arrays and opens no file.
"""

__version__ = "0.1.0"
