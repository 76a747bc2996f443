"""The formats that are read, by the suffix of a case."""

from __future__ import annotations

import csv_cases
import json_cases
import log_cases
import toml_cases
import xml_cases

FORMATS = {
    "csv": csv_cases.FORMAT,
    "log": log_cases.FORMAT,
    "toml": toml_cases.FORMAT,
    "xml": xml_cases.FORMAT,
    "json": json_cases.FORMAT,
}
