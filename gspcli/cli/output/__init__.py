"""Output: tables, one file for each format, and files that are written whole."""

from gspcli.cli.output.emit import emit, write
from gspcli.cli.output.files import check_writable, write_whole
from gspcli.cli.output.options import DRAWINGS, FORMATS, Output, file_option, output_options
from gspcli.cli.output.tables import Column, Table

__all__ = [
    "DRAWINGS",
    "FORMATS",
    "Column",
    "Output",
    "Table",
    "check_writable",
    "emit",
    "file_option",
    "output_options",
    "write",
    "write_whole",
]
