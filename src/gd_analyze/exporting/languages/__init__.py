"""One file per language: its name is the language's, its `LANGUAGE` a subclass of `Language`."""
