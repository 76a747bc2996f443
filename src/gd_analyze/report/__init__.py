"""Reports: one context of numbers, shown as HTML and as PDF."""
