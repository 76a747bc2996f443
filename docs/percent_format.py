"""Reads the tutorials: Python in the percent format, as notebooks without outputs."""

from __future__ import annotations

import ast
import re

from nbformat import NotebookNode, v4


def notebook(text: str) -> NotebookNode:
    """Make a cell of each part; the docstring becomes title and introduction."""
    title, _, introduction = (ast.get_docstring(ast.parse(text)) or "").partition(".\n")
    cells = [v4.new_markdown_cell(f"# {title}\n{introduction}")]
    for kind, part in re.findall(r"^# %%(.*)\n((?:(?!# %%).*(?:\n|\Z))*)", text, re.MULTILINE):
        if "markdown" in kind:
            cells.append(v4.new_markdown_cell(re.sub(r"^# ?", "", part, flags=re.MULTILINE)))
        else:
            cells.append(v4.new_code_cell(part.strip()))
    return v4.new_notebook(cells=cells, metadata={"language_info": {"name": "python"}})
