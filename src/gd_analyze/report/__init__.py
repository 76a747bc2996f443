"""Reports: one set of results, shown as terminal text, HTML and PDF."""
