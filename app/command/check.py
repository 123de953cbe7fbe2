"""The command `lensbench check FILE…`: suspicious values in lens files.

Exit status: 0 without warnings, 1 with warnings, 2 if a file holds no lens. Notes about assumptions of the
reader are printed, but do not change the status.
"""

import argparse
import json
import sys
from dataclasses import asdict
from typing import Any

CLEAN, FOUND, NO_LENS = 0, 1, 2


def add_check_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench check`."""
    parser.add_argument("files", nargs="+", metavar="FILE", help="a lens file, or a lens of the library")
    parser.add_argument("--json", action="store_true", help="print JSON: a list of files, each with its findings")


def check(arguments: argparse.Namespace) -> int:
    """Check every file, even after an error, and return the highest of their exit codes."""
    reports = [_report(name) for name in arguments.files]
    if arguments.json:
        print(json.dumps(reports, indent=2, ensure_ascii=False, allow_nan=False))
    else:
        for report in reports:
            _print(report)
    return max(_code(report) for report in reports)


def _report(name: str) -> dict[str, Any]:
    """The findings of one file, or the reason why it holds no lens."""
    import lensbench as lb
    from lensbench import lenses

    try:
        lens = lenses.load(name)
    except (lenses.LensFileError, lb.LensError) as error:
        return {"file": name, "error": " ".join(str(error).split()), "findings": []}
    return {"file": name, "error": None, "findings": [asdict(finding) for finding in lenses.check(lens)]}


def _code(report: dict[str, Any]) -> int:
    if report["error"] is not None:
        return NO_LENS
    from lensbench.lenses import Severity

    return FOUND if any(finding["severity"] is Severity.WARNING for finding in report["findings"]) else CLEAN


def _print(report: dict[str, Any]) -> None:
    """Print a line for the file, then causes, findings and notes, each with its kind, place and message."""
    if report["error"] is not None:
        print(f"lensbench: {report['error']}", file=sys.stderr)
        return
    findings = report["findings"]
    if not findings:
        print(f"{report['file']}: nothing found")
        return
    print(f"{report['file']}: {len(findings)} finding{'s' if len(findings) > 1 else ''}")
    width = max(len(finding["kind"]) for finding in findings)
    causes = [finding for finding in findings if finding["change"] is not None]
    for heading, found in (
            (f"Probable cause{'s, the most probable first' if len(causes) > 1 else ''}", causes),
            ("Findings", [f for f in findings if f["change"] is None and f["severity"] == "warning"]),
            ("Notes", [f for f in findings if f["change"] is None and f["severity"] == "note"])):
        if found and len(found) < len(findings):
            print(f" {heading}")
        for finding in found:
            place = "" if finding["surface"] is None else f"surface {finding['surface']}"
            print(f"  {finding['kind']:{width}}  {place:11}  {finding['message']}")
            if finding["proposal"]:
                print(f"  {'':{width}}  {'':11}  Proposal: {finding['proposal']}")
