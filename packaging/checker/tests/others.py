"""The findings of fmpy and the FMU Manipulation Toolbox for every archive in a folder, as JSON on stdout.

For each archive: `schema`, the problems of fmpy's copy of the XML schema (null where the
description cannot be reached or parsed), and the problems of `fmpy validate` and `fmutool -check`.
Archives in the folder `mutated` are validated with the schema only.
"""

import contextlib
import io
import json
import logging
import os
import sys
import tempfile
import zipfile
from pathlib import Path

import fmpy
from fmpy.validation import validate_fmu
from lxml import etree

SCHEMA = etree.XMLSchema(
    file=str(Path(fmpy.__file__).parent / "schema" / "fmi2" / "fmi2ModelDescription.xsd")
)


def schema(file: Path) -> list[str] | None:
    try:
        with zipfile.ZipFile(file) as archive:
            root = etree.fromstring(archive.read("modelDescription.xml"))
    except Exception:
        return None
    SCHEMA.validate(root)
    return [error.message for error in SCHEMA.error_log]


def validate(file: Path) -> list[str]:
    try:
        return validate_fmu(str(file))
    except Exception as error:  # a crash counts as a rejection
        return [f"{type(error).__name__}: {error}"]


class Complaints(logging.Handler):
    """Collects what is logged as a warning or an error, each line once."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.lines: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        line = record.getMessage()
        if line not in self.lines:
            self.lines.append(line)


def fmutool(file: Path) -> list[str] | None:
    """None where the tool is not installed."""
    try:
        from fmu_manipulation_toolbox.cli.fmutool import fmutool as tool
    except ImportError:
        return None
    complaints = Complaints()
    logger = logging.getLogger("fmu_manipulation_toolbox")
    roots = [logging.getLogger(), logger]
    for root in roots:
        root.addHandler(complaints)
    arguments, sys.argv = sys.argv, ["fmutool", "-input", str(file), "-check"]
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            tool()
    except SystemExit as end:
        if end.code not in (None, 0) and not complaints.lines:
            complaints.lines.append(f"exit {end.code}")
    except Exception as error:  # a crash counts as a rejection
        complaints.lines.append(f"{type(error).__name__}: {error}")
    finally:
        sys.argv = arguments
        for root in roots:
            root.removeHandler(complaints)
    return complaints.lines


def main() -> None:
    folder = Path(sys.argv[1]).resolve()
    findings = {}
    # Some faults write outside the folder that an archive is unpacked to.
    with tempfile.TemporaryDirectory() as work:
        deep = Path(work) / "a" / "b" / "c"
        deep.mkdir(parents=True)
        os.chdir(deep)
        tempfile.tempdir = str(deep)
        for file in sorted(folder.glob("*.fmu")):
            findings[file.stem] = {
                "schema": schema(file),
                "fmpy": validate(file),
                "fmutool": fmutool(file),
            }
        os.chdir(folder)
    for file in sorted(folder.glob("mutated/*.fmu")):
        findings[f"mutated/{file.stem}"] = {"schema": schema(file)}
    json.dump(findings, sys.stdout)


if __name__ == "__main__":
    main()
