#!/usr/bin/env python3
"""Prints gcovr's summary (its --json-summary on standard input) as a table: lines and branches that ran, for each folder."""
import collections
import json
import sys

KINDS = ("line", "branch")


def share(counts, kind):
    total = counts[f"{kind}_total"]
    return f"{100 * counts[f'{kind}_covered'] / total:5.1f} %" if total else "      -"


def main():
    folders = collections.defaultdict(collections.Counter)
    for file in json.load(sys.stdin)["files"]:
        for folder in (file["filename"].rpartition("/")[0], "all"):
            folders[folder].update({f"{kind}_{what}": file[f"{kind}_{what}"] for kind in KINDS for what in ("covered", "total")})
    print(f"{'folder':28}{'lines':>10}{'of':>8}{'branches':>12}{'of':>8}")
    for folder, counts in sorted(folders.items(), key=lambda item: (item[0] == "all", item[0])):
        print(f"{folder:28}{share(counts, 'line'):>10}{counts['line_total']:8}{share(counts, 'branch'):>12}{counts['branch_total']:8}")


if __name__ == "__main__":
    main()
